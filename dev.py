"""Everything a developer runs: python3 dev.py demo | command | study | test | bench | reproduce | build | docs.

Any Python from 3.8 on may start this file; it finds a Python that Blender's bpy package exists for, makes
.venv with the packages of requirements.txt, and runs the work in there. Standard library only.
"""

import argparse
import contextlib
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

HELP = """\
python3 dev.py COMMAND

  demo   [--clips BVH_FOLDER] [--blend FILE] [--out FOLDER]
         Run the whole workflow without a window and write pictures and files to FOLDER (default: demo).
  command FILE.blend -- evaluate|walk|report|export [OPTIONS]
         What Blender's command line does (--command wayfarer), without Blender; -- --help lists it all.
  study  FILE.toml [--out FOLDER] [--scheduler ADDRESS] [--workers N]
         Measure many scenes, clip sets and settings on all cores, or on a Dask cluster; start it again to go on.
  test   [PYTEST ARGUMENTS]
         Check style and types, then run the tests of the core and those inside Blender.
  bench  [NAME ...] [--json FILE]
         Measure speed and memory against the references.
  reproduce [--clips BVH_FOLDER] [--out FOLDER] [--quick]
         Section 5 of the paper with our own code: figures, numbers, an HTML report (default: in reproduce).
  build  [--platform linux-x64|windows-x64|macos-arm64 ...] [--all] [--out FOLDER]
         Make the zip that Blender installs (default: for this machine, in dist); the same source makes the same bytes.
  docs   [--out FOLDER]
         Make the reference of the core from its docstrings, as HTML (default: in dist/docs).

The first start makes .venv (about 500 MB of downloads, 2 GB on disk); delete .venv to start afresh.
"""

ROOT = Path(__file__).resolve().parent
REQUIREMENTS = ROOT / "requirements.txt"
MANIFEST = ROOT / "blender_manifest.toml"
EXTENSION_ID = "wayfarer"
# What Blender needs of the checkout; everything else is for developers.
SHIPPED = ("__init__.py", "blender_manifest.toml", "LICENSE", "README.md", "addon", "assets", "core")

VENV = ROOT / ".venv"
VENV_PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
# Holds a hash of requirements.txt once everything in it is installed.
STAMP = VENV / "wayfarer-installed"
# Lies in .venv while packages are being installed: found at the start, it tells of an interruption.
UNFINISHED = VENV / "wayfarer-unfinished"
# The Pythons that bpy has a wheel for, see requirements.txt.
SUITABLE_PYTHONS = ("3.11", "3.13")

# SciPy wheels per platform: the tags to ask the package index for, and the Pythons of the Blender versions
# supported there: 3.11 in 4.5 and 5.0, 3.13 in 5.1 and 5.2, 3.14 where a Linux distribution builds Blender.
WHEELS = ROOT / "wheels"
WHEEL_TAGS = {
    "linux-x64": (("manylinux_2_27_x86_64", "manylinux_2_28_x86_64"), ("3.11", "3.13", "3.14")),
    "windows-x64": (("win_amd64",), ("3.11", "3.13")),
    "macos-arm64": (("macosx_12_0_arm64",), ("3.11", "3.13")),
    "windows-arm64": (("win_arm64",), ("3.11", "3.13")),
    # Blender 4.5 is the last one for Intel.
    "macos-x64": (("macosx_10_14_x86_64",), ("3.11",)),
}


class Trouble(Exception):
    """What stops a command, as a sentence for the person at the keyboard."""


