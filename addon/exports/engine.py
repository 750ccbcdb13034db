"""The folder that engines read: the embedding, the clips, the reader and a page about them."""

import re
import tempfile
from collections.abc import Generator
from pathlib import Path

import bpy

from ...core.embedding.embedding import Embedding
from ...core.errors import ExportError
from ...core.export.engine_format import ARRAYS_FILE, HEADER_FILE, TABLE_FILE, engine_files_steps
from ...core.files import check_folder, remove_files, why, write_files
from ...core.motion.graph import MotionGraph
from ...core.progress import Progress, portion
from ...core.wording import counted
from ..bridge.export_gltf import check_exportable, export_clips
from ..bridge.write_action import write_clip

READER = Path(__file__).resolve().parents[2] / "assets" / "engine" / "wayfarer_reader.py"
CLIPS_FILE, PAGE_FILE = "clips.glb", "README.md"

_README = """\
# {scene}: an embedding for engines

Made by Wayfarer: where '{character}' can go in this scene, and how. {nodes}, {links}.

* embedding.json, embedding.npz, and perhaps embedding.table, a plain list of nodes and links: the embedding. The
  format is described in docs/engine_format.md of Wayfarer's source.
* wayfarer_reader.py: a reader that needs Python and NumPy only; it walks, plans and lays out the root's path.
  Try it: python wayfarer_reader.py .
* clips.glb: the character with an animation for each clip, named as in embedding.json (Y is up in there, as glTF
  wants it; the embedding has Z up: x, y, z here are x, -z, y there).

A walk is a list of nodes. From one to the next its segment is played: an animation from `start` to `end` seconds, the
root laid along `root_path`. Every node has a way on.
"""


def engine_folder_steps(
    scene, embedding: Embedding, folder: Path, with_clips: bool = True, with_table: bool = True
) -> Generator[Progress, None, dict[str, bytes | bytearray]]:
    """Everything that an engine needs of a scene's embedding: files for ``folder``, by their names; yields progress.

    Nothing is written, and the scene is left as it is.

    Raises ExportError if there is nothing to export, or Blender cannot, StorageError if a file in the folder is not
    ours to replace: all but what Blender's exporter has to say before any work.
    """
    wanted = {TABLE_FILE: with_table, CLIPS_FILE: with_clips}
    names = [HEADER_FILE, ARRAYS_FILE, READER.name, PAGE_FILE, *(name for name in wanted if wanted[name])]
    check_folder(folder, names)
    scene_name, character = scene.name, scene.wayfarer.character
    if with_clips:
        if character is None:
            raise ExportError(
                "There is no character whose clips could be exported; choose one, or leave the clips out."
            )
        check_exportable(character)
    page = _README.format(
        scene=_plain_markdown(scene_name),
        character=_plain_markdown(character.name) if character else "the character",
        nodes=counted(embedding.n_nodes, "node"),
        links=counted(embedding.n_links, "link"),
    )
    try:
        reader = READER.read_bytes()
    except OSError as error:
        raise ExportError(f"'{READER}' cannot be read: {why(error)}; install Wayfarer again.") from None
    files = yield from portion(engine_files_steps(embedding, with_table), 0.0, 0.4 if with_clips else 1.0)
    files |= {READER.name: reader, PAGE_FILE: page.encode()}
    if with_clips:
        yield Progress(0.4, "Exporting clips")
        files[CLIPS_FILE] = _clips_file(bpy.data.scenes[scene_name], embedding.graph)
    # Whoever has pressed Esc meanwhile is heard before anything is written.
    yield Progress(1.0, "Writing files")
    return files


def _plain_markdown(name: str) -> str:
    """Return a name that Markdown shows as it is: no link, no picture, no HTML."""
    return re.sub(r"([\\`*_{}\[\]()#+.!|<>&~-])", r"\\\1", " ".join(name.split()))


def write_engine_folder(folder: Path, files: dict[str, bytes | bytearray]) -> None:
    """Write the files; clips and table of an earlier export that are not among them are removed.

    Raises StorageError if a file in the folder is not ours to replace, or one cannot be written or removed.
    """
    write_files(folder, files)
    # They belong to another embedding now.
    remove_files(folder, [name for name in (TABLE_FILE, CLIPS_FILE) if name not in files])


def _clips_file(scene, graph: MotionGraph) -> bytes:
    """The clips that the graph plays as a .glb file: the character's own actions, and those that only Wayfarer knows,
    baked. In one go, after which nothing is left of it."""
    character = scene.wayfarer.character
    own = {action.name: action for action in scene.wayfarer.used_actions()}
    names = dict.fromkeys(graph.clips[segment.clip].name for segment in graph.segments)
    clips = {clip.name: clip for clip in graph.clips}
    baked: list[bpy.types.Action] = []
    try:
        actions = []
        for name in names:
            # Mirror images are nobody's action.
            if name not in own:
                baked.append(write_clip(character, clips[name], name))
            actions.append((name, own[name] if name in own else baked[-1]))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / CLIPS_FILE
            export_clips(character, actions, path)
            return path.read_bytes()
    except OSError as error:
        raise ExportError(f"The clips cannot be exported: {why(error)}; make room for temporary files.") from None
    finally:
        for action in baked:
            bpy.data.actions.remove(action)
