"""What a command says: progress on standard error, numbers on standard output."""

import contextlib
import os
import sys

from ...core.progress import Progress, finish
from ..bridge.text import amount, area, counted, share, short, time


def summary_lines(numbers: dict) -> list[str]:
    """The numbers of a command for people."""
    graph, embedding, coverage = numbers["graph"], numbers["embedding"], numbers["coverage"]
    lines = [
        f"Motion graph: {counted(graph['segments'], 'segment')}, {counted(graph['links'], 'link')} from "
        f"{graph['clips_played']} of {counted(graph['clips'], 'clip')}, {time(graph['motion_seconds'])} of motion",
        f"Embedding: {counted(embedding['nodes'], 'node')}, {counted(embedding['links'], 'link')} on "
        f"{embedding['cells'][0]} x {embedding['cells'][1]} cells x {embedding['headings']} headings",
        f"Coverage: {share(coverage['share'])} of the free floor, "
        f"{amount(coverage['square_metres'])} of {area(coverage['free_square_metres'])}",
    ]
    if "variability" in numbers:
        ways = numbers["variability"]
        lines.append(
            f"Variability: {amount(ways['mean'])} ways on average, up to {counted(ways['highest'], 'way')} in a cell"
        )
    if "parcels" in numbers:
        made = numbers["parcels"]
        lines.append(f"In parcels of {short(made['parcel_size'])} m; table, page and maps: {made['folder']}")
    if "walk" in numbers:
        made = numbers["walk"]
        lines.append(
            f"Walk: {time(made['seconds'])}, {amount(made['metres'])} m, {counted(made['segments'], 'segment')}, in "
            f"the action '{made['action']}', frames {made['frames'][0]} to {made['frames'][1]}"
        )
    if "report" in numbers:
        made = numbers["report"]
        lines.append(f"Report written to {made['folder']}: {made['files'][0]} and {len(made['files']) - 1} files more")
    if "export" in numbers:
        made = numbers["export"]
        lines.append(f"Exported to {made['folder']}: {', '.join(made['files'])}")
    if "saved" in numbers:
        lines.append(f"Saved as {numbers['saved']}")
    return lines


class Aloud:
    """Lines on standard error, one for each phase of the work."""

    shown = True
    kind = ""


def say(phase: str) -> None:
    kind = phase.split(" ")[0]
    # "Reading walk", "Reading turn": one line tells enough.
    if Aloud.shown and kind != Aloud.kind:
        sys.stderr.write(f"{phase}\n")
        sys.stderr.flush()
    Aloud.kind = kind


def finish_aloud(steps):
    """Run long work to its end, telling of its phases; returns its result."""

    def tell(progress: Progress) -> None:
        say(progress.message)

    return finish(steps, tell)


@contextlib.contextmanager
def clean_output():
    """A file for what was asked for: what Blender prints meanwhile goes to standard error instead.

    Blender prints from C, so that the file descriptor itself is turned.
    """
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with open(kept, "w", encoding="utf-8", closefd=False) as out:
            yield out
    finally:
        os.dup2(kept, 1)
        os.close(kept)
