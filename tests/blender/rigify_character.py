"""The human that Blender's own Rigify generates, walking by its controls."""

from collections.abc import Sequence

import addon_utils
import bpy
import numpy as np
from mathutils import Matrix
from scipy.spatial.transform import Rotation

from bl_ext.user_default.wayfarer.core.motion.clip import MotionClip
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_skeleton

from .rigs import Character, Curves, ground_motion, placed, similarity

BASIC, FULL = "armature_basic_human_metarig_add", "armature_human_metarig_add"
"""Operators that add the metarig: the full one has a face and fingers, and takes seconds to generate."""

_SIDES = {"Left": ".L", "Right": ".R"}
_LIMB_CONTROLS = {"Shoulder": "shoulder", "Arm": "upper_arm_fk", "ForeArm": "forearm_fk", "Hand": "hand_fk"}
_DEFORMING = {
    "Arm": "upper_arm",
    "ForeArm": "forearm",
    "Hand": "hand",
    "UpLeg": "thigh",
    "Leg": "shin",
    "Foot": "foot",
    "ToeBase": "toe",
}
_JOINTS = {name: joint for joint, name in enumerate(sample_skeleton().names)}
_REACH = 0.985
"""Its legs as a part of what they would be if they fitted exactly: knees that are never quite straight."""


def rigify_character(clips: Sequence[MotionClip], root_travels: bool = False, metarig: str = BASIC) -> Character:
    """Torso, chest and feet go by IK, arms by FK; keys on controls only.

    The object is scaled so that the character is as large as the sample, moved and turned. The root control stays
    behind, without keys, or goes along on the ground.
    """
    rig = _generated_human(metarig)
    rest = {bone.name: np.array(bone.matrix_local) for bone in rig.data.bones}
    _, heads = sample_skeleton().rest_world
    own_leg = rest["DEF-thigh.L"][2, 3] - rest["DEF-foot.L"][2, 3]
    size = _REACH * own_leg / (heads[_JOINTS["LeftUpLeg"], 2] - heads[_JOINTS["LeftFoot"], 2])
    floor = rest["DEF-toe.L"][2, 3] - size * heads[_JOINTS["LeftToeBase"], 2]
    rig.matrix_world = Matrix(similarity((0, 0, 25), (1.0, 0.5, -floor / size), 1 / size))
    for side in _SIDES.values():
        rig.pose.bones["upper_arm_parent" + side]["IK_FK"] = 1.0
    for clip in clips:
        _Animator(rig, rest, clip, size, floor, root_travels).animate()
    names = {
        side + joint: f"DEF-{bone}{suffix}" for side, suffix in _SIDES.items() for joint, bone in _DEFORMING.items()
    }
    place = similarity((0, 0, 25), (1.0, 0.5, 0.0))
    return Character(
        rig.name,
        tuple(clip.name for clip in clips),
        tuple(placed(clip, place) for clip in clips),
        "ORG-spine",
        {"Hips": "ORG-spine", **names},
        controls=("torso", *("foot_ik" + side for side in _SIDES.values())),
        is_copy=False,
    )


class _Animator:
    """Keys the controls so that they follow one clip; all poses are in armature space, ``size`` times the sample's."""

    def __init__(self, rig, rest, clip, size, floor, root_travels):
        self._rest, self._clip, self._curves = rest, clip, Curves(clip.name, rig)
        self._positions = size * clip.world[1] + [0.0, 0.0, floor]
        self._ground = np.tile(np.eye(4), (clip.n_frames, 1, 1))
        if root_travels:
            self._ground = ground_motion(clip)
            self._ground[:, :3, 3] *= size
            basis = np.linalg.inv(rest["root"]) @ self._ground @ rest["root"]
            self._curves.pose("root", basis, "QUATERNION", True)

    def animate(self) -> None:
        thighs = [self._positions[:, _JOINTS[side + "UpLeg"]] for side in _SIDES]
        middle = (self._rest["DEF-thigh.L"][:3, 3] + self._rest["DEF-thigh.R"][:3, 3]) / 2
        self._carry("torso", self._turned("Hips"), middle, (thighs[0] + thighs[1]) / 2)
        self._turn("chest", "Spine2", "Hips")
        for side, suffix in _SIDES.items():
            pivot, ball = self._rest["DEF-toe" + suffix][:3, 3], self._positions[:, _JOINTS[side + "ToeBase"]]
            self._carry("foot_ik" + suffix, self._turned(side + "Foot"), pivot, ball)
            self._turn("toe_ik" + suffix, side + "ToeBase", side + "Foot")
            parent = "Spine2"
            for joint, control in _LIMB_CONTROLS.items():
                self._turn(control + suffix, side + joint, parent)
                parent = side + joint

    def _turned(self, joint):
        """The (F,) turns of a joint from its rest pose, in the world."""
        rest = Rotation.from_quat(sample_skeleton().rest_world[0][_JOINTS[joint]], scalar_first=True)
        return Rotation.from_quat(self._clip.world[0][:, _JOINTS[joint]], scalar_first=True) * rest.inv()

    def _carry(self, control, turn, pivot, target):
        """Turn and move a control so that a point of the rest pose gets to ``target``."""
        rest = self._rest[control]
        poses = np.tile(np.eye(4), (self._clip.n_frames, 1, 1))
        poses[:, :3, :3] = turn.as_matrix() @ rest[:3, :3]
        poses[:, :3, 3] = target + turn.apply(rest[:3, 3] - pivot)
        self._curves.pose(control, np.linalg.inv(self._ground @ rest) @ poses, "QUATERNION", True)

    def _turn(self, control, joint, parent):
        """Turn a control as a joint turns in relation to another, in the axes of the rest pose."""
        axes = Rotation.from_matrix(self._rest[control][:3, :3])
        basis = np.tile(np.eye(4), (self._clip.n_frames, 1, 1))
        turn = self._turned(parent).inv() * self._turned(joint)
        basis[:, :3, :3] = (axes.inv() * turn * axes).as_matrix()
        self._curves.pose(control, basis, "QUATERNION", False)


def _generated_human(metarig):
    # Its settings live in the preferences, and its panels are none of the tests' business.
    addon_utils.enable("rigify", default_set=True)
    try:
        getattr(bpy.ops.object, metarig)()
        template = bpy.context.object
        bpy.ops.pose.rigify_generate()
        rig = bpy.context.object
        bpy.data.objects.remove(template)
    finally:
        addon_utils.disable("rigify", default_set=True)
    return rig