def main(arguments):
    commands = {
        "demo": demo,
        "command": command_line,
        "study": study,
        "test": test,
        "bench": bench,
        "build": build,
        "docs": docs,
    }
    commands["reproduce"] = reproduce
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(HELP, end="")
        return 0
    command = commands.get(arguments[0])
    if command is None:
        print(f"There is no command '{arguments[0]}'.\n\n{HELP}", end="", file=sys.stderr)
        return 2
    try:
        return command(arguments[1:])
    except Trouble as trouble:
        print(f"dev.py: {trouble}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("dev.py: stopped.", file=sys.stderr)
        return 130


# ---------------------------------------------------------------------------------------------- commands


def demo(arguments):
    parser = argparse.ArgumentParser(prog="dev.py demo", description="Run the whole workflow, windowless.")
    parser.add_argument("--clips", metavar="BVH_FOLDER", type=Path, help="use these motions")
    parser.add_argument("--blend", metavar="FILE", type=Path, help="use this scene and its actions")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=Path("demo"), help="default: demo")
    known, others = parser.parse_known_args(arguments)
    # The demo runs inside Blender, where relative paths mean something else.
    paths = [("--clips", known.clips), ("--blend", known.blend), ("--out", known.out)]
    options = [word for name, path in paths if path for word in (name, str(path.resolve()))]
    set_up()
    with blender_resources() as environment:
        return run_script(ROOT / "addon" / "demo.py", options + others, environment)


def reproduce(arguments):
    # The reproduction runs inside Blender, where relative paths mean something else.
    words = list(arguments)
    for index, word in enumerate(words[:-1]):
        if word in ("--clips", "--out"):
            words[index + 1] = str(Path(words[index + 1]).resolve())
    set_up()
    with blender_resources() as environment:
        return run_script(ROOT / "addon" / "reproduce.py", words, environment)


def command_line(arguments):
    words = list(arguments)
    if not words or words[0] in ("-h", "--help"):
        words = ["--", "--help"]
    if words[0] != "--":
        words[0] = str(Path(words[0]).resolve())
    set_up()
    with blender_resources() as environment:
        return run_script(ROOT / "addon" / "run_command.py", words, environment)


def study(arguments):
    # Help too is asked of the command, which knows its options.
    set_up()
    with blender_resources() as environment:
        return run_script(ROOT / "addon" / "run_command.py", ["--", "study", *arguments], environment)


def bench(arguments):
    parser = argparse.ArgumentParser(prog="dev.py bench", description="Measure speed and memory.")
    parser.add_argument("names", metavar="NAME", nargs="*", help="which problems; default: all")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the records to this file as well")
    known, others = parser.parse_known_args(arguments)
    options = ["--json", str(known.json.resolve())] if known.json else []
    set_up()
    environment = dict(os.environ, PYTHONPATH=str(ROOT))
    return run_script(ROOT / "tests" / "bench" / "run.py", known.names + options + others, environment)


def test(arguments):
    if "--help" in arguments or "-h" in arguments:
        print(
            "python3 dev.py test [PYTEST ARGUMENTS]\n\n"
            "Without paths: style, types, core tests, Blender tests, and the workflow in Blender's window if\n"
            "WAYFARER_BLENDER_ROOT (default /opt/blender-sid) holds a system with Blender. With paths: only the tests\n"
            "named.\n"
            "Every other argument goes to pytest, for example: -k NAME, -x, --durations 10."
        )
        return 0
    core_folder, blender_folder = ROOT / "tests" / "core", ROOT / "tests" / "blender"
    window_folder = ROOT / "tests" / "window"
    paths, options = split_test_paths(arguments)
    core_paths = paths_inside(core_folder, paths)
    blender_paths = paths_inside(blender_folder, paths)
    window_paths = paths_inside(window_folder, paths)
    for path in paths:
        if not any(paths_inside(folder, [path]) for folder in (core_folder, blender_folder, window_folder)):
            raise Trouble(f"{path} holds no tests; name a path in tests/core, tests/blender or tests/window.")
    set_up()

    sources = ["core", "addon", "docs", "tests", "dev.py", "__init__.py"]
    sources = [name for name in sources if (ROOT / name).exists()]
    results = []
    if not paths:
        results.append(run_part("style", ["ruff", "check", *sources]))
        results.append(run_part("format", ["ruff", "format", "--check", *sources]))
        results.append(run_part("types", ["basedpyright", "--pythonpath", str(VENV_PYTHON)]))
        core_paths, blender_paths, window_paths = [str(core_folder)], [str(blender_folder)], [str(window_folder)]
    # Two processes: loaded as `core` and as part of the extension, the same class would exist twice.
    if core_paths:
        results.append(run_part("core tests", ["pytest", *options, *core_paths]))
    if blender_paths:
        with blender_resources() as environment:
            results.append(run_part("Blender tests", ["pytest", *options, *blender_paths], environment))
    if window_paths:
        # Says why where there is no window.
        results.append(run_part("window tests", ["pytest", "-rs", *options, *window_paths]))
    return summarize(results, selected=bool(arguments))


