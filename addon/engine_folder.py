"""The folder that engines read: the embedding, the clips, the reader and a page about them."""

from pathlib import Path

import bpy

from ..core.embedding.embedding import Embedding
from ..core.errors import ExportError
from ..core.export.engine_format import TABLE_FILE, engine_files
from ..core.motion.graph import MotionGraph
from .bridge.export_gltf import export_clips
from .bridge.write_action import write_clip
from .export_folder import check_folder, remember, remove_earlier, write_files
from .text import counted

READER = Path(__file__).resolve().parents[1] / "assets" / "engine" / "wayfarer_reader.py"
CLIPS_FILE = "clips.glb"

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


def write_engine_folder(
    scene, embedding: Embedding, folder: Path, with_clips: bool = True, with_table: bool = True
) -> list[str]:
    """Write everything that an engine needs of a scene's embedding; returns the names of the files.

    Clips and table of an earlier export that are not wanted any more are removed.

    Raises ExportError if there is nothing to export, Blender cannot, or a file in the folder is not ours to replace;
    StorageError if a file cannot be written or removed.
    """
    character = scene.wayfarer.character
    page = _README.format(
        scene=scene.name,
        character=character.name if character else "the character",
        nodes=counted(embedding.n_nodes, "node"),
        links=counted(embedding.n_links, "link"),
    )
    try:
        reader = READER.read_bytes()
    except OSError as error:
        raise ExportError(f"'{READER}' cannot be read: {error.strerror}; install Wayfarer again.") from None
    files = {**engine_files(embedding, with_table), READER.name: reader, "README.md": page.encode()}
    check_folder(folder, [*files, CLIPS_FILE] if with_clips else files)
    write_files(folder, files)
    # They belong to another embedding now.
    wanted = {TABLE_FILE: with_table, CLIPS_FILE: with_clips}
    remove_earlier(folder, [name for name in wanted if not wanted[name]])
    if not with_clips:
        return list(files)
    _write_clips(scene, embedding.graph, folder / CLIPS_FILE)
    remember(folder, [CLIPS_FILE])
    return [*files, CLIPS_FILE]


def _write_clips(scene, graph: MotionGraph, path: Path) -> None:
    """The clips that the graph plays: the character's own actions, and those that only Wayfarer knows, baked."""
    character = scene.wayfarer.character
    if character is None:
        raise ExportError("There is no character whose clips could be exported; choose one, or leave the clips out.")
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
        export_clips(character, actions, path)
    finally:
        for action in baked:
            bpy.data.actions.remove(action)
