"""Motions that might be captured: as segments that nobody has recorded, and how they would join the motion graph.

A motion graph needs of a segment only its path on the ground, its duration, its tags and its neighbours. Poses are left
to the performer, who is asked to begin and end in those of a segment that is well connected: the *template*.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...embedding.footprint import path_length
from ...environment.regions import RegionRule
from ...motion.graph import MotionGraph, MotionSegment

#: A segment travels, or turns, if it gets on by at least so much (m, rad).
TRAVEL = 0.3
TURN = np.radians(15)

#: m/s and rad/s that are assumed where no segment travels or turns.
USUAL_SPEED, USUAL_TURN_RATE = 1.0, np.radians(90)

#: Sidesteps and steps back are that much slower than walking.
SIDESTEP_SPEED = 0.5

#: No motion is shorter than this (s).
SHORTEST = 0.3

#: Two segments lead to the same place if their ends are within this (m, rad).
SAME_PLACE, SAME_HEADING = 0.15, np.radians(15)


@dataclass(frozen=True)
class Candidate:
    """A segment that might be captured, and where it would stand in the motion graph.

    Attributes
    ----------
    words : str
        For people: "a 60 degree left turn over 0.9 m".
    segment : MotionSegment
        Its ``clip`` and frames are those of no recording.
    parents, children : tuple of int
        Segments of the motion graph that it may follow, and that may follow it.
    repeats : bool
        Whether it may follow itself.
    """

    words: str
    segment: MotionSegment
    parents: tuple[int, ...]
    children: tuple[int, ...]
    repeats: bool = False


@dataclass(frozen=True)
class CandidateFamily:
    """The motions to try.

    Attributes
    ----------
    lengths : tuple of float
        Metres of the way forwards; 0 is on the spot.
    turns : tuple of float
        Radians from the first heading to the last, left is positive. Each is tried with each length.
    sidesteps : tuple of float
        Metres of straight steps to the left, to the right and backwards.
    mirrored : bool
        Try the mirror image of segments that turn or step aside, where no segment leads to the same place already.
    retimings : tuple of float
        Factors by which segments last longer or shorter; they change how long ways take, not where they lead.
    n_retimed : int
        How many segments are retimed: those with the most nodes in the embedding.
    """

    lengths: tuple[float, ...] = (0.0, 0.4, 0.8, 1.2, 1.6)
    turns: tuple[float, ...] = tuple(np.radians([0, 45, -45, 90, -90, 135, -135, 180, -180]).tolist())
    sidesteps: tuple[float, ...] = (0.4, 0.8)
    mirrored: bool = True
    retimings: tuple[float, ...] = (0.8, 1.25)
    n_retimed: int = 5


def augmented(graph: MotionGraph, candidate: Candidate) -> MotionGraph:
    """Add a candidate to the motion graph as its last segment; what was dropped is left out."""
    new = len(graph.segments)
    added = [(parent, new) for parent in candidate.parents] + [(new, child) for child in candidate.children]
    if candidate.repeats:
        added.append((new, new))
    links = np.concatenate([graph.links, np.array(added, dtype=int).reshape(-1, 2)])
    costs = np.concatenate([graph.link_costs, np.full(len(added), np.nan)])
    order = np.lexsort((links[:, 1], links[:, 0]))
    return replace(
        graph,
        segments=(*graph.segments, candidate.segment),
        links=links[order],
        link_costs=costs[order],
        dropped=(),
        dropped_segments=(),
        dropped_links=np.empty((0, 2), dtype=int),
    )


def template_segment(embedding: Embedding) -> int:
    """Choose the segment whose neighbours new motions get: of those that travel, the one most pairs of links meet in.

    Among equals the one with the most nodes in the embedding, then the first. Where none travels, all take part.
    """
    graph = embedding.graph
    into = np.bincount(graph.links[:, 1], minlength=len(graph.segments))
    out = np.bincount(graph.links[:, 0], minlength=len(graph.segments))
    nodes = nodes_of_segments(embedding)
    travelling = [i for i, segment in enumerate(graph.segments) if path_length(segment) >= TRAVEL]
    return max(travelling or range(len(graph.segments)), key=lambda i: (into[i] * out[i], nodes[i], -i))


def nodes_of_segments(embedding: Embedding) -> list[int]:
    """Count the nodes that each segment has in the embedding."""
    n_headings = embedding.shape[2]
    sizes = [plane.bit_count() for plane in embedding.planes]
    return [sum(sizes[i : i + n_headings]) for i in range(0, len(sizes), n_headings)]


def candidates(embedding: Embedding, family: CandidateFamily | None = None, retimed: bool = False) -> list[Candidate]:
    """Lay out the family of motions to try for an embedding.

    Virtual segments are circular arcs with constant speed: as long as it takes at the mean speed of the segments that
    travel, or at the mean turn rate of those that turn, whichever takes longer. They, and mirror images, begin and end
    as the template does. Straight ones are tried with every tag that a region requires, too. ``retimed`` adds retimed
    segments, which keep their own neighbours: they can shorten times, but open no floor.
    """
    family = family or CandidateFamily()
    graph = embedding.graph
    template = template_segment(embedding)
    required = sorted({r.tag for r in embedding.environment.regions if r.rule is RegionRule.REQUIRE})
    speed, turn_rate = mean_speeds(graph.segments)
    found = []
    for length in family.lengths:
        for turn in family.turns:
            # On the spot, half a turn to the left leads where half a turn to the right does.
            if (length or turn) and (length or turn > -np.pi + 1e-9):
                duration = max(length / speed, abs(turn) / turn_rate)
                for tag in [None, *required] if turn == 0 else [None]:
                    words = move_words(length, turn) + (f" with the tag '{tag}'" if tag else "")
                    path = _arc(length, turn, 0.0, _n_frames(duration, graph.frame_rate))
                    found.append(_like(graph, template, words, path, {tag: np.ones(len(path), bool)} if tag else {}))
    for length in family.sidesteps:
        for direction, words in ((90, "to the left"), (-90, "to the right"), (180, "backwards")):
            duration = length / (SIDESTEP_SPEED * speed)
            path = _arc(length, 0.0, np.radians(direction), _n_frames(duration, graph.frame_rate))
            found.append(_like(graph, template, f"a step of {wording.exact(length)} m {words}", path, {}))
    if family.mirrored:
        found += _mirror_images(graph, template)
    if retimed:
        found += _retimed(embedding, family)
    return found


def move_words(length: float, turn: float) -> str:
    """Describe a move of some metres and radians.

    >>> move_words(0.9, np.radians(60)), move_words(0.8, 0.0)
    ('a 60 degree left turn over 0.9 m', 'a straight walk of 0.8 m')
    >>> move_words(0.0, np.radians(-90))
    'a 90 degree right turn on the spot'
    """
    degrees = round(abs(np.degrees(turn)))
    if degrees == 0:
        return f"a straight walk of {wording.rough(length)} m"
    article = "an" if str(degrees).startswith("8") or degrees in (11, 18) else "a"
    way = f"over {wording.rough(length)} m" if length else "on the spot"
    return f"{article} {degrees} degree {'left' if turn > 0 else 'right'} turn {way}"


def mean_speeds(segments: Sequence[MotionSegment]) -> tuple[float, float]:
    """Mean speed (m/s) of the segments that travel, and mean turn rate (rad/s) of those that turn."""
    lengths = np.array([path_length(segment) for segment in segments])
    turns = np.array([abs(float(segment.path[-1, 2])) for segment in segments])
    durations = np.array([segment.duration for segment in segments])
    travels, turning = lengths >= TRAVEL, turns >= TURN
    speed = lengths[travels].sum() / durations[travels].sum() if travels.any() else USUAL_SPEED
    turn_rate = turns[turning].sum() / durations[turning].sum() if turning.any() else USUAL_TURN_RATE
    return float(speed), float(turn_rate)


def _n_frames(duration: float, frame_rate: float) -> int:
    return max(round(max(duration, SHORTEST) * frame_rate), 1) + 1


def _arc(length: float, turn: float, direction: float, n_frames: int) -> np.ndarray:
    """(F, 3) path of ``length`` metres with evenly changing heading, going towards ``direction`` from the heading."""
    along = np.linspace(0.0, 1.0, n_frames)
    heading = turn * along
    if abs(turn) < 1e-9:
        x, y = length * along, np.zeros(n_frames)
    else:
        x, y = length / turn * np.sin(heading), length / turn * (1 - np.cos(heading))
    cosine, sine = np.cos(direction), np.sin(direction)
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, heading])


def _like(graph: MotionGraph, template: int, words: str, path: np.ndarray, tags: dict[str, np.ndarray]) -> Candidate:
    """A candidate with the neighbours of the template; it may follow itself if the template may."""
    clip, last = graph.segments[template].clip, len(path) - 1
    segment = MotionSegment(words, clip, 0, last, path, last / graph.frame_rate, tags)
    return _placed(graph, template, words, segment)


def _placed(graph: MotionGraph, template: int, words: str, segment: MotionSegment) -> Candidate:
    parents = graph.links[graph.links[:, 1] == template, 0].tolist()
    children = graph.links[graph.links[:, 0] == template, 1].tolist()
    return Candidate(words, segment, tuple(parents), tuple(children), template in children)


def _mirror_images(graph: MotionGraph, template: int) -> list[Candidate]:
    """Mirror images of segments that turn or step aside and lead where no segment leads."""
    ends = [segment.path[-1] for segment in graph.segments]
    found = []
    for segment in graph.segments:
        if abs(segment.path[-1, 2]) < TURN and abs(segment.path[-1, 1]) < SAME_PLACE:
            continue
        path = segment.path * [1.0, -1.0, -1.0]
        apart = np.array(ends) - path[-1]
        turned = np.abs((apart[:, 2] + np.pi) % (2 * np.pi) - np.pi)
        if np.any((np.hypot(apart[:, 0], apart[:, 1]) < SAME_PLACE) & (turned < SAME_HEADING)):
            continue
        ends.append(path[-1])
        tags = {tag: mask.copy() for tag, mask in segment.tags.items()}
        length, turn = path_length(segment), float(path[-1, 2])
        move = move_words(length, turn) if abs(turn) >= TURN else f"a diagonal walk of {wording.rough(length)} m"
        found.append(_like(graph, template, f"the mirror image of '{segment.name}' ({move})", path, tags))
    return found


def _retimed(embedding: Embedding, family: CandidateFamily) -> list[Candidate]:
    """Segments played faster and slower, between their own neighbours."""
    graph, nodes = embedding.graph, nodes_of_segments(embedding)
    most = sorted(range(len(nodes)), key=lambda i: (-nodes[i], i))[: family.n_retimed]
    found = []
    for factor in family.retimings:
        for i in most:
            segment = graph.segments[i]
            n_frames = max(round((segment.n_frames - 1) * factor), 1) + 1
            at = np.linspace(0, segment.n_frames - 1, n_frames)
            frames = np.arange(segment.n_frames)
            path = np.column_stack([np.interp(at, frames, segment.path[:, axis]) for axis in range(3)])
            tags = {tag: mask[np.rint(at).astype(int)] for tag, mask in segment.tags.items()}
            words = f"'{segment.name}' at {wording.short(1 / factor)} times its speed"
            duration = (n_frames - 1) / graph.frame_rate
            again = replace(segment, name=words, first=0, last=n_frames - 1, path=path, duration=duration, tags=tags)
            found.append(_placed(graph, i, words, again))
    return found