def build(arguments):
    parser = argparse.ArgumentParser(prog="dev.py build", description="Make the zip that Blender installs.")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--platform", action="append", nargs="+", choices=WHEEL_TAGS, dest="platforms")
    which.add_argument("--all", action="store_true", help="for every platform, one zip each")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=ROOT / "dist", help="default: dist")
    options = parser.parse_args(arguments)
    if options.all:
        platforms = list(WHEEL_TAGS)
    else:
        platforms = [name for names in options.platforms or [[this_platform()]] for name in names]
    out = options.out.resolve()
    set_up()
    out.mkdir(parents=True, exist_ok=True)
    version = re.search(r'^version = "(.+)"', MANIFEST.read_text("utf-8"), re.MULTILINE).group(1)
    for name in platforms:
        archive = out / f"{EXTENSION_ID}-{version}-{name}.zip"
        build_archive(name, download_wheels(name), archive)
        print(f"{archive}  {archive.stat().st_size / 1e6:.1f} MB", flush=True)
    return 0


def docs(arguments):
    parser = argparse.ArgumentParser(prog="dev.py docs", description="Make the reference of the core, as HTML.")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=ROOT / "dist" / "docs", help="default: dist/docs")
    out = parser.parse_args(arguments).out.resolve()
    set_up()
    if subprocess.call([str(VENV_PYTHON), "-c", "import sphinx"], stderr=subprocess.DEVNULL) != 0:
        say("installing Sphinx")
        pip(["install", "--requirement", str(ROOT / "docs" / "requirements.txt")])
    environment = dict(os.environ, SPHINX_APIDOC_OPTIONS="members,show-inheritance", PYTHONDONTWRITEBYTECODE="1")
    with tempfile.TemporaryDirectory() as pages:
        listing = ["sphinx.ext.apidoc", "-q", "--separate", "--module-first", "--maxdepth", "2"]
        listing += ["--tocfile", "index", "--output-dir", pages, str(ROOT / "core")]
        html = ["sphinx", "--quiet", "--fail-on-warning", "--keep-going", "--builder", "html"]
        html += ["--conf-dir", str(ROOT / "docs"), pages, str(out)]
        for module_and_arguments in (listing, html):
            if subprocess.call([str(VENV_PYTHON), "-m", *module_and_arguments], env=environment) != 0:
                raise Trouble("Sphinx found what its lines above say; correct these docstrings.")
    print(out / "index.html", flush=True)
    return 0


# ------------------------------------------------------------------------------------------- test helpers


def split_test_paths(arguments):
    """The arguments of pytest as (paths, made absolute; everything else)."""
    paths, options, previous = [], [], ""
    for argument in arguments:
        name, colons, test_id = argument.partition("::")
        found = [base / name for base in (Path.cwd(), ROOT) if (base / name).exists()]
        # `-k core` selects by name, although a folder `core` exists.
        if argument.startswith("-") or previous in ("-k", "-m", "-p", "-c", "-o"):
            options.append(argument)
        elif name and found:
            paths.append(str(found[0].resolve()) + colons + test_id)
        elif "/" in name or name.endswith(".py"):
            raise Trouble(f"There is no {name}; name a path in tests/core or tests/blender.")
        else:
            options.append(argument)
        previous = argument
    return paths, options


