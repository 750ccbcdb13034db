"""Files that cases read: named after what is in them, in the folder that all workers share."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from ..errors import StudyError
from ..files import write_whole
from .clip_set import holds_motion_graph
from .plan import Source, StudyPlan

SCENES, CLIPS = "scenes", "clips"


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
            return Input("", file, problem=problem.read_text("utf-8"))
        raise StudyError(f"'{source.file}' has not been read; start the study with Blender's command, or with dev.py.")
    try:
        raw = file.read_bytes()
    except OSError as error:
        return Input("", file, problem=f"'{file}' cannot be read: {error.strerror or error}.")
    digest = hashlib.sha256(raw).hexdigest()
    copy = folder / "inputs" / f"{digest[:32]}.npz"
    if not copy.exists():
        write_whole(copy, raw)
    return Input(digest, copy, holds_motion_graph(copy))
