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
  test   [--blender VERSION] [PYTEST ARGUMENTS]
         Check style, types and docstrings, and run the tests of the core, with the newest Python as well, and those
         inside Blender; with --blender 4.5 (or another that requirements.txt names) only those inside, in that version.
  bench  [NAME ...] [--json FILE]
         Measure speed and memory against the references.
  reproduce [--clips BVH_FOLDER] [--out FOLDER] [--quick]
         Section 5 of the paper with our own code: figures, numbers, an HTML report (default: in reproduce).
  build  [--platform linux-x64|windows-x64|macos-arm64 ...] [--all] [--out FOLDER]
         Make the zip that Blender installs (default: for this machine, in dist); the same source makes the same bytes.
  docs   [--out FOLDER]
         Make the reference of the core from its docstrings, as HTML (default: in dist/docs).

The first start makes .venv (about 500 MB of downloads, 2 GB on disk), the first test .venv-core as well (80 MB, 350 MB
on disk); delete them to start afresh.
"""

ROOT = Path(__file__).resolve().parent
REQUIREMENTS = ROOT / "requirements.txt"
MANIFEST = ROOT / "blender_manifest.toml"
EXTENSION_ID = "wayfarer"
# What Blender needs of the checkout; everything else is for developers.
SHIPPED = (
    "__init__.py",
    "blender_manifest.toml",
    "LICENSE",
    "README.md",
    "CHANGELOG.md",
    "addon",
    "assets",
    "core",
    "docs",
)

# The Pythons that bpy has a wheel for, see requirements.txt.
BPY_PYTHONS = ("3.11", "3.13")
# What the tests of the core need, and the Pythons that all of it has wheels for, newest first.
CORE_PACKAGES = ("numpy", "scipy", "pytest", "hypothesis", "networkx", "matplotlib")
CORE_PYTHONS = ("3.14", "3.13", "3.12")

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
    """An error that stops a command, as a sentence for the person at the keyboard."""


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
    options = [word for name, path in paths if path for word in (name, os.path.realpath(path))]
    return run_in_blender("demo", options + others)


def reproduce(arguments):
    # The reproduction runs inside Blender, where relative paths mean something else.
    words = list(arguments)
    for index, word in enumerate(words[:-1]):
        if word in ("--clips", "--out"):
            words[index + 1] = os.path.realpath(words[index + 1])
    return run_in_blender("reproduce", words)


def command_line(arguments):
    words = list(arguments)
    if not words or words[0] in ("-h", "--help"):
        words = ["--", "--help"]
    if words[0] != "--":
        words[0] = os.path.realpath(words[0])
    return run_in_blender("command", words)


def study(arguments):
    # Help too is asked of the command, which knows its options.
    return run_in_blender("command", ["--", "study", *arguments])


def bench(arguments):
    parser = argparse.ArgumentParser(prog="dev.py bench", description="Measure speed and memory.")
    parser.add_argument("names", metavar="NAME", nargs="*", help="which problems; default: all")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the records to this file as well")
    known, others = parser.parse_known_args(arguments)
    options = ["--json", os.path.realpath(known.json)] if known.json else []
    environment = dict(os.environ, PYTHONPATH=str(ROOT))
    return run_script(ROOT / "tests" / "bench" / "run.py", known.names + options + others, environment)


def test(arguments):
    return subprocess.call(
        [sys.executable, str(ROOT / "tests" / "run.py"), *arguments], env=dict(os.environ, PYTHONPATH=str(ROOT))
    )


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
    out = Path(os.path.realpath(options.out))
    python = main_python()
    out.mkdir(parents=True, exist_ok=True)
    version = re.search(r'^version = "(.+)"', MANIFEST.read_text("utf-8"), re.MULTILINE).group(1)
    for name in platforms:
        archive = out / f"{EXTENSION_ID}-{version}-{name}.zip"
        build_archive(name, download_wheels(name, python), archive, python)
        print(f"{archive}  {archive.stat().st_size / 1e6:.1f} MB", flush=True)
    return 0


def docs(arguments):
    parser = argparse.ArgumentParser(prog="dev.py docs", description="Make the reference of the core, as HTML.")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=ROOT / "dist" / "docs", help="default: dist/docs")
    out = Path(os.path.realpath(parser.parse_args(arguments).out))
    python = main_python()
    environment = dict(os.environ, SPHINX_APIDOC_OPTIONS="members,show-inheritance", PYTHONDONTWRITEBYTECODE="1")
    with tempfile.TemporaryDirectory() as pages:
        listing = ["sphinx.ext.apidoc", "-q", "--separate", "--module-first", "--maxdepth", "2"]
        listing += ["--tocfile", "index", "--output-dir", pages, str(ROOT / "core")]
        html = ["sphinx", "--quiet", "--fail-on-warning", "--keep-going", "--builder", "html"]
        html += ["--conf-dir", str(ROOT / "docs"), pages, str(out)]
        for module_and_arguments in (listing, html):
            if subprocess.call([python, "-m", *module_and_arguments], env=environment) != 0:
                raise Trouble("Sphinx found what its lines above say; correct these docstrings.")
    print(out / "index.html", flush=True)
    return 0


# ---------------------------------------------------------------------------------- the versions of Blender


def blenders():
    """Version of Blender -> (its bpy as a requirement, the Python that it needs), as requirements.txt names them."""
    pattern = r'^(?:# )?(bpy==(\d+\.\d+)\.\d+); python_version == "([\d.]+)"$'
    found = re.findall(pattern, REQUIREMENTS.read_text("utf-8"), re.MULTILINE)
    return {version: (bpy, python) for bpy, version, python in sorted(found)}


def other_pythons():
    """The Python of each .venv-VERSION that is complete."""
    venvs = map(blender_venv, blenders())
    return [venv.python for venv in venvs if venv.stamp.exists()]


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


def keep_inner_links(folder):
    """In the pages of what is shipped, make plain words of links to files that stay behind."""
    for page in folder.rglob("*.md"):

        def link_or_words(link, page=page):
            words, target = link.groups()
            path = target.partition("#")[0]
            is_there = not path or re.match(r"[a-z]+:", path) or (page.parent / path).exists()
            return link.group() if is_there else words

        text = re.sub(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)", link_or_words, page.read_text("utf-8"))
        page.write_bytes(text.encode("utf-8"))


def this_platform():
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}.get(platform.system(), "unknown")
    machine = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    name = f"{system}-{machine}"
    if name not in WHEEL_TAGS:
        raise Trouble(f"Wayfarer is not built for {name}; choose with --platform from {', '.join(WHEEL_TAGS)}.")
    return name


def download_wheels(platform_name, python):
    """The SciPy wheels that the extension brings to one platform, kept in the folder wheels."""
    tags, versions = WHEEL_TAGS[platform_name]
    for version in missing_wheels(platform_name):
        say(f"downloading SciPy {scipy_version()} for Python {version} on {platform_name}")
        command = ["download", "scipy==" + scipy_version(), "--no-deps", "--only-binary=:all:"]
        command += ["--implementation", "cp", "--python-version", version]
        command += [word for tag in tags for word in ("--platform", tag)]
        WHEELS.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(dir=WHEELS) as partial:
            pip(python, [*command, "--dest", partial])
            for wheel in Path(partial).glob(wheel_pattern(platform_name, version)):
                check_wheel(wheel)
                wheel.replace(WHEELS / wheel.name)
    missing = missing_wheels(platform_name)
    if missing:
        raise Trouble(f"SciPy {scipy_version()} has no wheel for Python {', '.join(missing)} on {platform_name}.")
    wheels = [next(WHEELS.glob(wheel_pattern(platform_name, version))) for version in versions]
    for wheel in wheels:
        check_wheel(wheel)
    return wheels


def check_wheel(wheel):
    """Trouble unless the wheel is, to the last byte, one that requirements.txt names."""
    named = re.search(rf"^# ([0-9a-f]{{64}})  {re.escape(wheel.name)}$", REQUIREMENTS.read_text("utf-8"), re.MULTILINE)
    if named is None:
        raise Trouble(f"requirements.txt has no SHA-256 for {wheel.name}; add it, if you trust where it comes from.")
    if hashlib.sha256(wheel.read_bytes()).hexdigest() != named.group(1):
        raise Trouble(
            f"{wheel.name} is not the file that requirements.txt names: its SHA-256 is another. Delete it from the "
            "folder wheels if it is there, and build again; if it comes again, do not use it."
        )


def missing_wheels(platform_name):
    """The Pythons that the folder wheels holds no SciPy for."""
    _, versions = WHEEL_TAGS[platform_name]
    return [version for version in versions if not list(WHEELS.glob(wheel_pattern(platform_name, version)))]


def wheel_pattern(platform_name, version):
    abi = "cp" + version.replace(".", "")
    return f"scipy-{scipy_version()}-{abi}-{abi}-*{WHEEL_TAGS[platform_name][0][0]}*.whl"


def scipy_version():
    return re.search(r"^scipy==(\S+)", REQUIREMENTS.read_text("utf-8"), re.MULTILINE).group(1)


def build_archive(platform_name, wheels, archive, python):
    """Make and validate one zip with the tool of a Python's bpy, from a copy whose manifest names the wheels."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / EXTENSION_ID
        copy_shipped(source)
        keep_inner_links(source)
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
        blender_tool(python, ["build", "--source-dir", str(source), "--output-filepath", str(made)])
        arranged = archive.with_name("." + archive.name)
        arrange_archive(made, arranged)
        blender_tool(python, ["validate", str(arranged)])
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


