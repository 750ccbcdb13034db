"""The f-curves of an action that move one armature, sampled as arrays."""

from dataclasses import dataclass, field

import bpy
import numpy as np

from ...core.errors import ClipError
from .rotation_modes import REST_CHANNELS

_CONSTANT, _LINEAR = 0, 1  # values of Keyframe.interpolation in foreach_get
_LAST_FRAME = 1_048_574  # the highest that Blender can show


@dataclass(frozen=True)
class ActionCurves:
    """The curves of one action that move one armature; lives no longer than the call that reads it.

    ``bones`` maps (bone name, property, component) and ``placement`` maps (property, component) of the object
    itself to an f-curve.
    """

    action: bpy.types.Action
    slot: bpy.types.ActionSlot
    bones: dict = field(default_factory=dict)
    placement: dict = field(default_factory=dict)

    def frames(self) -> np.ndarray:
        """(F,) frame numbers, one apart, of the action's manual range, or else from its first to its last key.

        Raises ClipError if those are fewer than two, or if the first or the last is none that Blender can show.
        """
        if self.action.use_frame_range:
            ends = [(self.action.frame_start, self.action.frame_end)]
        else:
            curves = (*self.bones.values(), *self.placement.values())
            # A curve may consist of modifiers alone.
            keyed = [curve.range() for curve in curves if len(curve.keyframe_points) or len(curve.sampled_points)]
            ends = keyed or [(0.0, 0.0)]
        if not (np.abs(ends) <= _LAST_FRAME).all():
            raise ClipError(
                f"Action '{self.action.name}' begins or ends at a frame that is not a number, or that Blender cannot "
                "show; repair or delete its first and last keys, or correct its manual frame range."
            )
        first, last = min(start for start, _ in ends), max(end for _, end in ends)
        if last - first < 1:
            raise ClipError(
                f"Action '{self.action.name}' is shorter than two frames; a motion needs at least two. "
                "Add keys, widen its manual frame range or leave it out."
            )
        return first + np.arange(int(np.floor(last - first + 1e-3)) + 1)

    def bone_channels(self, bone: str, name: str, frames: np.ndarray) -> np.ndarray | None:
        """(F, C) values of a bone's transform property, or None if nothing animates it."""
        return self._channels(self.bones, (bone, name), frames, REST_CHANNELS[name], f"bone '{bone}'")

    def placement_channels(self, name: str, frames: np.ndarray, current) -> np.ndarray:
        """(F, C) values of the object's transform property; components without a curve keep ``current``."""
        values = self._channels(self.placement, (name,), frames, current, "the object itself")
        return np.tile(np.asarray(current, dtype=float), (len(frames), 1)) if values is None else values

    def _channels(self, curves, key, frames, default, owner):
        animated = [(i, curves[(*key, i)]) for i in range(len(default)) if (*key, i) in curves]
        if not animated:
            return None
        values = np.tile(np.asarray(default, dtype=float), (len(frames), 1))
        for component, curve in animated:
            values[:, component] = sample_curve(curve, frames)
            finite = np.isfinite(values[:, component])
            if not finite.all():
                raise ClipError(
                    f"Action '{self.action.name}': the {key[-1]} of {owner} is not a number at frame "
                    f"{frames[np.argmin(finite)]:g}; repair or delete that key."
                )
        return values


def action_curves(armature_object, action) -> ActionCurves:
    """The curves of ``action`` that move ``armature_object``, from the slot that suits it.

    That is the slot assigned to the object, if this action is; otherwise the one that animates most of its
    bones, where the slot that the object used last wins a tie. Muted and invalid curves are left out, as
    Blender does.

    Raises ClipError if the action moves none of the armature's bones.
    """
    if action is None:
        raise ClipError(f"The armature '{armature_object.name}' has no action; choose the actions to use.")
    animation = armature_object.animation_data
    slots = _usable_slots(action)
    if animation and animation.action == action and animation.action_slot in slots:
        slots = [animation.action_slot]
    candidates = [_slot_curves(armature_object, action, slot) for slot in slots]
    last_used = animation.last_slot_identifier if animation else ""
    best = max(candidates, default=None, key=lambda c: (len(c.bones), c.slot.identifier == last_used))
    if best is None or not best.bones:
        raise ClipError(
            f"Action '{action.name}' animates none of the bones of '{armature_object.name}'; it belongs to "
            "another character or its bones were renamed. Leave it out or choose another armature."
        )
    return best


def actions_of(armature_object) -> list[bpy.types.Action]:
    """All actions of the file that animate at least one bone of ``armature_object``, in the file's order."""
    return [
        action
        for action in bpy.data.actions
        if any(_slot_curves(armature_object, action, slot).bones for slot in _usable_slots(action))
    ]


def sample_curve(curve, frames: np.ndarray) -> np.ndarray:
    """(F,) values of an f-curve at the frame numbers ``frames``, as Blender evaluates it.

    Keys that lie on the frames are copied and straight stretches interpolated at once; anything else
    (Bezier between the frames, modifiers, baked samples, linear extrapolation) is left to Blender frame by
    frame.
    """
    n_keys = len(curve.keyframe_points)
    if n_keys == 0 or any(not modifier.mute for modifier in curve.modifiers):
        return _evaluated(curve, frames)
    keys = np.empty(2 * n_keys, dtype=np.float32)
    curve.keyframe_points.foreach_get("co", keys)
    times, values = keys.reshape(-1, 2).astype(float).T
    if n_keys == len(frames) and np.abs(times - frames).max() < 1e-4:
        return values
    if curve.extrapolation == "LINEAR" and (frames[0] < times[0] - 1e-4 or frames[-1] > times[-1] + 1e-4):
        return _evaluated(curve, frames)
    if not np.all(np.diff(times) > 1e-3):  # keys on top of each other
        return _evaluated(curve, frames)

    inside = np.clip(frames, times[0], times[-1])
    before = np.maximum(np.searchsorted(times, inside + 1e-4) - 1, 0)
    on_key = np.abs(times[before] - inside) < 1e-4
    if on_key.all():
        return values[before]
    interpolation = np.empty(n_keys, dtype=np.int32)
    curve.keyframe_points.foreach_get("interpolation", interpolation)
    used = interpolation[before[~on_key]]
    if not np.isin(used, (_CONSTANT, _LINEAR)).all():
        return _evaluated(curve, frames)
    held = on_key | (interpolation[before] == _CONSTANT)
    return np.where(held, values[before], np.interp(inside, times, values))


def _evaluated(curve, frames):
    return np.array([curve.evaluate(frame) for frame in frames])


def _usable_slots(action):
    return [slot for slot in action.slots if slot.target_id_type in ("OBJECT", "UNSPECIFIED")]


def _slot_curves(armature_object, action, slot) -> ActionCurves:
    found = ActionCurves(action, slot)
    own_bones = {
        f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"]': bone.name for bone in armature_object.data.bones
    }
    for layer in action.layers:
        for strip in layer.strips:
            channelbag = strip.channelbag(slot)
            for curve in channelbag.fcurves if channelbag else ():
                # A group's mute is a matter of the editors: Blender evaluates its curves all the same.
                if curve.mute or not curve.is_valid or curve.is_empty:
                    continue
                owner, _, name = curve.data_path.rpartition(".")
                if name not in REST_CHANNELS:
                    continue
                if owner == "":
                    found.placement[name, curve.array_index] = curve
                elif owner in own_bones:
                    found.bones[own_bones[owner], name, curve.array_index] = curve
    return found
