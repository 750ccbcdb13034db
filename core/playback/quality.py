"""The quality of a walk's motion in numbers, and where it is worst."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise, repeat

import numpy as np
from numpy.typing import ArrayLike

from .. import wording
from ..errors import ClipError, WalkError
from ..motion.body_size import relative_size
from ..motion.clip import MotionClip
from ..motion.contacts import ContactSettings, foot_joints
from .pace import idle_frames, times_turned_back
from .plants import Plant, clip_plants, walk_plants
from .spikes import BEYOND, LURCH, GraphRoughness, find_spikes, graph_roughness
from .transitions import transition_gaps
from .walk import Walk

#: Unit, its value in terms of metres, radians and seconds, and what an onlooker begins to notice, for each kind of
#: defect. Defects of different kinds are ranked by how many times they exceed that.
_KINDS = {
    "slide": ("cm/s", 100, 0.1),
    "gap": ("°", 180 / np.pi, np.radians(20)),
    "speed": ("m/s", 1, 0.3),
    "turn": ("°/s", 180 / np.pi, np.radians(45)),
    "edit": ("cm/m", 100, 0.08),
    "knee": ("times what the clips do", BEYOND, 1.0),
    "joint": ("times what the clips do", BEYOND, 1.0),
    "lurch": ("m/s²", LURCH, 1.0),
}


@dataclass(frozen=True)
class FootSlide:
    """The speed (m/s) at which a foot slides over the ground while it is planted.

    Measured at what it stands on (:class:`.plants.Plant`), from each frame to the next. ``worst_frame`` is the first
    of the two frames of the walk; ``source_mean`` that of the clips that the walk is made of. All are 0 for a foot
    that is never planted. A foot that clean-up has lifted off the ground for a step does not slide meanwhile.
    """

    foot: str
    mean: float
    worst: float
    worst_frame: int
    source_mean: float


@dataclass(frozen=True)
class PoseGap:
    """The largest angle (rad) that a joint has to make up for at a transition, before blending."""

    frame: int
    joint: str
    angle: float
    clip_before: str
    clip_after: str


@dataclass(frozen=True)
class TransitionJump:
    """The largest change at a transition of the root's speed (m/s), or of its turn rate (rad/s), within one frame."""

    frame: int
    value: float


@dataclass(frozen=True)
class WorstFrame:
    """A frame worth looking at: what is wrong there, how much, and how many times what is noticeable that is."""

    frame: int
    what: str
    value: float
    unit: str
    severity: float

    @property
    def amount(self) -> str:
        """The value with its unit.

        >>> WorstFrame(7, "Foot slides", 12.34, "cm/s", severity=1.2).amount
        '12.3 cm/s'
        """
        space = "" if self.unit.startswith("°") else " "
        return f"{wording.amount(self.value)}{space}{self.unit}"


@dataclass(frozen=True)
class WalkQuality:
    """Defects of a walk's motion, as :func:`walk_quality` finds them.

    Attributes
    ----------
    feet : tuple of FootSlide
        Left and right; none if the feet are not known.
    feet_unknown : str
        The reason; empty if they are known.
    largest_gap : PoseGap or None
        None for a walk without transitions, as of the jumps.
    position_edit, heading_edit : float
        Metres and radians by which the root path was edited to reach its grid elements, for each metre of it.
    speed_jump, turn_jump : TransitionJump or None
    idle : float
        Share of the frames in which the character stands, turns on the spot or shuffles (:mod:`.pace`).
    turns_back : float
        Times that it turns back in each minute.
    worst_frames : tuple of WorstFrame
        The worst first: of each plant its fastest frame, of each transition its largest gap and its jumps, of each
        segment its edit; and the spikes of knees and joints, and lurches (:mod:`.spikes`).
    defects : float
        The excess of everything that is noticeable over that, in times of it, summed over all frames, for each minute:
        0 for a walk in which nothing is. To choose between walks by.
    """

    feet: tuple[FootSlide, ...]
    feet_unknown: str
    largest_gap: PoseGap | None
    position_edit: float
    heading_edit: float
    speed_jump: TransitionJump | None
    turn_jump: TransitionJump | None
    idle: float
    turns_back: float
    worst_frames: tuple[WorstFrame, ...]
    defects: float

    @property
    def mean_slide(self) -> float:
        """Mean of both feet in metres per second; not a number if they are not known."""
        return float(np.mean([foot.mean for foot in self.feet])) if self.feet else float("nan")