def blender_tool(python, arguments):
    """Run Blender's command for extensions, which comes with bpy and needs no Blender."""
    folder = Path(python).parents[1]
    packages = "Lib/site-packages" if os.name == "nt" else "lib/python3*/site-packages"
    scripts = next(folder.glob(packages + "/bpy/*/scripts"), None)
    if scripts is None:
        raise Trouble(f"There is no Blender in {folder.name}; delete the folder {folder.name} and run this again.")
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    tags = scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    command = [python, str(tool), arguments[0], "--valid-tags", str(tags), *arguments[1:]]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        raise Trouble(f"Blender's extension tool refused to {arguments[0]} it:\n{result.stdout.strip()}")


# ------------------------------------------------------------------------------------------------- set-up


class Venv:
    """A folder of the checkout with a Python and packages of its own.

    ``pythons`` are the versions to choose from, the best first; ``requirements`` is what pip is to install.
    """

    def __init__(self, name, pythons, requirements):
        self.name, self.pythons, self.requirements = name, tuple(pythons), requirements
        self.folder = ROOT / name
        self.python = self.folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        # Holds a hash of the requirements once all of them are installed.
        self.stamp = self.folder / "wayfarer-installed"
        # Lies there while packages are being installed: found at the start, it tells of an interruption.
        self.unfinished = self.folder / "wayfarer-unfinished"
        self.lock = self.folder / "wayfarer-lock"

    def is_ready(self):
        wanted = hashlib.sha256(self.requirements.encode("utf-8")).hexdigest()
        return self.python.exists() and self.stamp.exists() and self.stamp.read_text("utf-8") == wanted

    def set_up(self):
        """Make the folder hold what it should, in next to no time where it already does; returns its Python."""
        if not self.is_ready():
            self.folder.mkdir(exist_ok=True)
            with only_one(self.lock):
                # Another dev.py, waited for, may have done it.
                if not self.is_ready():
                    self.make_ready()
        return str(self.python)

    def make_ready(self):
        start = time.monotonic()
        if self.unfinished.exists() or probe([str(self.python)], self.pythons, "pip") is None:
            self.make()
        self.unfinished.touch()
        self.stamp.unlink(missing_ok=True)
        say(f"installing packages into {self.name}")
        self.install()
        self.stamp.write_text(hashlib.sha256(self.requirements.encode("utf-8")).hexdigest(), "utf-8")
        self.unfinished.unlink()
        say(f"{self.name} is ready after {time.monotonic() - start:.0f} s")

    def make(self):
        python = find_python(self.pythons)
        if python is None and not shutil.which("uv"):
            raise Trouble(
                f"Wayfarer needs Python {' or '.join(self.pythons)} with its venv module (Blender's bpy package exists "
                f"for no other) and found none; this is {platform.python_version()}. {self.how_to_get_python()}, or "
                "uv, and run this again."
            )
        if self.python.exists():
            say(f"removing the {self.name} that is incomplete or does not work")
        for entry in self.folder.iterdir():
            if entry.is_dir() and not entry.is_symlink():
                shutil.rmtree(entry, ignore_errors=True)
            elif entry != self.lock:
                entry.unlink()
        if self.python.exists():
            raise Trouble(f"The folder {self.name} is in use; close the programs that use it and run this again.")
        self.unfinished.touch()
        if python is not None:
            say(f"making {self.name} with {python}")
            command = [python, "-m", "venv", str(self.folder)]
        else:
            say(f"making {self.name} with the Python {self.pythons[0]} of uv")
            command = ["uv", "venv", "--allow-existing", "--seed", "--python", self.pythons[0], str(self.folder)]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if result.returncode != 0 or probe([str(self.python)], self.pythons, "pip") is None:
            said = f"{' '.join(command)} failed:\n{result.stdout.strip()}"
            raise Trouble(f"{said}\n{self.how_to_get_python()}, then run this again.")

    def how_to_get_python(self):
        python = self.pythons[0]
        return f"Install Python {python} from python.org (Debian, Ubuntu: apt install python{python}-venv)"

    def install(self):
        with tempfile.TemporaryDirectory() as folder:
            listing = Path(folder) / REQUIREMENTS.name
            listing.write_text(self.requirements, "utf-8")
            try:
                pip(self.python, ["install", "--requirement", str(listing)])
            except InstallTrouble as trouble:
                # Where pip stopped before it touched anything, the packages that are there need no repair.
                if not trouble.began:
                    self.unfinished.unlink()
                raise


