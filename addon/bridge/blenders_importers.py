"""FBX and glTF files by Blender's own importers: the armature that matters in them, and its actions."""

import contextlib
import io
from dataclasses import dataclass
from pathlib import Path

import addon_utils
import bpy
import numpy as np

from ...core.errors import ClipError
from .action_curves import action_curves
from .import_state import Before, newcomers
from .read_actions import FRAME_RATE_PROPERTY
from .rotation_modes import REST_CHANNELS

_RATES = (24, 25, 30, 48, 50, 60, 72, 90, 100, 120, 144, 200, 240)
"""Frames per second that motion is recorded at, lowest first: files in seconds do not name theirs."""
_OFF_FRAME = 0.02
"""Frames by which a key may lie off its frame."""


@dataclass
class Brought:
    """A file's armature and actions: references that live no longer than the call that asked for them.

    ``names`` are those of the actions in the file.
    """

    armature: bpy.types.Object
    actions: list
    names: list[str]

    def give_to(self, character, action) -> None:
        """Make an action one of ``character``, which has the same rest pose."""
        action_curves(self.armature, action).slot.name_display = character.name


def bring_file(path: Path, before: Before) -> Brought:
    """Read a file; the scene's frame rate may have changed afterwards.

    ClipError if the importer cannot read it, or if there is no armature in it.
    """
    _import(path)
    bpy.context.view_layer.update()
    armatures = [obj for obj in newcomers(before, "objects") if obj.type == "ARMATURE" and len(obj.data.bones)]
    if not armatures:
        raise ClipError(f"'{path.name}' holds no character: there are no bones in it; choose files with a skeleton.")
    moving = {obj: _actions_of(obj, newcomers(before, "actions")) for obj in armatures}
    armature = max(armatures, key=lambda obj: (len(moving[obj]) > 0, is_skinned(obj), len(obj.data.bones)))
    for obj in armatures:
        if obj.animation_data is not None:
            for track in list(obj.animation_data.nla_tracks):
                obj.animation_data.nla_tracks.remove(track)
    render = bpy.context.scene.render
    for action in moving[armature]:
        rate = render.fps / render.fps_base
        if path.suffix.lower() != ".fbx":
            rate = _found_rate(action, rate)
        action[FRAME_RATE_PROPERTY] = float(rate)
        _drop_still_placement(armature, action)
    return Brought(armature, moving[armature], [_plain_name(action.name) for action in moving[armature]])


def holds_skin(path: Path) -> bool:
    """Test, without importing it, whether an FBX or glTF file holds a mesh that bones move; no for one not there."""
    mark = b"Cluster" if path.suffix.lower() == ".fbx" else b'"JOINTS_0"'
    try:
        return mark in path.read_bytes()
    except OSError:
        return False


def with_family(armature) -> list:
    """An armature object, what it is parented to, and the meshes that it moves."""
    found, above = [armature], armature.parent
    while above is not None:
        found.append(above)
        above = above.parent
    return found + [obj for obj in bpy.data.objects if obj.type == "MESH" and _is_moved_by(obj, armature)]


def is_skinned(armature) -> bool:
    """Test whether a mesh is moved by an armature object."""
    return any(obj.type == "MESH" and _is_moved_by(obj, armature) for obj in bpy.data.objects)


def _import(path: Path) -> None:
    is_fbx = path.suffix.lower() == ".fbx"
    if not is_fbx and not addon_utils.check("io_scene_gltf2")[1]:
        raise ClipError(f"'{path.name}' needs Blender's add-on 'glTF 2.0 format', which is switched off; switch it on.")
    try:
        # What importers print is for their developers.
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            if is_fbx:
                result = bpy.ops.wm.fbx_import(filepath=str(path))
            else:
                # The other manner of placing bones makes them giants where their armature is scaled.
                result = bpy.ops.import_scene.gltf(
                    filepath=str(path),
                    bone_heuristic="TEMPERANCE",
                    disable_bone_shape=True,
                    import_select_created_objects=False,
                )
    except RuntimeError:
        result = set()
    if not result or "FINISHED" not in result:
        raise ClipError(
            f"'{path.name}' cannot be read by Blender's importer; it is damaged or of a version that is not supported. "
            "Export it again."
        )


def _actions_of(armature, actions) -> list:
    found = []
    for action in actions:
        with contextlib.suppress(ClipError):
            action_curves(armature, action)
            found.append(action)
    return found


def _is_moved_by(obj, armature) -> bool:
    if any(modifier.type == "ARMATURE" and modifier.object == armature for modifier in obj.modifiers):
        return True
    above = obj.parent
    while above is not None and above != armature:
        above = above.parent
    return above == armature


def _plain_name(name: str) -> str:
    """The name of a take, without the names of its object and layer: "Armature|walk|BaseLayer"."""
    parts = name.split("|")
    return parts[1] if len(parts) > 1 else name


def _found_rate(action, rate: float) -> float:
    """Find the rate at which all keys are on frames, and move them there; ``rate`` is that of the scene."""
    curves = _curves(action)
    keys = [_key_times(curve) for curve in curves]
    times = np.unique(np.concatenate(keys)) / rate if keys else np.zeros(1)
    since = times - times[0]
    for own in _RATES:
        if np.abs(since * own - np.round(since * own)).max() < _OFF_FRAME:
            for curve in curves if own != rate else ():
                _stretch(curve, own / rate)
            return float(own)
    return rate


def _key_times(curve) -> np.ndarray:
    places = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
    curve.keyframe_points.foreach_get("co", places)
    return places[::2].astype(float)


def _stretch(curve, factor: float) -> None:
    for name in ("co", "handle_left", "handle_right"):
        places = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
        curve.keyframe_points.foreach_get(name, places)
        places[::2] *= factor
        if name == "co":
            places[::2] = np.round(places[::2], 3)
        curve.keyframe_points.foreach_set(name, places)
    curve.update()


def _curves(action) -> list:
    return [
        curve
        for layer in action.layers
        for strip in layer.strips
        for slot in action.slots
        if (channelbag := strip.channelbag(slot)) is not None
        for curve in channelbag.fcurves
    ]


def _drop_still_placement(armature, action) -> None:
    """Take keys off the object itself that never move it: its place is then the artist's to choose."""
    curves = action_curves(armature, action)
    values = {key: _values(curve) for key, curve in curves.placement.items()}
    if any(np.ptp(of_curve) > 1e-5 * max(1.0, np.abs(of_curve).max()) for of_curve in values.values()):
        return
    channelbag = action.layers[0].strips[0].channelbag(curves.slot)
    for (name, component), curve in list(curves.placement.items()):
        if name in REST_CHANNELS:
            getattr(armature, name)[component] = values[name, component][0]
        channelbag.fcurves.remove(curve)


def _values(curve) -> np.ndarray:
    places = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
    curve.keyframe_points.foreach_get("co", places)
    return places[1::2].astype(float) if len(places) else np.zeros(1)
