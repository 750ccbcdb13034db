"""The whole workflow without a window: python3 dev.py demo [--clips BVH_FOLDER] [--blend FILE] [--out FOLDER].

Runs inside the bpy module with the extension linked and enabled for real (``dev.py`` arranges that), and calls the
operators that the panel's buttons call. Exit code 1 and one sentence if something is wrong with the input.
"""

import argparse
import json
import sys
from pathlib import Path

from headless import ScriptError, leave, prepare_folder, run_steps, start_blender
from journal import Journal


def main(argv: list[str]) -> int:
    options = _parse(argv)
    journal = Journal()
    try:
        _check(options)
        journal.run("start", "Starting Blender", start_blender, "python3 dev.py demo")
        report = run_steps("demo_steps", options, journal)
    except ScriptError as error:
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
        raise ScriptError(f"There is no folder '{options.clips}'; name one with BVH files in it.")
    if options.clips is not None and not any(path.suffix.lower() == ".bvh" for path in options.clips.iterdir()):
        raise ScriptError(f"The folder '{options.clips}' holds no BVH files; name one with motion capture in it.")
    if options.blend is not None and not options.blend.is_file():
        raise ScriptError(f"There is no file '{options.blend}'; name a .blend file.")
    prepare_folder(options.out)


def _tell(report: dict, out: Path) -> None:
    total = sum(report["seconds"].values())
    print("", *report["summary"], f"All of it took {total:.0f} s.", sep="\n")
    for name in ("demo.blend", "map.png", "view.png", "report.json"):
        print(f"  {out / name}")


if __name__ == "__main__":
    leave(main(sys.argv[1:]))
