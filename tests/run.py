"""The checks and tests behind `python3 dev.py test`, as many at the same time as there are cores.

Like dev.py it runs with any Python from 3.8 on and the standard library only; what it starts runs in .venv and others.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import dev

HELP = """\
python3 dev.py test [--blender VERSION] [PYTEST ARGUMENTS]

Without paths: style, types, docstrings, core tests, those of them that could turn out otherwise with the newest Python
that there is and without Blender (in .venv-core), Blender tests, and the workflow in Blender's window if
WAYFARER_BLENDER_ROOT (default /opt/blender-sid) holds a system with Blender. With paths: only the tests named.
With --blender the tests inside Blender, in that version, which gets a .venv-VERSION of its own; one of:
{versions}.
Every other argument goes to pytest, for example: -k NAME, -x, --durations 10.
"""
CORE, BLENDER, WINDOW = (dev.ROOT / "tests" / name for name in ("core", "blender", "window"))
# The tests of a folder are dealt to so many processes: then none is left over that takes long.
N_SPLIT = 2
# Files of core tests that run with one Python only. All else runs with the newest one as well: what depends on the
# versions of Python, NumPy and SciPy is how they count, round and pack bits, what they write, and how they read it.
ONE_PYTHON = (
    # These look at sources, texts and dev.py, or work with Dask, which is not there.
    *("docs", "parcels_cluster", "remedies", "security", "set_up", "study_cluster", "wording"),
    # These make much out of what other files test by itself: long walks, large grounds, many embeddings or processes.
    *(
        "ablation",
        "agreement",
        "capture",
        "crowd",
        "curve",
        "directed",
        "doctor",
        "fuzz_environments",
        "fuzz_files",
        "limits",
    ),
    *("loop", "metrics", "occupancy", "parcels", "performance", "pruning", "repertoire", "root_path", "scene_report"),
    *("study", "threshold", "walk", "wandering", "weak_spots", "why_not"),
)
NO_TESTS = 5  # pytest's exit code where nothing was selected


def main(arguments):
    if "--help" in arguments or "-h" in arguments:
        print(HELP.format(versions=", ".join(dev.blenders())), end="")
        return 0
    parser = argparse.ArgumentParser(prog="dev.py test", add_help=False, allow_abbrev=False)
    parser.add_argument("--blender", metavar="VERSION", choices=dev.blenders())
    known, arguments = parser.parse_known_args(arguments)
    paths, options = split_paths(arguments)
    if known.blender:
        parts = parts_in_blender(known.blender, paths, options)
    else:
        parts = parts_named(paths, options) if paths else all_parts(options)
    start = time.monotonic()
    return summarize(run_parts(parts), time.monotonic() - start, selected=bool(arguments))


# ------------------------------------------------------------------------------------------------- parts


def split_paths(arguments):
    """The arguments of pytest as (paths, made absolute; everything else)."""
    paths, options, previous = [], [], ""
    for argument in arguments:
        name, colons, test_id = argument.partition("::")
        found = [base / name for base in (Path.cwd(), dev.ROOT) if (base / name).exists()]
        # `-k core` selects by name, although a folder `core` exists.
        if argument.startswith("-") or previous in ("-k", "-m", "-p", "-c", "-o"):
            options.append(argument)
        elif name and found:
            paths.append(str(found[0].resolve()) + colons + test_id)
        elif "/" in name or name.endswith(".py"):
            raise dev.Trouble(f"There is no {name}; name a path in tests/core or tests/blender.")
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


def pytest_part(name, python, paths, options):
    return name, [python, "-m", "pytest", *options, *map(str, paths)]


def split_parts(name, python, folder, options):
    """All tests of a folder, in parts that can run at the same time."""
    files = sorted(folder.glob("test_*.py"))
    return [pytest_part(f"{name} {i + 1}", python, files[i::N_SPLIT], options) for i in range(N_SPLIT)]


def parts_named(paths, options):
    """Only the tests named; those of core and of Blender apart, because the same class would exist twice."""
    for path in paths:
        if not any(paths_inside(folder, [path]) for folder in (CORE, BLENDER, WINDOW)):
            raise dev.Trouble(f"{path} holds no tests; name a path in tests/core, tests/blender or tests/window.")
    named = (("core tests", CORE), ("Blender tests", BLENDER), ("window tests", WINDOW))
    inside = [(name, paths_inside(folder, paths)) for name, folder in named]
    return [pytest_part(name, dev.main_python(), found, options) for name, found in inside if found]


def parts_in_blender(version, paths, options):
    """The Blender tests, or some of them, in one version of Blender."""
    for path in paths:
        if not paths_inside(BLENDER, [path]):
            raise dev.Trouble(f"{path} runs in no Blender; with --blender name a path in tests/blender.")
    name, inside = f"Blender {version}", paths_inside(BLENDER, paths)
    try:
        python = dev.blender_venv(version).set_up()
    except dev.InstallTrouble as trouble:
        raise dev.Trouble(f"{name} ({dev.blenders()[version][0]}) cannot be installed here: {trouble}") from None
    return [pytest_part(name, python, inside, options)] if inside else split_parts(name, python, BLENDER, options)


def all_parts(options):
    """Everything that must hold, in the order in which it is begun: what takes long before what fills gaps."""
    python = dev.main_python()
    sources = ["core", "addon", "tools", "docs", "tests", "dev.py", "__init__.py"]
    sources = [name for name in sources if (dev.ROOT / name).exists()]
    return [
        ("style", [python, "-m", "ruff", "check", *sources]),
        ("format", [python, "-m", "ruff", "format", "--check", *sources]),
        # With -rs it says why where there is no window.
        pytest_part("window tests", python, [WINDOW], ["-rs", *options]),
        *split_parts("Blender tests", python, BLENDER, options),
        *split_parts("core tests", python, CORE, options),
        *newest_part(options),
        ("types", [python, "-m", "basedpyright", "--pythonpath", python]),
        ("docstrings", [python, str(dev.ROOT / "dev.py"), "docs"]),
    ]


def newest_part(options):
    """Tests of the core with the newest Python that there is, and nothing but what they need; no part without one."""
    name, venv = "core, newest", dev.core_venv()
    if not venv.stamp.exists() and dev.find_python(venv.pythons) is None:
        dev.say(f"{name}: skipped, no Python of {', '.join(venv.pythons)} was found that can make a venv")
        return []

    def command():
        try:
            python = venv.set_up()
        except dev.InstallTrouble as trouble:
            # The other tests need nothing of it.
            return [sys.executable, "-c", f"import sys; sys.exit({str(trouble)!r})"]
        files = [path for path in sorted(CORE.glob("test_*.py")) if path.stem[len("test_") :] not in ONE_PYTHON]
        return pytest_part(name, python, files, options)[1]

    # The environment is made while other parts run.
    return [(name, command)]


# ------------------------------------------------------------------------------------------------ running


class RunningPart:
    """A part in a process of its own, which writes into a file what is to be shown."""

    def __init__(self, name, command, folder, alone):
        self.name, self.seconds, self.is_shown, self.n_shown = name, None, False, 0
        self.start = time.monotonic()
        command = command() if callable(command) else command
        self.report, self.file = folder / f"{name}.xml", folder / f"{name}.txt"
        if "pytest" in command:
            # A cache of its own, from which --lf knows what failed.
            own = [f"--junitxml={self.report}", "-o", f"cache_dir=.pytest_cache/{name.replace(' ', '-')}"]
            command = [*command[:3], *own, *command[3:]]
        # The tests inside Blender make a folder for its resources, in which nothing of the user's is.
        environment = {key: value for key, value in os.environ.items() if key != "BLENDER_USER_RESOURCES"}
        with self.file.open("wb") as file:
            # One that is alone has the terminal to itself, for --pdb.
            output = None if alone else file
            self.process = subprocess.Popen(command, cwd=dev.ROOT, env=environment, stdout=output, stderr=output)

    def is_busy(self):
        if self.seconds is None and self.process.poll() is not None:
            self.seconds = time.monotonic() - self.start
            self.counts = self.count()
        return self.seconds is None

    def count(self):
        """(passed, failed, skipped); a check without tests counts as one, and so does a process that died."""
        code = self.process.returncode
        if not self.report.exists():
            return int(code == 0), int(code != 0), 0
        suite = ElementTree.parse(str(self.report)).find("testsuite")
        n, failures, errors, skipped = (int(suite.get(k)) for k in ("tests", "failures", "errors", "skipped"))
        failed = max(failures + errors, int(code not in (0, NO_TESTS)))
        return n - failures - errors - skipped, failed, skipped

    def show(self):
        """Show what has been written since the last time; True once that was all."""
        is_busy = self.is_busy()
        if not self.is_shown:
            print(f"\n== {self.name}", flush=True)
        self.is_shown = True
        with self.file.open("rb") as file:
            file.seek(self.n_shown)
            self.n_shown += sys.stdout.buffer.write(file.read())
        sys.stdout.flush()
        return not is_busy


def run_parts(parts):
    """Run parts (name, command), as many at once as there are cores; returns the RunningPart of each.

    One of them is seen at work; what another says is shown when those before it are done.
    """
    waiting, running, done = list(parts), [], []
    with tempfile.TemporaryDirectory() as folder:
        try:
            while waiting or running:
                n_busy = sum([part.is_busy() for part in running])
                if waiting and n_busy < (os.cpu_count() or 1):
                    running.append(RunningPart(*waiting.pop(0), Path(folder), alone=len(parts) == 1))
                elif not running[0].show():
                    time.sleep(0.1)
                else:
                    done.append(running.pop(0))
        finally:
            for part in running:
                part.process.kill()
                part.process.wait()
    return done


def summarize(parts, seconds, selected):
    """Print what came of each part, how long all took, and on the last line how many tests passed; the exit code."""
    all_empty = all(part.process.returncode == NO_TESTS for part in parts)
    passed, failed, skipped = (sum(counts) for counts in zip(*(part.counts for part in parts)))
    print()
    for part in parts:
        code = part.process.returncode
        if code == NO_TESTS and selected and not all_empty:
            verdict = "no tests selected"
        else:
            verdict = "passed" if code == 0 else f"FAILED (exit code {code})"
            failed += code == NO_TESTS
        print(f"{part.name:15} {part.seconds:6.1f} s  {verdict}")
    print(f"time: {seconds // 60:.0f} min {seconds % 60:.0f} s")
    print(f"tests: {passed} passed, {failed} failed, {skipped} skipped")
    return int(failed > 0)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except dev.Trouble as trouble:
        sys.exit(f"dev.py: {trouble}")
    except KeyboardInterrupt:
        sys.exit(130)
