"""A character with its clips as a .glb file, by Blender's own exporter."""

import contextlib
import io
import json
import logging
import struct
import uuid
from collections.abc import Iterable
from pathlib import Path

import addon_utils
import bpy

from ...core.errors import ExportError
from .action_curves import action_curves
from .copies import silence, tie_copies
from .evaluated_pose import transforms_kept
from .read_actions import source_frame_rate

_EXPORTER = "io_scene_gltf2"


def check_exportable(armature_object) -> None:
    """ExportError if the exporter would not find the armature."""
    if armature_object.name not in bpy.context.view_layer.objects:
        raise ExportError(
            f"'{armature_object.name}' is in no collection that the view layer shows; include its collection to export."
        )


def export_clips(armature_object, actions: Iterable[tuple[str, bpy.types.Action]], path: Path) -> None:
    """Write an armature, the meshes that it moves and the given (name, action) pairs, each an animation of that name.

    Each animation starts at 0 s with the first frame of its action, and lasts as many seconds as the clip read from it.
    There are no others, whatever else the character plays. Nothing of the scene is changed.

    Raises ExportError if Blender cannot export, ClipError for an action that does not move the armature.
    """
    if not addon_utils.check(_EXPORTER)[1]:
        addon_utils.enable(_EXPORTER)
    check_exportable(armature_object)
    view_layer = bpy.context.view_layer
    wanted = [armature_object, *_moved_meshes(armature_object, view_layer)]
    with (
        transforms_kept(bpy.context.scene),
        _in_a_window(),
        _stand_ins(wanted) as (copies, names),
        _selected(copies, view_layer),
        _quiet() as said,
    ):
        _lay_tracks(copies[0], armature_object, actions)
        try:
            done = bpy.ops.export_scene.gltf(
                filepath=str(path),
                export_format="GLB",
                use_selection=True,
                export_animations=True,
                export_animation_mode="NLA_TRACKS",
                export_anim_slide_to_zero=True,
                export_force_sampling=True,
                export_optimize_animation_size=False,
                export_current_frame=False,
                check_existing=False,
            )
        except RuntimeError as error:
            raise _failure(path, said.getvalue()) from error
    if done != {"FINISHED"} or not path.is_file():
        raise _failure(path, said.getvalue())
    _rename(path, names)


@contextlib.contextmanager
def _in_a_window():
    """The exporter turns the mouse pointer of the window into an hourglass. A command of the command line has none at
    hand, though Blender has one."""
    windows = bpy.context.window_manager.windows
    has_none = bpy.context.window is None
    with bpy.context.temp_override(window=windows[0]) if has_none and windows else contextlib.nullcontext():
        yield


def _failure(path: Path, said: str) -> ExportError:
    """Return the error of an export that came to nothing; the exporter's own words go to the terminal."""
    logging.getLogger(__name__).error(said)
    return ExportError(
        f"Blender's glTF exporter cannot write '{path}'; see that the disk has room and that you may write there, and "
        "read in the terminal what it says."
    )


def _moved_meshes(armature_object, view_layer) -> list:
    """Meshes that hang on the armature, by parent or by modifier."""
    return [
        obj
        for obj in view_layer.objects
        if obj.type == "MESH" and (obj.parent == armature_object or obj.find_armature() == armature_object)
    ]


@contextlib.contextmanager
def _stand_ins(objects):
    """Copies of the objects that hang together as they do and play nothing, and {name of a copy: its original's} for
    each part of the file.

    The exporter writes every track that it finds, muted or not, of objects and of their shape keys; tracks cannot be
    taken off an object and put back. Copies are told by their names in the file only, see :func:`_rename`: nothing else
    may have these, bones neither.
    """
    frame, subframe = bpy.context.scene.frame_current, bpy.context.scene.frame_subframe
    copies, data = [], []
    names: dict[str, dict[str, str]] = {"nodes": {}, "meshes": {}}
    try:
        for original in objects:
            copy = original.copy()
            copies.append(copy)
            copy.name = uuid.uuid4().hex
            names["nodes"][copy.name] = original.name
            keys = original.data.shape_keys if original.type == "MESH" else None
            if keys is not None and keys.animation_data is not None:
                copy.data = original.data.copy()
                data.append(copy.data)
                copy.data.name = uuid.uuid4().hex
                names["meshes"][copy.data.name] = original.data.name
                silence(copy.data.shape_keys.animation_data)
            silence(copy.animation_data)
            # What cannot be seen or selected would be left out.
            copy.hide_viewport = copy.hide_select = False
            bpy.context.scene.collection.objects.link(copy)
        tie_copies(dict(zip(objects, copies, strict=True)))
        yield copies, names
    finally:
        for copy in copies:
            bpy.data.objects.remove(copy)
        for mesh in data:
            bpy.data.meshes.remove(mesh)
        bpy.context.scene.frame_set(frame, subframe=subframe)


@contextlib.contextmanager
def _selected(objects, view_layer):
    """Only these objects are selected."""
    active, mode = view_layer.objects.active, None
    if active is not None and active.mode != "OBJECT":
        mode = active.mode
        bpy.ops.object.mode_set(mode="OBJECT")
    before = [obj for obj in view_layer.objects if obj.select_get()]
    try:
        for obj in before:
            obj.select_set(False)
        for obj in objects:
            obj.select_set(True)
        view_layer.objects.active = objects[0]
        yield
    finally:
        for obj in objects:
            obj.select_set(False)
        for obj in before:
            obj.select_set(True)
        view_layer.objects.active = active
        if mode is not None:
            bpy.ops.object.mode_set(mode=mode)


def _lay_tracks(copy, armature_object, actions) -> None:
    """Every action of the armature is a track of its copy, at its own rate."""
    animation = copy.animation_data or copy.animation_data_create()
    render = bpy.context.scene.render
    scene_rate = render.fps / render.fps_base
    for name, action in actions:
        curves = action_curves(armature_object, action)
        frames = curves.frames()
        track = animation.nla_tracks.new()
        track.name = name
        strip = track.strips.new(name, int(frames[0]), action)
        strip.action_slot = curves.slot
        strip.action_frame_start, strip.action_frame_end = float(frames[0]), float(frames[-1])
        strip.scale = scene_rate / source_frame_rate(action)
        strip.frame_start = float(int(frames[0]))
        strip.extrapolation = "NOTHING"


def _rename(path: Path, names: dict[str, dict[str, str]]) -> None:
    """Give the originals' names to what was copied, in the JSON of a .glb file."""
    raw = path.read_bytes()
    length, kind = struct.unpack_from("<I4s", raw, 12)
    content = json.loads(raw[20 : 20 + length])
    # A skin is called as its armature.
    for part, known in (*names.items(), ("skins", names["nodes"])):
        for entry in content.get(part, ()):
            entry_name = entry.get("name")
            if entry_name in known:
                entry["name"] = known[entry_name]
    told = json.dumps(content, separators=(",", ":"), ensure_ascii=False).encode()
    told += b" " * (-len(told) % 4)
    rest = raw[20 + length :]
    header = raw[:8] + struct.pack("<I", 20 + len(told) + len(rest))
    path.write_bytes(header + struct.pack("<I4s", len(told), kind) + told + rest)


@contextlib.contextmanager
def _quiet():
    """Let a text take what the exporter says about its progress."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        yield said
