"""The whole workflow without a window: python3 dev.py demo [--clips BVH_FOLDER] [--blend FILE] [--out FOLDER].

Runs inside the bpy module with the extension linked and enabled for real (``dev.py`` arranges that), and calls the
operators that the panel's buttons call. Exit code 1 and one sentence if something is wrong with the input.
"""

import argparse
import importlib
import json
import re
import sys
from pathlib import Path

from headless import EXTENSION, enable_extension, leave
from journal import Journal


class DemoError(Exception):
    """What stops the demo, as a sentence for the person at the keyboard."""


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
    try:
        enable_extension()
    except RuntimeError as error:
        raise DemoError(f"{error}: python3 dev.py demo") from None


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
    leave(main(sys.argv[1:]))