def walk_quality(
    walk: Walk,
    clip: MotionClip,
    contacts: ContactSettings | None = None,
    n_worst: int = 20,
    lifted: np.ndarray | None = None,
    rough: GraphRoughness | None = None,
) -> WalkQuality:
    """Measure the motion ``clip`` that a walk became, cleaned up or not. Frames are those of the walk, from 0.

    ``lifted``, an (F, 2) bool array, says when the left and the right foot are in the air although the clips have
    them planted: :attr:`.cleanup.FootCleanup.lifted`. Every other frame of a plant counts, held or not.

    ``rough`` saves time when several motions of one motion graph are measured: :func:`.spikes.graph_roughness`.

    WalkError if the clip, or ``lifted``, has another number of frames than the walk.
    """
    if clip.n_frames != walk.node_frames[-1] + 1:
        raise WalkError(
            f"The motion has {clip.n_frames} frames and the walk {walk.node_frames[-1] + 1}; measure the motion at the "
            "motion graph's frame rate."
        )
    if lifted is None:
        lifted = np.zeros((clip.n_frames, 2), dtype=bool)
    if lifted.shape != (clip.n_frames, 2):
        raise WalkError(
            f"Lifted feet are given as {lifted.shape} values and the walk has {clip.n_frames} frames of two feet; give "
            "those of the clean-up that made the motion."
        )
    contacts = contacts or ContactSettings()
    feet, feet_unknown, worst = _slides(walk, clip, contacts, lifted)
    gap, gaps = _gaps(walk)
    speed_jump, turn_jump, jumps = _jumps(walk, clip)
    position_edit, heading_edit, edits = _edits(walk)
    worst += gaps + jumps + edits + _spikes(walk, clip, rough or graph_roughness(walk.embedding.graph, contacts))
    worst.sort(key=lambda entry: (-entry.severity, entry.frame))
    minutes = max(walk.duration, 1e-9) / 60
    path, size = clip.ground_path, relative_size(clip.skeleton)
    return WalkQuality(
        feet=feet,
        feet_unknown=feet_unknown,
        largest_gap=gap,
        position_edit=position_edit,
        heading_edit=heading_edit,
        speed_jump=speed_jump,
        turn_jump=turn_jump,
        idle=float(idle_frames(path, clip.frame_rate, size).mean()),
        turns_back=times_turned_back(path[:, 2], clip.frame_rate) / minutes,
        worst_frames=tuple(worst[:n_worst]),
        defects=sum(max(entry.severity - 1, 0.0) for entry in worst) / minutes,
    )


def foot_slide(plants: list[Plant], positions: np.ndarray, frame_rate: float) -> np.ndarray:
    """Return (n,) m/s that feet slide from frame to frame during plants; ``positions`` (F, J, 3) in metres."""
    return np.concatenate([np.empty(0), *(plant.speeds(positions, frame_rate) for plant in plants)])


def _worst(kind: str, frames: ArrayLike, values: ArrayLike, what: Iterable[str]) -> list[WorstFrame]:
    """Return an entry for each of (n,) frames of a walk and (n,) values there."""
    unit, factor, noticeable = _KINDS[kind]
    return [
        WorstFrame(int(frame), name, float(value) * factor, unit, float(value) / noticeable)
        for frame, value, name in zip(np.asarray(frames), np.asarray(values), what, strict=False)
    ]


