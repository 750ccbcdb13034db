"""The sample character: the core's skeleton and repertoire as an armature with a body and one action a clip."""

from collections.abc import Sequence
from typing import cast

import bpy
import numpy as np

from ...core.motion import quat
from ...core.motion.clip import MotionClip
from ...core.motion.repertoire import sample_bone_lengths, sample_skeleton
from ..bridge.body import add_body
from ..bridge.create_armature import create_armature
from ..bridge.rig import bind_rig
from ..bridge.write_action import assign_action, write_clip

NAME = "Wayfarer Character"


def add_sample_character(clips: Sequence[MotionClip], collection) -> tuple[bpy.types.Object, list[bpy.types.Action]]:
    """The armature object and its actions; it plays the first."""
    armature_object = create_armature(sample_skeleton(), _tails(), NAME, collection)
    armature_object.show_in_front = False
    cast(bpy.types.Armature, armature_object.data).display_type = "STICK"
    add_body(armature_object)
    binding = bind_rig(armature_object)
    actions = []
    for clip in clips:
        action = write_clip(armature_object, clip, clip.name, binding=binding)
        # Only one action is played at a time; the others must not be lost on saving.
        action.use_fake_user = True
        actions.append(action)
    assign_action(armature_object, actions[0])
    return armature_object, actions


def _tails() -> dict[str, np.ndarray]:
    """World position of each bone's tail at rest, in metres."""
    skeleton, lengths = sample_skeleton(), sample_bone_lengths()
    rotations, heads = skeleton.rest_world
    tails = heads + lengths[:, None] * quat.rotate(rotations, [0.0, 1.0, 0.0])
    return dict(zip(skeleton.names, tails, strict=True))
