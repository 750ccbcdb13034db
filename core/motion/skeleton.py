"""The joints of a character: names, hierarchy and rest pose."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import ClipError
from . import quat
from .joint_roles import JointRole, guess_joint_roles
from .kinematics import ancestors, are_positions, descendants, world_transforms
from .sides import mirrored_pairs


@dataclass(frozen=True)
class Skeleton:
    """A tree of joints; joint 0 is the root and parents come before their children.

    Attributes
    ----------
    names : tuple of str
        One per joint: the bone's name.
    parents : (J,) int array
        Index of each joint's parent; -1 for the root only.
    rest_rotations : (J, 4) float array
        Rest orientation, quaternion (w, x, y, z): of the root in world space, of the others relative to the parent.
    rest_translations : (J, 3) float array
        Rest position in metres, in the same frames.
    forward : (3,) float array
        The character's forward direction as a unit vector in the root joint's own frame.
    """

    names: tuple[str, ...]
    parents: np.ndarray
    rest_rotations: np.ndarray
    rest_translations: np.ndarray
    forward: np.ndarray

    def __post_init__(self):
        parents = np.asarray(self.parents)
        if len(self.names) != len(parents) or len(parents) == 0:
            raise ClipError("A skeleton needs at least one bone, and one parent entry for each bone.")
        if parents[0] != -1 or np.any(parents[1:] < 0) or np.any(parents >= np.arange(len(parents))):
            raise ClipError(
                f"The bones of the skeleton rooted at '{self.names[0]}' do not form one tree with parents first."
            )
        if len(set(self.names)) < len(self.names):
            twice = next(name for place, name in enumerate(self.names) if name in self.names[:place])
            raise ClipError(f"Two bones of the skeleton are called '{twice}'; rename one of them.")
        bad = ~(quat.are_rotations(self.rest_rotations) & are_positions(self.rest_translations))
        if bad.any():
            raise ClipError(
                f"The rest pose of bone '{self.names[np.argmax(bad)]}' is none: its place or its rotation is not a "
                "number; repair that bone."
            )
        if not np.linalg.norm(self.forward) > 1e-6:
            raise ClipError(f"The skeleton rooted at '{self.names[0]}' has no forward direction; choose its axis.")

    @cached_property
    def rest_world(self) -> tuple[np.ndarray, np.ndarray]:
        """World rotations (J, 4) and joint positions (J, 3) in metres of the rest pose; read-only."""
        rotations, positions = world_transforms(self.rest_rotations[None], self.rest_translations[None], self.parents)
        for array in (rotations, positions):
            array.flags.writeable = False
        return rotations[0], positions[0]

    @cached_property
    def rest_forward(self) -> np.ndarray:
        """(3,) the forward direction of the rest pose in the world."""
        return quat.rotate(self.rest_rotations[0], self.forward)

    @cached_property
    def stature(self) -> float:
        """Size of the rest pose in metres: its largest extent along an axis of the world, a person's height."""
        return max(float(np.ptp(self.rest_world[1], axis=0).max()), 1e-6)

    @cached_property
    def roles(self) -> Mapping[tuple[JointRole, str], tuple[int, ...]]:
        """Joints by role and side: see :func:`.joint_roles.guess_joint_roles`."""
        left = np.cross([0.0, 0.0, 1.0], self.rest_forward)
        return guess_joint_roles(self.names, self.parents, self.rest_world[1], left)

    @property
    def hips(self) -> int:
        """The joint whose height is that of the body: where the thighs meet, or the root if no names say where."""
        return self.roles.get((JointRole.HIPS, ""), (0,))[-1]

    @cached_property
    def fingers(self) -> np.ndarray:
        """(J,) bool: joints below the hands, which are the children of the lower arms; none if no arms are known."""
        forearms = {joints[0] for (role, _), joints in self.roles.items() if role is JointRole.LOWER_ARM}
        below = np.zeros(self.n_joints, dtype=bool)
        for hand in np.flatnonzero(np.isin(self.parents, list(forearms))):
            below[self.descendants(hand)] = True
        return below

    @cached_property
    def partners(self) -> np.ndarray:
        """(J,) int: for each joint the one whose name differs only in its side, or itself if there is none."""
        result = np.arange(self.n_joints)
        for left, right in mirrored_pairs(self.names):
            joints = self.index(left), self.index(right)
            if all(result[joint] == joint for joint in joints):
                result[list(joints)] = joints[::-1]
        return result

    def ancestors(self, joint: int) -> list[int]:
        """List the joints above one, nearest first, the root last."""
        return ancestors(self.parents, joint)

    def descendants(self, joint: int) -> list[int]:
        """List the joints that hang from one, parents first."""
        return descendants(self.parents, joint)

    @property
    def n_joints(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Return the index of the joint called ``name``; ClipError names the bone if there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise ClipError(f"The skeleton has no bone called '{name}'.") from None

    def is_like(self, other: "Skeleton") -> bool:
        """Test whether clips of ``other`` can be mixed with clips of this one: same names, same hierarchy."""
        return self.names == other.names and np.array_equal(self.parents, other.parents)