def _slides(walk: Walk, clip: MotionClip, settings: ContactSettings, lifted: np.ndarray):
    graph, skeleton = walk.embedding.graph, clip.skeleton
    try:
        joints = foot_joints(skeleton, settings.feet)
        plants = walk_plants(walk, settings)
    except ClipError as error:
        return (), str(error), []
    sources = [graph.clips[i] for i in sorted({graph.segments[s].clip for s in walk.segments})]
    source_plants = [(clip_plants(source, settings), source.world[1]) for source in sources]
    positions, feet, worst = clip.world[1], [], []
    for side in (0, 1):
        name = skeleton.names[joints[side][0]]
        speeds, frames, fastest = [np.empty(0)], [], []
        for plant in plants:
            if plant.side != side or plant.n_frames == 1:
                continue
            slide = plant.speeds(positions, graph.frame_rate)
            # From the last frame on the ground to the first one off it the foot may slide, and back likewise.
            up = lifted[plant.first : plant.last + 1, side]
            grounded = ~(up[:-1] & up[1:])
            speeds.append(slide[grounded])
            slide = np.where(grounded, slide, 0.0)
            frames.append(plant.first + int(np.argmax(slide)))
            fastest.append(float(slide.max()))
        of_source = np.concatenate(
            [foot_slide([p for p in found if p.side == side], at, graph.frame_rate) for found, at in source_plants]
        )
        speeds = np.concatenate(speeds)
        feet.append(
            FootSlide(
                name,
                mean=float(speeds.mean()) if len(speeds) else 0.0,
                worst=float(speeds.max(initial=0.0)),
                worst_frame=frames[int(np.argmax(fastest))] if frames else 0,
                source_mean=float(of_source.mean()) if len(of_source) else 0.0,
            )
        )
        worst += _worst("slide", frames, fastest, repeat(f"{name} slides"))
    return tuple(feet), "", worst


def _spikes(walk: Walk, clip: MotionClip, rough: GraphRoughness) -> list[WorstFrame]:
    names, worst = clip.skeleton.names, []
    for kind, what, spikes in zip(
        ("knee", "joint", "lurch"), ("{} snaps", "{} jerks", "{} lurches"), find_spikes(walk, clip, rough), strict=True
    ):
        frames, severities = [spike.frame for spike in spikes], [spike.severity for spike in spikes]
        worst += _worst(kind, frames, severities, (what.format(names[spike.joint]) for spike in spikes))
    return worst


def _gaps(walk: Walk) -> tuple[PoseGap | None, list[WorstFrame]]:
    graph = walk.embedding.graph
    if len(walk) < 2:
        return None, []
    gaps = transition_gaps(walk)
    names = graph.clips[0].skeleton.names
    joints, angles = np.argmax(gaps.angles, axis=1), gaps.angles.max(axis=1)
    at = int(np.argmax(angles))
    before, after = (graph.clips[graph.segments[s].clip].name for s in walk.segments[at : at + 2])
    largest = PoseGap(int(gaps.frames[at]), names[joints[at]], float(angles[at]), before, after)
    return largest, _worst("gap", gaps.frames, angles, (f"pose gap of {names[joint]}" for joint in joints))


def _jumps(walk: Walk, clip: MotionClip) -> tuple[TransitionJump | None, TransitionJump | None, list[WorstFrame]]:
    frames = walk.node_frames[1:-1]
    if len(frames) == 0:
        return None, None, []
    steps = np.diff(clip.ground_path, axis=0) * walk.embedding.graph.frame_rate
    speeds, turns = np.linalg.norm(steps[:, :2], axis=1), steps[:, 2]
    found, worst = [], []
    for kind, values, what in (("speed", speeds, "change of speed"), ("turn", turns, "change of turn rate")):
        jumps = np.abs(values[frames] - values[frames - 1])
        at = int(np.argmax(jumps))
        found.append(TransitionJump(int(frames[at]), float(jumps[at])))
        worst += _worst(kind, frames, jumps, repeat(what))
    return found[0], found[1], worst


def _edits(walk: Walk) -> tuple[float, float, list[WorstFrame]]:
    stencils = walk.embedding.unrolling.stencils
    moved = np.linalg.norm(stencils.position_error[walk.stencils], axis=1)
    turned = np.abs(stencils.heading_error[walk.stencils])
    path, frames = walk.root_path[:, :2], walk.node_frames
    lengths = np.array([np.linalg.norm(np.diff(path[a : b + 1], axis=0), axis=1).sum() for a, b in pairwise(frames)])
    total = max(float(np.sum(lengths)), 1e-9)
    # Over less than a step a metre says little.
    shares = moved / np.maximum(lengths, 0.5)
    worst = _worst("edit", frames[:-1], shares, repeat("edited root path"))
    return float(moved.sum()) / total, float(turned.sum()) / total, worst
