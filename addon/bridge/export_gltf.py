"""A character with its clips as a .glb file, by Blender's own exporter."""

import contextlib
import io
from collections.abc import Iterable
from pathlib import Path

import addon_utils
import bpy

from ...core.errors import ExportError
from .action_curves import action_curves
from .read_actions import source_frame_rate

_EXPORTER = "io_scene_gltf2"


def export_clips(armature_object, actions: Iterable[tuple[str, bpy.types.Action]], path: Path) -> None:
    """Write an armature, the meshes that it moves and the given (name, action) pairs, each an animation of that name.

    Each animation starts at 0 s with the first frame of its action, and lasts as many seconds as the clip read from it.
    Nothing of the scene is changed.

    Raises ExportError if Blender cannot export, ClipError for an action that does not move the armature.
    """
    if not addon_utils.check(_EXPORTER)[1]:
        addon_utils.enable(_EXPORTER)
    view_layer = bpy.context.view_layer
    if armature_object.name not in view_layer.objects:
        raise ExportError(
            f"'{armature_object.name}' is in no collection that the view layer shows; include its collection to export."
        )
    wanted = [armature_object, *_moved_meshes(armature_object, view_layer)]
    with _selected(wanted, view_layer), _tracks(armature_object, actions), _quiet() as said:
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
            raise ExportError(f"Blender cannot write '{path}': {str(error).strip().splitlines()[-1]}") from None
    if done != {"FINISHED"} or not path.is_file():
        last = (said.getvalue().strip().splitlines() or ["it does not say why"])[-1]
        raise ExportError(f"Blender cannot write '{path}': {last}")


def _moved_meshes(armature_object, view_layer) -> list:
    """Meshes that hang on the armature, by parent or by modifier."""
    return [
        obj
        for obj in view_layer.objects
        if obj.type == "MESH" and (obj.parent == armature_object or obj.find_armature() == armature_object)
    ]


@contextlib.contextmanager
def _selected(objects, view_layer):
    """Only these objects are selected, and none of them hidden."""
    active, mode = view_layer.objects.active, None
    if active is not None and active.mode != "OBJECT":
        mode = active.mode
        bpy.ops.object.mode_set(mode="OBJECT")
    before = [obj for obj in view_layer.objects if obj.select_get()]
    hidden = [obj for obj in objects if obj.hide_get()]
    disabled = [obj for obj in objects if obj.hide_viewport]
    try:
        for obj in before:
            obj.select_set(False)
        for obj in disabled:
            obj.hide_viewport = False
        for obj in hidden:
            obj.hide_set(False)
        for obj in objects:
            obj.select_set(True)
        view_layer.objects.active = objects[0]
        yield
    finally:
        for obj in objects:
            obj.select_set(False)
        for obj in hidden:
            obj.hide_set(True)
        for obj in disabled:
            obj.hide_viewport = True
        for obj in before:
            obj.select_set(True)
        view_layer.objects.active = active
        if mode is not None:
            bpy.ops.object.mode_set(mode=mode)


@contextlib.contextmanager
def _tracks(armature_object, actions):
    """Every action is a track of the armature's, at its own rate; what the armature plays is put aside."""
    has_data = armature_object.animation_data is not None
    animation = armature_object.animation_data or armature_object.animation_data_create()
    action, slot = animation.action, animation.action_slot
    render, frame = bpy.context.scene.render, bpy.context.scene.frame_current
    scene_rate = render.fps / render.fps_base
    added = []
    try:
        animation.action = None
        for name, clip_action in actions:
            curves = action_curves(armature_object, clip_action)
            frames = curves.frames()
            track = animation.nla_tracks.new()
            added.append(track)
            track.name = name
            strip = track.strips.new(name, int(frames[0]), clip_action)
            strip.action_slot = curves.slot
            strip.action_frame_start, strip.action_frame_end = float(frames[0]), float(frames[-1])
            strip.scale = scene_rate / source_frame_rate(clip_action)
            strip.frame_start = float(int(frames[0]))
            strip.extrapolation = "NOTHING"
        yield
    finally:
        for track in added:
            animation.nla_tracks.remove(track)
        if action is not None:
            animation.action, animation.action_slot = action, slot
        bpy.context.scene.frame_set(frame)
        if not has_data:
            armature_object.animation_data_clear()


@contextlib.contextmanager
def _quiet():
    """What the exporter tells about its progress goes into a text."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        yield said
