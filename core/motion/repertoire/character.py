"""The sample character: a humanoid of 1.75 m that rests in an A-pose, facing -Y, its left towards +X."""

from dataclasses import dataclass

import numpy as np

from .. import quat
from ..kinematics import local_transforms
from ..skeleton import Skeleton

REST_HEADING = -np.pi / 2
"""Heading of the rest pose: Blender's characters face -Y."""

SIDES = {"Left": 1, "Right": -1}
"""Which way a side lies along the character's left axis."""

# The foot in its own sagittal plane, relative to the ankle: (forward, up) in metres.
ANKLE_HEIGHT = 0.075
HEEL = np.array([-0.055, -0.075])
TOE_JOINT = np.array([0.125, -0.055])
TOE_LENGTH = 0.07
STATION_OFFSET = 0.05
"""The body's weight rests this far ahead of the ankles when it stands, in metres."""

_FORWARD, _UP = (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)
_A_POSE = np.array([np.cos(np.radians(45)), 0.0, -np.sin(np.radians(45))])
_ARM = np.array([0.18, 0.01, 1.43])
_ANKLE = np.array([0.09, 0.015, ANKLE_HEIGHT])
_TOE = _ANKLE + np.array([0.0, -TOE_JOINT[0], TOE_JOINT[1]])

# Bone, parent, head and tail at rest (world, metres; the left side stands for both),
# direction of the bone's Z axis.
# Z axes are chosen so that turning about +X always swings a bone's tip forward (a foot's: upward).
_TRUNK = (
    ("Hips", None, (0, 0, 0.95), (0, 0, 1.05), _FORWARD),
    ("Spine", "Hips", (0, 0, 1.05), (0, 0.01, 1.17), _FORWARD),
    ("Spine1", "Spine", (0, 0.01, 1.17), (0, 0.02, 1.30), _FORWARD),
    ("Spine2", "Spine1", (0, 0.02, 1.30), (0, 0.02, 1.48), _FORWARD),
    ("Neck", "Spine2", (0, 0.02, 1.48), (0, 0.0, 1.57), _FORWARD),
    ("Head", "Neck", (0, 0.0, 1.57), (0, 0.0, 1.75), _FORWARD),
)
_LIMBS = (
    ("Shoulder", "Spine2", (0.03, 0.01, 1.43), _ARM, _FORWARD),
    ("Arm", "Shoulder", _ARM, _ARM + 0.29 * _A_POSE, _FORWARD),
    ("ForeArm", "Arm", _ARM + 0.29 * _A_POSE, _ARM + 0.54 * _A_POSE, _FORWARD),
    ("Hand", "ForeArm", _ARM + 0.54 * _A_POSE, _ARM + 0.72 * _A_POSE, _FORWARD),
    ("UpLeg", "Hips", (0.09, 0, 0.92), (0.09, 0, 0.495), _FORWARD),
    ("Leg", "UpLeg", (0.09, 0, 0.495), _ANKLE, _FORWARD),
    ("Foot", "Leg", _ANKLE, _TOE, _UP),
    ("ToeBase", "Foot", _TOE, _TOE - [0.0, TOE_LENGTH, 0.0], _UP),
)


def _bones() -> list[tuple[str, str | None, np.ndarray, np.ndarray, tuple]]:
    """Name, parent, head, tail and Z direction of every bone, parents first."""
    bones = [(name, parent, np.array(head, float), np.array(tail, float), z) for name, parent, head, tail, z in _TRUNK]
    trunk = {name for name, *_ in _TRUNK}
    for side, sign in SIDES.items():
        mirror = np.array([sign, 1.0, 1.0])
        for name, parent, head, tail, z in _LIMBS:
            parent = parent if parent in trunk else side + parent
            bones.append((side + name, parent, mirror * head, mirror * tail, z))
    return bones


@dataclass(frozen=True)
class Character:
    """The sample character: skeleton, joints' world orientations at rest (J, 4), bone lengths (J,) in metres."""

    skeleton: Skeleton
    rest: np.ndarray
    lengths: np.ndarray

    def rest_of(self, bone: str) -> np.ndarray:
        """Return the (4,) world orientation of a bone at rest."""
        return self.rest[self.skeleton.index(bone)]

    def offset_of(self, bone: str) -> np.ndarray:
        """Return the (3,) position of a bone's head in its parent's frame, in metres."""
        return self.skeleton.rest_translations[self.skeleton.index(bone)]

    def length_of(self, bone: str) -> float:
        return float(self.lengths[self.skeleton.index(bone)])


def sample_character() -> Character:
    """Build the sample character from the table of its bones."""
    bones = _bones()
    names = tuple(bone[0] for bone in bones)
    parents = np.array([-1 if bone[1] is None else names.index(bone[1]) for bone in bones])
    heads, tails, z = (np.array([bone[part] for bone in bones], float) for part in (2, 3, 4))
    lengths = np.linalg.norm(tails - heads, axis=1)
    y = (tails - heads) / lengths[:, None]
    x = np.cross(y, z)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    world = quat.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1))
    forward = quat.rotate(quat.inverse(world[0]), _FORWARD)
    skeleton = Skeleton(names, parents, *local_transforms(world, heads, parents), forward)
    return Character(skeleton, world, lengths)


def sample_skeleton() -> Skeleton:
    """Return the sample character's 22 joints.

    At rest it stands in an A-pose with its hips above the world's origin, facing -Y. As in Blender, each bone
    lies along its joint's Y axis; :func:`sample_bone_lengths` has the lengths.
    """
    return sample_character().skeleton


def sample_bone_lengths() -> np.ndarray:
    """Return the (J,) bone lengths of the sample character (m): tails are at (0, length, 0) in a joint's frame."""
    return sample_character().lengths
