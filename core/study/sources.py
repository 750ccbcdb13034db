"""Files that cases read: named after what is in them, in the folder that all workers share."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from ..errors import StudyError
from ..files import LARGEST_TEXT, check_folder, check_plain, read_regular, why, write_whole
from .clip_set import holds_motion_graph
from .plan import Source, StudyPlan

SCENES, CLIPS = "scenes", "clips"

TABLE_FILE, PAGE_FILE = "results.csv", "results.html"
_FOLDERS = ("read", "read/scenes", "read/clips", "cases", "graphs", "inputs", "large", "maps")


@dataclass(frozen=True)
class Input:
    """A scene or a clip set as cases read it.

    Attributes
    ----------
    digest : str
        Of the file's bytes; empty if it cannot be read.
    file : Path
    is_graph : bool
        Whether it is a motion graph already.
    problem : str
        Why it cannot be read, if so.
    """

    digest: str
    file: Path
    is_graph: bool = False
    problem: str = ""


def check_study_folder(folder: Path) -> None:
    """Raise StorageError if results cannot be written to a study's folder without touching what is not ours."""
    check_plain(folder, _FOLDERS)
    check_folder(folder, (TABLE_FILE, PAGE_FILE))


def read_file(folder: Path, kind: str, source: Source) -> Path:
    """Return the file for what Blender reads from a .blend file (``kind`` is SCENES or CLIPS)."""
    return folder / "read" / kind / f"{source.name}.npz"


def problem_file(folder: Path, kind: str, source: Source) -> Path:
    """Return the file for the sentence why it could not."""
    return folder / "read" / kind / f"{source.name}.txt"


def gather(plan: StudyPlan, folder: Path) -> tuple[dict[str, Input], dict[str, Input]]:
    """Copy the scenes and clip sets of a study to a place that the workers find; returns them by name.

    Raises StudyError if a .blend file has not been read yet; StorageError if the folder cannot be written.
    """
    scenes = {source.name: _input(folder, SCENES, source) for source in plan.scenes}
    clips = {source.name: _input(folder, CLIPS, source) for source in plan.clip_sets}
    return scenes, clips


def _input(folder: Path, kind: str, source: Source) -> Input:
    file = read_file(folder, kind, source) if source.is_blend else source.file
    problem = problem_file(folder, kind, source)
    if source.is_blend and not file.exists():
        if problem.exists():
            return Input("", file, problem=_said(problem))
        raise StudyError(f"'{source.file}' has not been read; start the study with Blender's command, or with dev.py.")
    try:
        raw = read_regular(file)
    except OSError as error:
        return Input("", file, problem=f"'{file}' cannot be read: {why(error)}.")
    digest = hashlib.sha256(raw).hexdigest()
    copy = folder / "inputs" / f"{digest[:32]}.npz"
    if not copy.exists():
        write_whole(copy, raw)
    return Input(digest, copy, holds_motion_graph(copy))


def _said(problem: Path) -> str:
    try:
        return read_regular(problem, LARGEST_TEXT).decode("utf-8", "replace")
    except OSError as error:
        return f"'{problem}' cannot be read: {why(error)}."
