"""Plants: when, and on which of its joints, a foot stands while a walk is played."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..motion.clip import MotionClip
from ..motion.contacts import ContactSettings, foot_joints, joint_contacts
from ..motion.runs import runs
from .walk import Walk

_HALF_STEP = 0.65
"""Windows that a step takes on each side of where the foot is fastest."""


@dataclass(frozen=True)
class Plant:
    """A stretch of frames during which a foot stays on the ground, rolling from one of its joints to another.

    Attributes
    ----------
    side : int
        0 for the left foot, 1 for the right one.
    first, last : int
        Its frames, both included.
    pivots : (last - first + 1,) int array
        The joint that the foot stands on in each frame: of those on the ground the one farthest down the foot (the
        toes, if they are, else the ankle).
    """

    side: int
    first: int
    last: int
    pivots: np.ndarray

    @property
    def n_frames(self) -> int:
        return self.last - self.first + 1

    def later(self, frames: int) -> "Plant":
        """Return the same plant some frames later."""
        return Plant(self.side, self.first + frames, self.last + frames, self.pivots)

    def within(self, first: int, last: int) -> "Plant":
        """Return the part of it from one frame to another, both included."""
        a, b = max(self.first, first), min(self.last, last)
        return Plant(self.side, a, b, self.pivots[a - self.first : b + 1 - self.first])

    def shift(self, positions: np.ndarray) -> np.ndarray:
        """Return (n_frames, 2) metres that would keep the foot where it stands, starting from 0, 0.

        The opposite of how the pivot travels on the ground in ``positions`` (F, J, 3). From one frame to the next it
        is the pivot of the later one that must not move.

        >>> plant = Plant(side=0, first=1, last=2, pivots=np.array([0, 0]))
        >>> plant.shift(np.array([[[0, 0, 0]], [[1, 0, 0]], [[1.5, 0, 0]]])) + 0.0
        array([[ 0. ,  0. ],
               [-0.5,  0. ]])
        """
        later = np.arange(self.first + 1, self.last + 1)
        joints = self.pivots[1:]
        travelled = positions[later, joints, :2] - positions[later - 1, joints, :2]
        return -np.concatenate([np.zeros((1, 2)), np.cumsum(travelled, axis=0)])

    def speeds(self, positions: np.ndarray, frame_rate: float) -> np.ndarray:
        """Return (n_frames - 1,) metres per second that the pivot slides on the ground from each frame to the next."""
        return np.linalg.norm(np.diff(self.shift(positions), axis=0), axis=1) * frame_rate


@dataclass(frozen=True)
class SplitPlant:
    """A plant, and the parts of it in each of which the foot can be held in one place, in order.

    Between two parts the foot makes a step; before the first and after the last one it is in the air: it comes later
    or leaves earlier.
    """

    plant: Plant
    parts: tuple[Plant, ...]


def split_plant(plant: Plant, positions: np.ndarray, farthest: float, window: int) -> SplitPlant:
    """Split a plant so that, where possible, no part moves the foot by more than ``farthest`` metres.

    It is split where the foot is fastest in ``positions`` (F, J, 3), by steps of about one and a half windows. Where
    that is too near to an end for standing there, the plant loses up to ``window`` frames at that end instead.
    """
    return SplitPlant(plant, tuple(_split(plant, positions, farthest, window, (True, True))))


def _split(
    plant: Plant, positions: np.ndarray, farthest: float, window: int, cuttable: tuple[bool, bool]
) -> list[Plant]:
    """``cuttable`` says whether the plant may lose frames at its start, and at its end."""
    shift = plant.shift(positions)
    if np.linalg.norm(shift - shift.mean(axis=0), axis=1).max() <= farthest:
        return [plant]
    first, last = plant.first, plant.last
    # Half a step, and the least that a foot stands.
    half, least = max(round(_HALF_STEP * window), 1), max(window // 2, 2)
    low = first if cuttable[0] else first + least - 1 + half
    high = last - 1 if cuttable[1] else last - least - half
    if low > high:
        return [plant]
    fastest = low + int(np.argmax(plant.speeds(positions, 1.0)[low - first : high + 1 - first]))
    before, after = fastest - half, fastest + 1 + half
    stands_before, stands_after = before - first + 1 >= least, last - after + 1 >= least
    if stands_before and stands_after:
        return [
            *_split(plant.within(first, before), positions, farthest, window, (cuttable[0], False)),
            *_split(plant.within(after, last), positions, farthest, window, (False, cuttable[1])),
        ]
    if not stands_before and cuttable[0] and last - (first + window) + 1 >= least:
        rest = plant.within(min(after, first + window), last)
        return _split(rest, positions, farthest, window, (False, cuttable[1]))
    if not stands_after and cuttable[1] and (last - window) - first + 1 >= least:
        rest = plant.within(first, max(before, last - window))
        return _split(rest, positions, farthest, window, (cuttable[0], False))
    return [plant]


def overlapping(plants: Sequence[Plant]) -> list[Plant]:
    """Return plants of which each lasts a frame longer, where the other foot comes down only after its last frame.

    Else no foot would stand from the one frame to the next, as if the character jumped.

    >>> pivots = np.zeros(3, dtype=int)
    >>> [(plant.first, plant.last) for plant in overlapping([Plant(0, 0, 2, pivots), Plant(1, 3, 5, pivots)])]
    [(0, 3), (3, 5)]
    """
    comes_down = {(plant.side, plant.first) for plant in plants}
    return [
        Plant(plant.side, plant.first, plant.last + 1, np.append(plant.pivots, plant.pivots[-1]))
        if (1 - plant.side, plant.last + 1) in comes_down and (plant.side, plant.last + 2) not in comes_down
        else plant
        for plant in plants
    ]


def repeated(plants: Sequence[Plant], lap: int, n_laps: int) -> list[Plant]:
    """Return the plants of a motion that is repeated every ``lap`` frames, joined where laps go on from one another.

    >>> plant = Plant(side=0, first=0, last=10, pivots=np.zeros(11, dtype=int))
    >>> [(plant.first, plant.last) for plant in repeated([plant], lap=10, n_laps=3)]
    [(0, 30)]
    """
    found: list[Plant] = []
    for side in (0, 1):
        own = [plant.later(number * lap) for number in range(n_laps) for plant in plants if plant.side == side]
        for plant in own:
            before = found[-1] if found and found[-1].side == side else None
            if before is not None and plant.first <= before.last:
                pivots = np.concatenate([before.pivots, plant.pivots[before.last - plant.first + 1 :]])
                found[-1] = Plant(side, before.first, before.first + len(pivots) - 1, pivots)
            else:
                found.append(plant)
    return found


def clip_plants(clip: MotionClip, settings: ContactSettings | None = None) -> list[Plant]:
    """Find the plants of a clip; ClipError if its feet are not known."""
    settings = settings or ContactSettings()
    return _plants(joint_contacts(clip, settings), foot_joints(clip.skeleton, settings.feet))


def walk_plants(walk: Walk, settings: ContactSettings | None = None) -> list[Plant]:
    """Find the plants of a walk: those of the source clips, joined across its transitions.

    The clips know better than the blended motion when a foot stands: there it may slide. On the frame of a transition
    a joint is planted if it is so on either side. ClipError if the feet are not known.
    """
    settings = settings or ContactSettings()
    graph = walk.embedding.graph
    feet = foot_joints(graph.clips[0].skeleton, settings.feet)
    contacts = [np.zeros((walk.node_frames[-1] + 1, len(foot)), dtype=bool) for foot in feet]
    of_clip: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for index, first, last in zip(walk.segments, walk.node_frames[:-1], walk.node_frames[1:], strict=True):
        segment = graph.segments[index]
        if segment.clip not in of_clip:
            of_clip[segment.clip] = joint_contacts(graph.clips[segment.clip], settings)
        for planted, source in zip(contacts, of_clip[segment.clip], strict=True):
            planted[first : last + 1] |= source[segment.first : segment.last + 1]
    return _plants(contacts, feet)


def _plants(contacts: Sequence[np.ndarray], feet: Sequence[Sequence[int]]) -> list[Plant]:
    found = []
    for side, (planted, foot) in enumerate(zip(contacts, feet, strict=True)):
        # Joints are in order from the ankle to the tip.
        lowest = np.asarray(foot)[len(foot) - 1 - np.argmax(planted[:, ::-1], axis=1)]
        found += [Plant(side, a, b, lowest[a : b + 1]) for a, b in runs(planted.any(axis=1))]
    return found