def paths_inside(folder, paths):
    """Those of the paths that lie in the folder; the folder itself for a path that contains it."""
    inside = []
    for path in paths:
        location = Path(path.partition("::")[0])
        if folder == location or folder in location.parents:
            inside.append(path)
        elif location in folder.parents:
            inside.append(str(folder))
    return inside


def run_part(name, module_and_arguments, environment=None):
    print(f"\n== {name}", flush=True)
    start = time.monotonic()
    code = subprocess.call([str(VENV_PYTHON), "-m", *module_and_arguments], cwd=ROOT, env=environment)
    return name, code, time.monotonic() - start


def summarize(results, selected):
    no_tests = 5  # pytest's exit code where a selection matches nothing in one of the two folders
    all_empty = all(code == no_tests for _, code, _ in results)
    passed = True
    print()
    for name, code, seconds in results:
        if code == no_tests and selected and not all_empty:
            verdict = "no tests selected"
        else:
            verdict = "passed" if code == 0 else f"FAILED (exit code {code})"
            passed = passed and code == 0
        print(f"{name:14} {seconds:6.1f} s  {verdict}")
    return 0 if passed else 1


# ---------------------------------------------------------------------------------------------- extension


@contextlib.contextmanager
def blender_resources():
    """An environment in which Blender finds this checkout as an extension, and nothing of the user's."""
    folder = Path(tempfile.mkdtemp(prefix="wayfarer-blender-"))
    try:
        link_extension(folder)
        yield dict(os.environ, BLENDER_USER_RESOURCES=str(folder))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def link_extension(resources):
    """Put this checkout where Blender looks for the extension bl_ext.user_default.wayfarer."""
    link = Path(resources) / "extensions" / "user_default" / EXTENSION_ID
    if link.exists():
        return
    link.parent.mkdir(parents=True, exist_ok=True)
    try:
        link.symlink_to(ROOT, target_is_directory=True)
    except OSError:
        # Windows allows links to developers and administrators only.
        copy_shipped(link)


def copy_shipped(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name in SHIPPED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__", ".*"))
        elif source.exists():
            shutil.copy2(source, folder / name)


def this_platform():
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}.get(platform.system(), "unknown")
    machine = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    name = f"{system}-{machine}"
    if name not in WHEEL_TAGS:
        raise Trouble(f"Wayfarer is not built for {name}; choose with --platform from {', '.join(WHEEL_TAGS)}.")
    return name


def download_wheels(platform_name):
    """The SciPy wheels that the extension brings to one platform, kept in the folder wheels."""
    tags, pythons = WHEEL_TAGS[platform_name]
    for python in missing_wheels(platform_name):
        say(f"downloading SciPy {scipy_version()} for Python {python} on {platform_name}")
        command = ["download", "scipy==" + scipy_version(), "--no-deps", "--only-binary=:all:"]
        command += ["--implementation", "cp", "--python-version", python]
        command += [word for tag in tags for word in ("--platform", tag)]
        WHEELS.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(dir=WHEELS) as partial:
            pip([*command, "--dest", partial])
            for wheel in Path(partial).glob(wheel_pattern(platform_name, python)):
                wheel.replace(WHEELS / wheel.name)
    missing = missing_wheels(platform_name)
    if missing:
        raise Trouble(f"SciPy {scipy_version()} has no wheel for Python {', '.join(missing)} on {platform_name}.")
    return [next(WHEELS.glob(wheel_pattern(platform_name, python))) for python in pythons]


def missing_wheels(platform_name):
    """The Pythons that the folder wheels holds no SciPy for."""
    _, pythons = WHEEL_TAGS[platform_name]
    return [python for python in pythons if not list(WHEELS.glob(wheel_pattern(platform_name, python)))]


def wheel_pattern(platform_name, python):
    abi = "cp" + python.replace(".", "")
    return f"scipy-{scipy_version()}-{abi}-{abi}-*{WHEEL_TAGS[platform_name][0][0]}*.whl"


