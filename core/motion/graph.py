"""The motion graph: segments of clips and the links between them."""

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .. import wording
from ..errors import ClipError, MotionGraphError
from ..progress import Progress, finish, portion
from .clip import MotionClip
from .clip_set import check_skeletons, distinctly_named
from .contacts import foot_contacts
from .distance import PoseFeatures, joined, pose_features
from .dropped import DroppedClip, dropped_motion
from .frame_pairs import FrameSet, longest_of
from .graph_settings import MotionGraphSettings, ThresholdMode
from .loops import lowest_loop_cost_steps
from .segmentation import Segmentation, with_continuations
from .threshold import segmentation_steps

__all__ = [
    "DroppedClip",
    "MotionGraph",
    "MotionGraphSettings",
    "MotionSegment",
    "ThresholdMode",
    "build_motion_graph",
    "build_motion_graph_steps",
    "segment_name",
]

_JOINT_BYTES = 400
"""What a joint takes at the most in a frame while clips are read and compared: measured, 290 to 350."""


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
        What of the clips is not in ``segments``, and why.
    max_cost : float
        The threshold (rad^2) that the links were made at; not a number if they were not made by it.
    dropped_segments : tuple of MotionSegment
        Segments that were cut, but lie outside the component.
    dropped_links : (D, 2) int array
        Links from or to those, numbered on from ``segments``: segment len(segments) is dropped_segments[0].
    """

    clips: tuple[MotionClip, ...]
    frame_rate: float
    segments: tuple[MotionSegment, ...]
    links: np.ndarray
    link_costs: np.ndarray
    dropped: tuple[DroppedClip, ...] = ()
    max_cost: float = math.nan
    dropped_segments: tuple[MotionSegment, ...] = ()
    dropped_links: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=int))


def build_motion_graph(clips: Sequence[MotionClip], settings: MotionGraphSettings | None = None) -> MotionGraph:
    """Cut clips into segments, link those that flow into each other, keep the largest connected part.

    See :func:`build_motion_graph_steps`.
    """
    return finish(build_motion_graph_steps(clips, settings))


def build_motion_graph_steps(
    clips: Sequence[MotionClip], settings: MotionGraphSettings | None = None
) -> Generator[Progress, None, MotionGraph]:
    """Build a motion graph, step by step.

    Transition costs after Lee et al. 2002, section 4.1 (:mod:`.distance`), never between frames that differ
    in the feet planted (:mod:`.contacts`); cuts as in :mod:`.cutting`; the largest strongly connected
    component as in the paper. A segment is linked to each one that starts at a frame like its
    last, and to the one that goes on from it in the same clip. The graph's ``clips`` are those long enough to
    hold a segment, in the order given, at the settings' rate; clips that bear the same name get a number.

    Raises ClipError for no clips, different skeletons, or clips all too short; MotionGraphError if nothing
    connects, or so much that it would take more memory than ``settings.memory_limit``.
    """
    settings = settings or MotionGraphSettings()
    check_skeletons(clips)
    dropped: list[DroppedClip] = []
    usable: list[MotionClip] = []
    features: list[PoseFeatures] = []
    contacts: list[np.ndarray] = []
    _check_memory(clips, settings)
    for done, clip in enumerate(distinctly_named(clips)):
        yield Progress(0.2 * done / len(clips), f"Reading {clip.name}")
        if _n_frames(clip, settings) <= settings.min_gap:
            reason = f"shorter than a segment of {wording.exact(settings.min_segment_duration)} s"
            dropped.append(DroppedClip(clip.name, clip.duration, reason))
            continue
        clip = clip.resampled(settings.frame_rate)
        usable.append(clip)
        features.append(pose_features(clip, settings.cost))
        contacts.append(foot_contacts(clip, settings.contacts))
    if not usable:
        raise ClipError(
            f"All clips are shorter than one segment of {wording.exact(settings.min_segment_duration)} s (the longest "
            f"is '{max(clips, key=lambda clip: clip.duration).name}'); use longer clips or a shorter Min Segment."
        )

    lengths = np.array([clip.n_frames for clip in usable])
    names = [clip.name for clip in usable]
    frames = FrameSet(joined(features), np.concatenate(contacts), lengths, settings.min_gap, names)
    pairs = yield from portion(frames.pairs_steps(settings.max_cost, settings.memory_limit), 0.2, 0.5)
    n_given = sum(clip.duration for clip in clips) * settings.frame_rate
    threshold, cut = yield from portion(segmentation_steps(pairs, frames, settings, n_given), 0.5, 1.0)
    if not cut.kept.any():
        raise (yield from portion(_nothing_connects_steps(frames, settings), 1.0, 1.0))
    yield Progress(1.0, "Linking segments")
    pairs = pairs.up_to(threshold)
    transitions = with_continuations(pairs.first, pairs.second, pairs.cost, frames.n_frames)
    dropped += dropped_motion(usable, frames, cut, transitions, threshold)

    segments = _segments(usable, frames, cut)
    # Kept segments come first, so that the links' numbers hold for the graph and for what was dropped.
    order = np.argsort(~cut.kept, kind="stable")
    number = np.argsort(order)
    outer = number[cut.links[~cut.inner]]
    n_kept = np.count_nonzero(cut.kept)
    return MotionGraph(
        clips=tuple(usable),
        frame_rate=settings.frame_rate,
        segments=tuple(segments[i] for i in order[:n_kept]),
        links=number[cut.links[cut.inner]],
        link_costs=cut.costs[cut.inner],
        dropped=tuple(dropped),
        max_cost=threshold,
        dropped_segments=tuple(segments[i] for i in order[n_kept:]),
        dropped_links=outer[np.lexsort((outer[:, 1], outer[:, 0]))],
    )


def segment_name(clip: MotionClip, first: int, last: int) -> str:
    """Name a segment for people: "16_11 [34-57]", the clip and the frames of its source that the samples are."""
    start = round(clip.first_frame)
    return f"{clip.name} [{start + first}-{start + last}]"


def _segments(clips: Sequence[MotionClip], frames: FrameSet, cut: Segmentation) -> list[MotionSegment]:
    owners = frames.owner[cut.first]
    first, last = cut.first - frames.offsets[owners], cut.last - frames.offsets[owners]
    return [
        _segment(clips[owner], owner, *span)
        for owner, *span in zip(owners.tolist(), first.tolist(), last.tolist(), strict=True)
    ]


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


def _check_memory(clips: Sequence[MotionClip], settings: MotionGraphSettings) -> None:
    """Raise MotionGraphError, before any is read, for clips whose frames would take more memory than allowed."""
    lengths = [_n_frames(clip, settings) for clip in clips]
    needed = sum(lengths) * clips[0].skeleton.n_joints * _JOINT_BYTES
    if needed > settings.memory_limit:
        raise MotionGraphError(
            f"These {len(clips)} clips have {wording.number(sum(lengths))} frames at "
            f"{wording.exact(settings.frame_rate)} per second. To compare them would need about "
            f"{wording.memory(needed)}, more than the limit of {wording.memory(settings.memory_limit)}; lower Frame "
            f"Rate, or use fewer or shorter clips{longest_of([clip.name for clip in clips], lengths)}."
        )


def _n_frames(clip: MotionClip, settings: MotionGraphSettings) -> int:
    """Count the frames of a clip at the settings' rate."""
    return int(clip.duration * settings.frame_rate + 1e-6) + 1


def _nothing_connects_steps(
    frames: FrameSet, settings: MotionGraphSettings
) -> Generator[Progress, None, MotionGraphError]:
    lowest = yield from lowest_loop_cost_steps(frames, settings.max_cost, settings.memory_limit)
    if lowest == math.inf:
        return MotionGraphError(
            "Nothing connects, at whatever cost: no motion as long as a segment leads back to where it begins by way "
            "of frames with the same feet on the ground. Use more or longer clips, or a shorter Min Segment."
        )
    failure = f"Nothing connects at a cost of {wording.exact(settings.max_cost)} or less: "
    if lowest is None:
        return MotionGraphError(
            f"{failure}no transition leads back to where the motion begins, and to look at dearer ones would need more "
            f"than the limit of {wording.memory(settings.memory_limit)}. Shorten Min Segment, use other clips, or "
            "fewer of them."
        )
    # Half as much again, so that the graph is more than the one loop.
    advice = math.ceil(15 * lowest) / 10
    return MotionGraphError(
        f"{failure}the lowest cost at which motion leads back to where it begins is {wording.short(lowest)}. Raise Max "
        f"Cost to {wording.exact(advice)}, shorten Min Segment, or add clips."
    )
