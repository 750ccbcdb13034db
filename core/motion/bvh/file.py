"""The content of a BVH file: joints, their channels, and the values of these."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import quat

Frames = slice | np.ndarray


@dataclass(frozen=True)
class BvhFile:
    """A BVH file as it is: lengths in its own unit, along its own axes.

    Attributes
    ----------
    name : str
        The file's name.
    names : tuple of str
        Joints, parents first; no two are alike.
    parents : (J,) int array
        -1 for the root only.
    offsets : (J, 3) float array
        Place of each joint at rest, relative to its parent; the axes of all joints are those of the file then.
    ends : (J, 3) float array
        End site of each joint relative to it; not a number where there is none.
    channels : tuple of tuple of str
        Channels of each joint: "Xposition", "Zrotation" ..., "" for one of another kind.
    columns : (J,) int array
        Place of each joint's first channel in a row of ``values``.
    frame_rate : float
        Frames per second.
    values : (F, C) float array
        Every frame's channels; angles in degrees.
    remarks : tuple of str
        Sentences on what is odd and was read all the same.
    """

    name: str
    names: tuple[str, ...]
    parents: np.ndarray
    offsets: np.ndarray
    ends: np.ndarray
    channels: tuple[tuple[str, ...], ...]
    columns: np.ndarray
    frame_rate: float
    values: np.ndarray
    remarks: tuple[str, ...] = ()

    @property
    def n_frames(self) -> int:
        return len(self.values)

    @property
    def n_joints(self) -> int:
        return len(self.names)

    @cached_property
    def carriers(self) -> tuple[int, ...]:
        """Joints from the root down to where the body branches: their places are travel, not proportions."""
        chain = [0]
        while len(below := np.flatnonzero(self.parents == chain[-1])) == 1:
            chain.append(int(below[0]))
        return tuple(chain)

    def order(self, joint: int) -> str:
        """Return the axes that a joint turns about, in the order of its channels: "ZXY"; empty if it does not."""
        return "".join(channel[0] for channel in self.channels[joint] if channel.endswith("rotation"))

    def moves(self, joint: int) -> bool:
        """Test whether a joint has channels for its place."""
        return any(channel.endswith("position") for channel in self.channels[joint])

    def rotations(self, frames: Frames = slice(None)) -> np.ndarray:
        """Return (F, J, 4) the rotations of joints relative to their parents, on these frames."""
        values = self.values[frames]
        result = np.tile(quat.IDENTITY, (len(values), self.n_joints, 1))
        alike: dict[str, list[int]] = {}
        for joint in range(self.n_joints):
            alike.setdefault(self.order(joint), []).append(joint)
        for order, joints in alike.items():
            if order:
                columns = [self._columns(joint, "rotation") for joint in joints]
                result[:, joints] = quat.from_euler(order, np.radians(values[:, columns]))
        return result

    def translations(self, frames: Frames = slice(None)) -> np.ndarray:
        """Return (F, J, 3) the places of joints relative to their parents, on these frames.

        What a joint's channels say stands for its offset. Only where all that they say is next to nothing beside the
        offsets is it added to them.
        """
        values = self.values[frames]
        result = np.tile(self.offsets, (len(values), 1, 1))
        added = self._adds_positions
        for joint in range(self.n_joints):
            for channel, column in zip(self.channels[joint], self._columns(joint), strict=True):
                if channel.endswith("position"):
                    axis = "XYZ".index(channel[0])
                    base = self.offsets[joint, axis] if added and joint > 0 else 0.0
                    result[:, joint, axis] = base + values[:, column]
        return result

    def _columns(self, joint: int, kind: str = "") -> list[int]:
        first = int(self.columns[joint])
        return [first + k for k, channel in enumerate(self.channels[joint]) if channel.endswith(kind)]

    @cached_property
    def _adds_positions(self) -> bool:
        shares = []
        for joint in np.setdiff1d(np.arange(self.n_joints), self.carriers):
            length = np.linalg.norm(self.offsets[joint])
            columns = self._columns(joint, "position")
            if columns and length > 0:
                shares.append(np.linalg.norm(np.abs(self.values[:, columns]).max(axis=0)) / length)
        return bool(shares) and float(np.median(shares)) < 0.05