def scipy_version():
    return re.search(r"^scipy==(\S+)", REQUIREMENTS.read_text("utf-8"), re.MULTILINE).group(1)


def build_archive(platform_name, wheels, archive):
    """Make and validate one zip with Blender's own tool, from a copy whose manifest names the wheels."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / EXTENSION_ID
        copy_shipped(source)
        (source / "wheels").mkdir()
        for wheel in wheels:
            shutil.copy2(wheel, source / "wheels")
        names = "".join(f'  "./wheels/{wheel.name}",\n' for wheel in wheels)
        added = f'platforms = ["{platform_name}"]\nwheels = [\n{names}]\n'
        # Top-level keys stand before the first table.
        keys, bracket, tables = MANIFEST.read_text("utf-8").partition("\n[")
        (source / MANIFEST.name).write_text(f"{keys}{added}{bracket}{tables}", "utf-8")
        say(f"building {archive.name}")
        made = Path(folder) / archive.name
        blender_tool(["build", "--source-dir", str(source), "--output-filepath", str(made)])
        arranged = archive.with_name("." + archive.name)
        arrange_archive(made, arranged)
        blender_tool(["validate", str(arranged)])
        arranged.replace(archive)


def arrange_archive(source, archive):
    """Copy a zip so that the same files make the same bytes: Blender's tool keeps file times and the disk's order."""
    with zipfile.ZipFile(str(source)) as made, zipfile.ZipFile(str(archive), "w") as arranged:
        for entry in sorted(made.infolist(), key=lambda entry: entry.filename):
            fixed = zipfile.ZipInfo(entry.filename, (1980, 1, 1, 0, 0, 0))
            fixed.compress_type = entry.compress_type
            fixed.create_system = 3  # as on Unix, on Windows too
            fixed.external_attr = 0o100644 << 16
            arranged.writestr(fixed, made.read(entry), compresslevel=9)


def blender_tool(arguments):
    """Run Blender's command for extensions, which comes with bpy and needs no Blender."""
    packages = "Lib/site-packages" if os.name == "nt" else "lib/python3*/site-packages"
    scripts = next(VENV.glob(packages + "/bpy/*/scripts"), None)
    if scripts is None:
        raise Trouble("There is no Blender in .venv; delete the folder .venv and run this again.")
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    tags = scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    command = [str(VENV_PYTHON), str(tool), arguments[0], "--valid-tags", str(tags), *arguments[1:]]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        raise Trouble(f"Blender's extension tool refused to {arguments[0]} it:\n{result.stdout.strip()}")


# ------------------------------------------------------------------------------------------------- set-up


def set_up():
    """Make .venv hold what requirements.txt says; next to no time where it already does."""
    wanted = hashlib.sha256(REQUIREMENTS.read_bytes()).hexdigest()
    if VENV_PYTHON.exists() and STAMP.exists() and STAMP.read_text("utf-8") == wanted:
        return
    start = time.monotonic()
    if UNFINISHED.exists() or probe([str(VENV_PYTHON)], "pip") is None:
        make_venv()
    UNFINISHED.touch()
    STAMP.unlink(missing_ok=True)
    say("installing the packages of requirements.txt (about 500 MB if none of them was downloaded before)")
    install_packages()
    STAMP.write_text(wanted, "utf-8")
    UNFINISHED.unlink()
    say(f"ready after {time.monotonic() - start:.0f} s")


def make_venv():
    python = find_python()
    if VENV.exists():
        say("removing the .venv that is incomplete or does not work")
        shutil.rmtree(VENV, ignore_errors=True)
        if VENV_PYTHON.exists():
            raise Trouble("The folder .venv is in use; close the programs that use it and run this again.")
    VENV.mkdir(exist_ok=True)
    UNFINISHED.touch()
    if python is not None:
        say(f"making .venv with {python}")
        command = [python, "-m", "venv", str(VENV)]
    else:
        say("making .venv with the Python 3.11 of uv")
        command = ["uv", "venv", "--allow-existing", "--seed", "--python", "3.11", str(VENV)]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0 or probe([str(VENV_PYTHON)], "pip") is None:
        raise Trouble(
            f"{' '.join(command)} failed:\n{result.stdout.strip()}\n"
            "Install Python 3.11 from python.org (Debian, Ubuntu: apt install python3.11-venv), "
            "then run this again."
        )


