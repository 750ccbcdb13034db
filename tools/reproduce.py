"""Section 5 of the paper with our own code: python3 dev.py reproduce [--clips BVH_FOLDER] [--out FOLDER] [--quick].

Runs inside the bpy module with the extension linked and enabled for real (``dev.py`` arranges that). Exit code 1 and
one sentence if something is wrong with the input.
"""

import argparse
import os
import sys
from pathlib import Path

from headless import ScriptError, leave, prepare_folder, run_steps, start_blender
from journal import Journal


def main(argv: list[str]) -> int:
    options = _parse(argv)
    journal = Journal()
    try:
        _check(options)
        journal.run("start", "Starting Blender", start_blender, "python3 dev.py reproduce")
        report = run_steps("reproduce_steps.run", options, journal)
    except ScriptError as error:
        print(f"reproduce: {error}", file=sys.stderr, flush=True)
        return 1
    print(f"\n{'':<62}{'the paper':<34}ours")
    for row in report["comparisons"]:
        print(f"{row['what']:<62}{row['paper']:<34}{row['ours']}")
    print(f"\nAll of it took {sum(journal.seconds.values()):.0f} s.\n  {options.out / 'report.html'}")
    return 0


def _parse(argv: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="dev.py reproduce", description="The paper's section 5 with our own code.")
    parser.add_argument(
        "--clips",
        metavar="BVH_FOLDER",
        type=Path,
        help="use these motions; default: the recorded ones where they are at hand (WAYFARER_DATA), otherwise the "
        "sample character",
    )
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=Path("reproduce"), help="default: reproduce")
    parser.add_argument(
        "--quick", action="store_true", help="the sample character unless --clips is given, on coarse grids"
    )
    options = parser.parse_args(argv)
    if options.clips is None and not options.quick:
        options.clips = _recorded()
    # Blender resolves relative paths against the open file.
    options.clips = options.clips.resolve() if options.clips else None
    options.out = options.out.resolve()
    return options


def _recorded() -> Path | None:
    """The folder of recorded motions that are alike the paper's, if they are at hand."""
    beside = Path(__file__).resolve().parents[1].parent / "shared" / "data"
    folder = Path(os.environ.get("WAYFARER_DATA", beside)) / "cmu16"
    return folder if folder.is_dir() else None


def _check(options: argparse.Namespace) -> None:
    if options.clips is not None and not options.clips.is_dir():
        raise ScriptError(f"There is no folder '{options.clips}'; name one with BVH files in it.")
    prepare_folder(options.out)


if __name__ == "__main__":
    leave(main(sys.argv[1:]))
