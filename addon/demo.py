"""The whole workflow without a window: python3 dev.py demo [--clips BVH_FOLDER] [--blend FILE] [--out FOLDER].

Runs inside the bpy module with the extension linked and enabled for real (``dev.py`` arranges that), and calls the
operators that the panel's buttons call. Exit code 1 and one sentence if something is wrong with the input.
"""

import argparse
import importlib
import json
import os
import re
import sys
import time
from pathlib import Path

EXTENSION = "bl_ext.user_default.wayfarer"


class DemoError(Exception):
    """What stops the demo, as a sentence for the person at the keyboard."""


class Journal:
    """Runs steps, says on the terminal what happens, and keeps the seconds that each step took."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    def run(self, step: str, label: str, work, *arguments, **options):
        print(f"{label:<34}", end="", flush=True)
        start = time.perf_counter()
        try:
            result = work(*arguments, **options)
        except BaseException:
            print(flush=True)
            raise
        self.seconds[step] = self.seconds.get(step, 0.0) + time.perf_counter() - start
        print(f"{time.perf_counter() - start:6.1f} s", flush=True)
        return result


def main(argv: list[str]) -> int:
    options = _parse(argv)
    journal = Journal()
    try:
        _check(options)
        journal.run("start", "Starting Blender", _enable_extension)
        report = _run_steps(options, journal)
    except DemoError as error:
        print(f"demo: {error}", file=sys.stderr, flush=True)
        return 1
    (options.out / "report.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    _tell(report, options.out)
    return 0


def _parse(argv: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="dev.py demo", description="Run the whole workflow, windowless.")
    parser.add_argument("--clips", metavar="BVH_FOLDER", type=Path, help="use these motions")
    parser.add_argument("--blend", metavar="FILE", type=Path, help="use this scene and its actions")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=Path("demo"), help="default: demo")
    options = parser.parse_args(argv)
    for name in ("clips", "blend", "out"):
        path = getattr(options, name)
        # Blender resolves relative paths against the open file.
        setattr(options, name, path.resolve() if path else None)
    return options


def _check(options: argparse.Namespace) -> None:
    if options.clips is not None and not options.clips.is_dir():
        raise DemoError(f"There is no folder '{options.clips}'; name one with BVH files in it.")
    if options.clips is not None and not any(path.suffix.lower() == ".bvh" for path in options.clips.iterdir()):
        raise DemoError(f"The folder '{options.clips}' holds no BVH files; name one with motion capture in it.")
    if options.blend is not None and not options.blend.is_file():
        raise DemoError(f"There is no file '{options.blend}'; name a .blend file.")
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DemoError(f"The folder '{options.out}' cannot be made: {error.strerror}.") from None


def _enable_extension() -> None:
    if "BLENDER_USER_RESOURCES" not in os.environ:
        raise DemoError("Start this with: python3 dev.py demo")
    import bpy  # the first import starts Blender

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    import addon_utils  # importable once bpy is

    def fail(error):
        raise error

    addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)


def _run_steps(options: argparse.Namespace, journal: Journal) -> dict:
    # Only now: these modules need bpy, and the name that the extension has in it.
    steps = importlib.import_module(f"{EXTENSION}.addon.demo_steps")
    errors = importlib.import_module(f"{EXTENSION}.core.errors")
    try:
        return steps.run(options, journal)
    except errors.MotionGraphError as error:
        raise DemoError(str(error)) from None
    except RuntimeError as error:
        # An operator that reports an error, or cannot start, raises it in Python with the sentence at the end.
        raise DemoError(re.split(r"Error: |poll\(\) ", str(error).strip())[-1]) from None


def _tell(report: dict, out: Path) -> None:
    total = sum(report["seconds"].values())
    print(
        f"\n{report['segments']} segments and {report['graph_links']} links from {report['clips']} clips became "
        f"{report['nodes']:,} nodes and {report['links']:,} links.\n"
        f"The character can be in {report['coverage']:.0%} of the free floor; "
        f"it walks for {report['walk_seconds']:.0f} s. All of it took {total:.0f} s."
    )
    for gap in report["not_covered"]:
        print(
            f"It cannot get to {gap['square_metres']:.1f} square metres of free floor around "
            f"({gap['x']:g}, {gap['y']:g})."
        )
    for name in ("demo.blend", "map.png", "view.png", "report.json"):
        print(f"  {out / name}")


if __name__ == "__main__":
    code = main(sys.argv[1:])
    # Without Python's own ending, in which some versions of Blender hang while classes are registered.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
