"""A motion graph in numbers: how its segments are connected, and what became of every clip."""

from dataclasses import dataclass

import numpy as np

from .graph import MotionGraph


@dataclass(frozen=True)
class ClipUse:
    """The use that is made of a clip.

    Attributes
    ----------
    name : str
    seconds : float
        Of the clip as it was given.
    kept_seconds : float
        Of its segments in the graph.
    n_segments : int
        How many those are.
    losses : tuple of (float, str)
        Seconds that were left out, and why.
    """

    name: str
    seconds: float
    kept_seconds: float
    n_segments: int
    losses: tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class GraphSummary:
    """A motion graph in numbers.

    Attributes
    ----------
    in_degree, out_degree : (S,) int array
        Links to and from each segment.
    by_connection : (S,) int array
        Segments, those that most pairs of links meet in (in-degree x out-degree) first: the hubs.
    clips : tuple of ClipUse
        Every clip that was given, those in the graph first, otherwise in the order given.
    """

    in_degree: np.ndarray
    out_degree: np.ndarray
    by_connection: np.ndarray
    clips: tuple[ClipUse, ...]

    @property
    def seconds(self) -> float:
        """Seconds of all clips given."""
        return sum(clip.seconds for clip in self.clips)

    @property
    def kept_seconds(self) -> float:
        """Seconds of all segments."""
        return sum(clip.kept_seconds for clip in self.clips)

    @property
    def dropped(self) -> tuple[tuple[str, float, str], ...]:
        """Clip, seconds and reason of everything that was left out."""
        return tuple((clip.name, *loss) for clip in self.clips for loss in clip.losses)

    def hubs(self, count: int) -> np.ndarray:
        """(at most ``count``,) int: the best connected segments, the best first."""
        return self.by_connection[:count]


def summarize(graph: MotionGraph) -> GraphSummary:
    """Summarize a motion graph: degrees and hubs of its segments, use of its clips."""
    n_segments = len(graph.segments)
    out_degree = np.bincount(graph.links[:, 0], minlength=n_segments)
    in_degree = np.bincount(graph.links[:, 1], minlength=n_segments)
    losses: dict[str, list[tuple[float, str]]] = {clip.name: [] for clip in graph.clips}
    for dropped in graph.dropped:
        losses.setdefault(dropped.clip, []).append((dropped.seconds, dropped.reason))
    kept = dict.fromkeys(losses, 0.0)
    counts = dict.fromkeys(losses, 0)
    for segment in graph.segments:
        name = graph.clips[segment.clip].name
        kept[name] += segment.duration
        counts[name] += 1
    # Those that were too short for the graph are known by their losses only.
    given = {clip.name: clip.duration for clip in graph.clips}
    return GraphSummary(
        in_degree,
        out_degree,
        np.argsort(-in_degree * out_degree, kind="stable"),
        tuple(
            ClipUse(name, given.get(name, sum(s for s, _ in lost)), kept[name], counts[name], tuple(lost))
            for name, lost in losses.items()
        ),
    )
