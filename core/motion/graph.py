"""The motion graph: segments of clips and the links between them."""

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_matrix

from ..errors import ClipError, MotionGraphError
from ..progress import Progress, finish
from .clip import MotionClip
from .clip_set import check_skeletons, distinctly_named
from .contacts import ContactSettings, foot_contacts
from .cutting import cut_solutions, kept_goodness, reconnected
from .distance import CostSettings, PoseFeatures, close_pairs, joined, pose_features, transition_costs
from .segmentation import Segmentation, Transitions, segmentation, with_continuations

_N_REFINED = 3
"""Of the cuts found from different starts, how many are refined."""


@dataclass(frozen=True)
class MotionGraphSettings:
    """How clips are cut and linked.

    Attributes
    ----------
    frame_rate : float
        Samples per second at which motion is compared and cut.
    min_segment_duration : float
        Seconds that every segment lasts at least, rounded to whole frames.
    max_cost : float
        Transition cost D (rad^2) above which frames are not linked. Neighbouring frames of a walk at 30
        frames per second differ by 0.1 (slow) to 0.3 (fast).
    sigma : float, optional
        Cost (rad^2) at which the goodness exp(-D / sigma) of a link has fallen to 37 %; a third of
        ``max_cost`` if not given. Smaller values prefer smooth links and more segments, larger ones many
        links.
    cost : CostSettings
        What counts, and how much, in the transition cost.
    contacts : ContactSettings
        When a foot counts as planted; frames are only linked if the same feet are.
    n_starts : int
        How many times the search for cuts begins anew; the best outcome is kept.
    seed : int
        Of the random beginnings: the same seed, the same graph.
    """

    frame_rate: float = 30.0
    min_segment_duration: float = 0.67
    max_cost: float = 0.3
    sigma: float | None = None
    cost: CostSettings = field(default_factory=CostSettings)
    contacts: ContactSettings = field(default_factory=ContactSettings)
    n_starts: int = 8
    seed: int = 0

    def __post_init__(self):
        for name in ("frame_rate", "min_segment_duration", "max_cost"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise MotionGraphError(f"The setting {name.replace('_', ' ')} is {value}; it must be positive.")
        if self.sigma is not None and not self.sigma > 0:
            raise MotionGraphError(f"The setting sigma is {self.sigma}; it must be positive.")
        if self.n_starts < 1:
            raise MotionGraphError("The search for cuts needs at least one start.")

    @property
    def min_gap(self) -> int:
        """Frames from one cut to the next at least."""
        return max(1, round(self.min_segment_duration * self.frame_rate))

    @property
    def goodness_width(self) -> float:
        """``sigma``, or what stands for it."""
        return self.max_cost / 3 if self.sigma is None else self.sigma


@dataclass(frozen=True)
class MotionSegment:
    """A piece of a clip between two cut frames: a node of the motion graph.

    Attributes
    ----------
    name : str
        For people: clip name and source frames.
    clip : int
        Index into ``MotionGraph.clips``.
    first, last : int
        First and last sample of the clip, both played; ``last`` is where the next segment takes over.
    path : (F, 3) float array
        x, y (m) and heading (rad) of every frame relative to the first one: it starts at 0, 0, 0 facing +X.
    duration : float
        Seconds from the first to the last frame.
    tags : mapping of str to (F,) bool array
        For each tag of the clips, the frames of this segment that carry it; absent if none does.
    """

    name: str
    clip: int
    first: int
    last: int
    path: np.ndarray
    duration: float
    tags: Mapping[str, np.ndarray]

    @property
    def n_frames(self) -> int:
        return self.last - self.first + 1


@dataclass(frozen=True)
class DroppedClip:
    """What was left out of the graph: seconds of a clip, and why."""

    clip: str
    seconds: float
    reason: str


@dataclass(frozen=True)
class MotionGraph:
    """Segments and links, reduced to the largest strongly connected component.

    Attributes
    ----------
    clips : tuple of MotionClip
        All at ``frame_rate``.
    frame_rate : float
        Samples per second.
    segments : tuple of MotionSegment
    links : (L, 2) int array
        Segment links[i, 0] may be followed by segment links[i, 1]; sorted, no duplicates.
    link_costs : (L,) float array
        Transition cost D of each link.
    dropped : tuple of DroppedClip
    """

    clips: tuple[MotionClip, ...]
    frame_rate: float
    segments: tuple[MotionSegment, ...]
    links: np.ndarray
    link_costs: np.ndarray
    dropped: tuple[DroppedClip, ...] = ()


def build_motion_graph(clips: Sequence[MotionClip], settings: MotionGraphSettings | None = None) -> MotionGraph:
    """Cut clips into segments, link those that flow into each other, keep the largest connected part.

    See :func:`build_motion_graph_steps`.
    """
    return finish(build_motion_graph_steps(clips, settings))


def build_motion_graph_steps(
    clips: Sequence[MotionClip], settings: MotionGraphSettings | None = None
) -> Generator[Progress, None, MotionGraph]:
    """:func:`build_motion_graph` as a generator that yields Progress and returns the MotionGraph.

    Transition costs after Lee et al. 2002, section 4.1 (:mod:`.distance`), never between frames that differ
    in the feet planted (:mod:`.contacts`); cuts as in :mod:`.cutting`; the largest strongly connected
    component as in the paper. A segment is linked to each one that starts at a frame like its
    last, and to the one that goes on from it in the same clip. The graph's ``clips`` are those long enough to
    hold a segment, in the order given, at the settings' rate; clips that bear the same name get a number.

    Raises ClipError for no clips, different skeletons, or clips all too short; MotionGraphError if nothing
    connects.
    """
    settings = settings or MotionGraphSettings()
    check_skeletons(clips)
    dropped: list[DroppedClip] = []
    usable: list[MotionClip] = []
    features: list[PoseFeatures] = []
    contacts: list[np.ndarray] = []
    for done, clip in enumerate(distinctly_named(clips)):
        yield Progress(0.4 * done / len(clips), f"Reading {clip.name}")
        n_frames = int(clip.duration * settings.frame_rate + 1e-6) + 1
        if n_frames <= settings.min_gap:
            reason = f"shorter than a segment of {settings.min_segment_duration:g} s"
            dropped.append(DroppedClip(clip.name, clip.duration, reason))
            continue
        clip = clip.resampled(settings.frame_rate)
        usable.append(clip)
        features.append(pose_features(clip, settings.cost))
        contacts.append(foot_contacts(clip, settings.contacts))
    if not usable:
        raise ClipError(
            f"All clips are shorter than one segment of {settings.min_segment_duration:g} s (the longest is "
            f"'{max(clips, key=lambda clip: clip.duration).name}'); use longer clips or a shorter minimum."
        )

    yield Progress(0.4, "Comparing frames")
    lengths = np.array([clip.n_frames for clip in usable])
    frames = _Frames(joined(features), np.concatenate(contacts), lengths, settings.min_gap)
    first, second, costs = frames.linkable_pairs(settings.max_cost)

    yield Progress(0.6, "Choosing cuts")
    # However narrow sigma is, a possible link stays worth more than none.
    quality = np.maximum(np.exp(-costs / settings.goodness_width), 1e-6)
    goodness = frames.symmetric(first, second, quality)
    transitions = with_continuations(first, second, costs, len(frames.owner))
    cuts = yield from _choose_cuts(goodness, lengths, settings)
    best = segmentation(cuts, lengths, transitions)
    if not best.kept.any():
        raise _nothing_connects(frames, settings, costs)

    offsets = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    segments = []
    for first_frame, last_frame in zip(best.first[best.kept], best.last[best.kept], strict=True):
        owner = int(frames.owner[first_frame])
        segments.append(
            _segment(usable[owner], owner, int(first_frame - offsets[owner]), int(last_frame - offsets[owner]))
        )
    number = np.cumsum(best.kept) - 1
    return MotionGraph(
        clips=tuple(usable),
        frame_rate=settings.frame_rate,
        segments=tuple(segments),
        links=number[best.links[best.inner]],
        link_costs=best.costs[best.inner],
        dropped=(*dropped, *_left_out(usable, frames, best, transitions, settings)),
    )


def _choose_cuts(
    goodness: csr_matrix, lengths: np.ndarray, settings: MotionGraphSettings
) -> Generator[Progress, None, list[np.ndarray]]:
    """The cuts that keep the most goodness, of those found from all starts."""
    rng = np.random.default_rng(settings.seed)
    found = []
    for cuts in cut_solutions(goodness, lengths, settings.min_gap, settings.n_starts, rng):
        found.append((kept_goodness(goodness, lengths, cuts), cuts))
        yield Progress(0.6 + 0.2 * len(found) / settings.n_starts, "Choosing cuts")
    # Refining takes longer than finding: only the most promising are worth it.
    found.sort(key=lambda scored: -scored[0])
    refined = []
    for rank, (_, cuts) in enumerate(found[:_N_REFINED]):
        for better in reconnected(goodness, lengths, settings.min_gap, cuts):
            refined.append((kept_goodness(goodness, lengths, better), better))
            yield Progress(0.8 + 0.2 * rank / _N_REFINED, "Connecting segments")
    return max(refined, key=lambda scored: scored[0])[1]


def segment_name(clip: MotionClip, first: int, last: int) -> str:
    """For people: "16_11 [34-57]", the clip and the frames of its source that the samples are."""
    start = round(clip.first_frame)
    return f"{clip.name} [{start + first}-{start + last}]"


@dataclass(frozen=True)
class _Frames:
    """The frames of all clips, one clip after the other, as they are compared."""

    features: PoseFeatures
    contacts: np.ndarray
    lengths: np.ndarray
    min_gap: int

    @property
    def owner(self) -> np.ndarray:
        """(N,) int: the clip of each frame."""
        return np.repeat(np.arange(len(self.lengths)), self.lengths)

    def linkable_pairs(self, max_cost: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pairs of frames i < j that can both be cuts and be linked: (i, j, cost), (P,) each."""
        first, second, costs = close_pairs(self.features, max_cost)
        allowed = self.may_link(first, second)
        return first[allowed], second[allowed], costs[allowed]

    def may_link(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Whether the same feet are planted and the cuts would be far enough apart."""
        owner = self.owner
        apart = (owner[first] != owner[second]) | (np.abs(second - first) >= self.min_gap)
        return apart & (self.contacts[first] == self.contacts[second]).all(axis=-1)

    def symmetric(self, first: np.ndarray, second: np.ndarray, values: np.ndarray) -> csr_matrix:
        """(N, N) sparse array with each pair's value at both of its places."""
        n_frames = len(self.contacts)
        places = np.concatenate([first, second]), np.concatenate([second, first])
        return csr_matrix((np.tile(values, 2), places), shape=(n_frames, n_frames))

    def lowest_cost(self) -> float:
        """Lowest cost of any pair that could be linked; infinite if there is none."""
        every = np.arange(len(self.contacts))
        lowest = math.inf
        for rows in np.array_split(every, math.ceil(len(every) / 256)):
            block = PoseFeatures(self.features.rotations[rows], self.features.weights, self.features.vectors[rows])
            costs = transition_costs(block, self.features)
            costs[~self.may_link(rows[:, None], every)] = np.inf
            lowest = min(lowest, float(costs.min()))
        return lowest


def _segment(clip: MotionClip, owner: int, first: int, last: int) -> MotionSegment:
    path = clip.ground_path[first : last + 1] - clip.ground_path[first]
    heading = clip.ground_path[first, 2]
    cos, sin = np.cos(heading), np.sin(heading)
    x, y = path[:, 0].copy(), path[:, 1].copy()
    path[:, 0], path[:, 1] = cos * x + sin * y, cos * y - sin * x
    tags = {tag: np.asarray(mask, dtype=bool)[first : last + 1] for tag, mask in clip.tags.items()}
    return MotionSegment(
        name=segment_name(clip, first, last),
        clip=owner,
        first=first,
        last=last,
        path=path,
        duration=(last - first) / clip.frame_rate,
        tags={tag: mask for tag, mask in tags.items() if mask.any()},
    )


def _left_out(
    clips: list[MotionClip],
    frames: _Frames,
    cut: Segmentation,
    transitions: Transitions,
    settings: MotionGraphSettings,
) -> list[DroppedClip]:
    """What of each clip is in no kept segment, in seconds by reason."""
    n_frames = len(frames.contacts)
    is_start, is_end = np.zeros(n_frames, dtype=bool), np.zeros(n_frames, dtype=bool)
    is_start[cut.first[cut.kept]] = is_end[cut.last[cut.kept]] = True
    switches = transitions.end != transitions.start
    linkable, entered, left = np.zeros((3, len(clips)), dtype=bool)
    linkable[frames.owner[transitions.start[switches]]] = True
    entered[frames.owner[transitions.start[switches & is_end[transitions.end]]]] = True
    left[frames.owner[transitions.end[switches & is_start[transitions.start]]]] = True
    offsets = np.concatenate([[0], np.cumsum(frames.lengths)[:-1]])
    dropped = []
    for index, clip in enumerate(clips):
        own = np.flatnonzero(cut.kept & (frames.owner[cut.first] == index))
        if len(own):
            # What is kept of a clip is in one piece: whatever lies between two kept segments joins them.
            before = float(cut.first[own[0]] - offsets[index]) / clip.frame_rate
            after = clip.duration - float(cut.last[own[-1]] - offsets[index]) / clip.frame_rate
            if before > 0:
                dropped.append(DroppedClip(clip.name, before, "no transition leads to its beginning"))
            if after > 1e-9:
                dropped.append(DroppedClip(clip.name, after, "no transition leads back from its end"))
            continue
        if not linkable[index]:
            reason = f"no transitions at a cost of {settings.max_cost:g} or less"
        elif entered[index] and left[index]:
            reason = "no transition leads to it early enough to leave it again"
        elif entered[index]:
            reason = "no transition leads back from it"
        elif left[index]:
            reason = "no transition leads to it"
        else:
            reason = "its transitions lead only to motion that was dropped"
        dropped.append(DroppedClip(clip.name, clip.duration, reason))
    return dropped


def _nothing_connects(frames: _Frames, settings: MotionGraphSettings, costs: np.ndarray) -> MotionGraphError:
    lowest = float(costs.min()) if len(costs) else frames.lowest_cost()
    if not math.isfinite(lowest):
        return MotionGraphError(
            "Nothing connects: no two frames far enough apart have the same feet on the ground. Use more or "
            "longer clips, or a shorter minimum segment."
        )
    advice = math.ceil(15 * max(lowest, settings.max_cost if len(costs) else 0.0)) / 10
    return MotionGraphError(
        f"Nothing connects at a cost of {settings.max_cost:g} or less: the lowest cost between frames that "
        f"could be linked is {lowest:.2g}. Raise the maximum cost to {advice:g}, shorten the minimum segment, or "
        "add clips."
    )
