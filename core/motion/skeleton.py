"""The joints of a character: names, hierarchy and rest pose."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import ClipError
from . import quat
from .kinematics import are_positions, world_transforms


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

    @property
    def n_joints(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Index of the joint called ``name``; ClipError names the bone if there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise ClipError(f"The skeleton has no bone called '{name}'.") from None

    def is_like(self, other: "Skeleton") -> bool:
        """Whether clips of ``other`` can be mixed with clips of this one: same names, same hierarchy."""
        return self.names == other.names and np.array_equal(self.parents, other.parents)