def main_python():
    """The Python of .venv, with everything in it; made from the one that runs this, if bpy exists for it."""
    running = platform.python_version().rpartition(".")[0]
    pythons = sorted(BPY_PYTHONS, key=lambda version: version != running)
    return Venv(".venv", pythons, REQUIREMENTS.read_text("utf-8")).set_up()


def blender_venv(version):
    """.venv-VERSION: with that Blender, and else with what requirements.txt says."""
    bpy, python = blenders()[version]
    lines = [line for line in REQUIREMENTS.read_text("utf-8").splitlines() if not re.match(r"(# )?bpy==", line)]
    return Venv(f".venv-{version}", [python], "\n".join([bpy, *lines, ""]))


def core_venv():
    """.venv-core: without Blender, and with the newest Python that there is."""
    named = rf"^(?:{'|'.join(CORE_PACKAGES)})==.*\n"
    return Venv(".venv-core", CORE_PYTHONS, "".join(re.findall(named, REQUIREMENTS.read_text("utf-8"), re.MULTILINE)))


def find_python(versions):
    """The path of a Python of the first version that there is with the means to make a venv; None: there is none."""
    for version in versions:
        candidates = []
        if platform.python_version().startswith(version + "."):
            # Not the .venv that this may be running in, which is about to be removed.
            candidates.append([getattr(sys, "_base_executable", sys.executable)])
        # Every one on the PATH: the first may be a version manager's placeholder that only prints an error.
        candidates += [[path] for path in on_path("python" + version)]
        if os.name == "nt":
            candidates.append(["py", "-" + version])
        # pyenv puts only those on the PATH that somebody has chosen.
        pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
        candidates += [[str(path)] for path in sorted(pyenv.glob(version + ".*/bin/python"))]
        if shutil.which("uv"):
            command = ["uv", "python", "find", "--system", "--no-python-downloads", version]
            found = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            candidates += [[found.stdout.strip()]] if found.returncode == 0 else []
        for candidate in candidates:
            python = probe(candidate, [version])
            if python is not None:
                return python
    return None