def find_python():
    """The path of a Python that bpy exists for and that can make a venv; None: uv can bring one."""
    # Not the .venv that this may be running in, which is about to be removed.
    candidates = [[getattr(sys, "_base_executable", sys.executable)]]
    for version in SUITABLE_PYTHONS:
        # Every one on the PATH: the first may be a version manager's placeholder that only prints an error.
        candidates += [[path] for path in on_path("python" + version)]
        if os.name == "nt":
            candidates.append(["py", "-" + version])
    for candidate in candidates:
        python = probe(candidate)
        if python is not None:
            return python
    if shutil.which("uv"):
        command = ["uv", "python", "find", "--system", "3.11"]
        found = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        return probe([found.stdout.strip()]) if found.returncode == 0 else None
    raise Trouble(
        "Wayfarer needs Python 3.11 or 3.13 with its venv module (Blender's bpy package exists for no other) "
        f"and found neither; this is {platform.python_version()}. Install Python 3.11 from python.org "
        "(Debian, Ubuntu: apt install python3.11-venv), or uv, and run this again."
    )


def on_path(name):
    suffix = ".exe" if os.name == "nt" else ""
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    paths = [Path(folder) / (name + suffix) for folder in folders if folder]
    return [str(path) for path in paths if path.is_file() and VENV not in path.parents]


def probe(command, modules="venv, ensurepip"):
    """The executable behind the command, if it really runs, is suitable and has the modules; else None."""
    code = f"import sys, {modules}; print('%d.%d' % sys.version_info[:2]); print(sys.executable)"
    try:
        result = subprocess.run(
            [*command, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=60
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    lines = result.stdout.split("\n")
    return lines[1].strip() if result.returncode == 0 and lines[0].strip() in SUITABLE_PYTHONS else None


def install_packages():
    try:
        pip(["install", "--requirement", str(REQUIREMENTS)])
    except InstallTrouble as trouble:
        # Where pip stopped before it touched anything, the packages that are there need no repair.
        if not trouble.began:
            UNFINISHED.unlink()
        raise


class InstallTrouble(Trouble):
    """pip failed; ``began`` tells whether it had already begun to change .venv."""

    def __init__(self, sentence, began):
        super().__init__(sentence)
        self.began = began


def pip(arguments):
    """Run pip in .venv, showing only the large downloads; its last words if it fails."""
    command = [str(VENV_PYTHON), "-m", "pip", *arguments]
    command += ["--disable-pip-version-check", "--progress-bar", "off"]
    lines = []
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", errors="replace"
    ) as process:
        for line in process.stdout:
            lines.append(line.rstrip())
            large = re.match(r"\s*Downloading (\w+-[\d.]+)\S* \(([\d.]+ MB)\)", line)
            if large:
                say(f"  downloading {large.group(1)}, {large.group(2)}")
            elif line.startswith("Installing collected packages"):
                say("  unpacking")
    if process.returncode != 0:
        last = "\n".join(f"  {line}" for line in lines[-8:])
        raise InstallTrouble(
            f"pip failed, its last lines were:\n{last}\n"
            "Check the network and the free disk space (2 GB) and run this again; bpy exists for Linux x64, "
            "Windows x64 and macOS on Apple silicon.",
            began=any(line.startswith("Installing collected packages") for line in lines),
        )


def run_script(script, arguments, environment):
    if not script.exists():
        raise Trouble(f"{script.relative_to(ROOT)} is missing; this checkout is not complete.")
    return subprocess.call([str(VENV_PYTHON), str(script), *arguments], env=environment)


def say(step):
    print(f"[dev.py] {step}", flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