def on_path(name):
    suffix = ".exe" if os.name == "nt" else ""
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    paths = [Path(folder) / (name + suffix) for folder in folders if folder]
    ours = [ROOT / ".venv", *ROOT.glob(".venv-*")]
    return [str(path) for path in paths if path.is_file() and not any(venv in path.parents for venv in ours)]


def probe(command, versions, modules="venv, ensurepip"):
    """The executable behind the command, if it really runs, is of one of the versions and has the modules; or None."""
    code = f"import sys, {modules}; print('%d.%d' % sys.version_info[:2]); print(sys.executable)"
    try:
        result = subprocess.run(
            [*command, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=60
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    lines = result.stdout.split("\n")
    return lines[1].strip() if result.returncode == 0 and lines[0].strip() in versions else None


@contextlib.contextmanager
def only_one(path):
    """Wait until no other process is in here; the system frees the lock of one that ends, however it ends."""
    with open(str(path), "a") as file:
        waiting = False
        while not is_locked(file):
            if not waiting:
                say(f"waiting for another dev.py that is working on {path.parent.name}")
            waiting = True
            time.sleep(0.5)
        # Closing the file unlocks it.
        yield


def is_locked(file):
    """Lock a file for this process; False: another has."""
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


class InstallTrouble(Trouble):
    """pip failed; ``began`` tells whether it had already begun to change the venv."""

    def __init__(self, sentence, began):
        super().__init__(sentence)
        self.began = began


def pip(python, arguments):
    """Run pip, showing only the large downloads; its last words if it fails."""
    command = [str(python), "-m", "pip", *arguments]
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


def run_in_blender(tool, arguments):
    with blender_resources() as environment:
        return run_script(ROOT / "tools" / "run.py", [tool, *arguments], environment)


def run_script(script, arguments, environment):
    if not script.exists():
        raise Trouble(f"{script.relative_to(ROOT)} is missing; this checkout is not complete.")
    return subprocess.call([main_python(), str(script), *arguments], env=environment)


def say(step):
    print(f"[dev.py] {step}", flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
