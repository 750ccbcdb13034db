"""Reasons why a grid element is not in the embedding, and the links that the scene cost."""

from collections.abc import Generator
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from ..embedding.closure import reached_from_steps, reaching_steps
from ..embedding.embedding import Embedding
from ..embedding.network import StepNetwork
from ..embedding.node_set import NodeSet, union_of
from ..embedding.unroll import REPORTED_PATHS, unroll_steps
from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION
from ..environment.regions import RegionRule
from ..progress import Progress, portion
from .floor import allowed_cells, ruled_cells

_COUNTING = "Counting links"


class Reason(IntEnum):
    """Why no segment of the embedding ends at a grid element; the first that applies."""

    EMBEDDED = 0
    """It is in the embedding."""
    BLOCKED = 1
    """An obstacle is closer than the character's radius."""
    RULE = 2
    """A region requires a tag, and no walk stands in this cell: it can only be crossed, if at all."""
    FORBIDDEN = 3
    """The regions allow no frame there, whatever its tags."""
    NO_WAY_OUT = 4
    """The embedding leads there, but nothing that arrives there leads back."""
    NO_WAY_IN = 5
    """From there a way leads into the embedding, but the embedding does not lead there."""
    NO_MATCH = 6
    """It can be entered from the embedding, and left towards it, but not by segments that may follow one another."""
    OTHER_COMPONENT = 7
    """Endless walks pass there, but the embedding neither leads to them nor can be reached from them."""
    UNREACHABLE = 8
    """No segment fits there, or only walks that begin and end nowhere."""
    NO_GROUND = 9
    """The ground does not reach there; goes before BLOCKED."""


#: How each reason is named on maps and in reports.
REASON_LABELS = {
    Reason.EMBEDDED: "Can Go Here",
    Reason.BLOCKED: "Too Near an Obstacle",
    Reason.RULE: "Crossed by a Region's Rule",
    Reason.FORBIDDEN: "Forbidden by Regions",
    Reason.NO_WAY_OUT: "No Way Out",
    Reason.NO_WAY_IN: "No Way In",
    Reason.NO_MATCH: "Ways In and Out Do Not Match",
    Reason.OTHER_COMPONENT: "Only in Another Component",
    Reason.UNREACHABLE: "No Segment Fits",
    Reason.NO_GROUND: "No Ground Here",
}


def why_not_steps(embedding: Embedding) -> Generator[Progress, None, np.ndarray]:
    """(nx, ny, n_headings) uint8 array of :class:`Reason` for every grid element."""
    network = embedding.network
    nodes = embedding.nodes
    everything = network.image(network.everything)
    reached = yield from portion(reached_from_steps(network, nodes, everything | nodes), 0.1, 0.3)
    # Where a character could start: it need not have arrived by any segment.
    leading = yield from portion(reaching_steps(network, nodes, network.everything), 0.3, 0.6)
    yield Progress(0.6, "Looking for other components")
    apart = everything - (reached | leading)
    elsewhere = _endless(network, apart)
    yield Progress(0.9, "Naming reasons")

    grid = embedding.environment.grid
    at = _places(network, nodes)
    entered, left, other = _places(network, reached), _places(network, leading), _places(network, elsewhere)
    environment, classes = embedding.environment, embedding.unrolling.sweep.classes
    allowed, free = allowed_cells(environment, classes), environment.free_cells()

    reason = np.full(grid.shape, Reason.UNREACHABLE, dtype=np.uint8)
    reason[other] = Reason.OTHER_COMPONENT
    reason[entered & left] = Reason.NO_MATCH
    reason[left & ~entered] = Reason.NO_WAY_IN
    reason[entered & ~left] = Reason.NO_WAY_OUT
    reason[~allowed] = Reason.FORBIDDEN
    reason[ruled_cells(environment) & ~at.any(axis=2)] = Reason.RULE
    reason[~free] = Reason.BLOCKED
    reason[environment.bare_cells()] = Reason.NO_GROUND
    reason[at] = Reason.EMBEDDED
    return reason


def _endless(network: StepNetwork, nodes: NodeSet) -> NodeSet:
    """The part of ``nodes`` on walks without beginning or end: on other components, or between two of them."""
    while True:
        trimmed = network.trim(nodes)
        if len(trimmed) == len(nodes):
            return trimmed
        nodes = trimmed


def _places(network: StepNetwork, nodes: NodeSet) -> np.ndarray:
    """(nx, ny, n_headings) bool: where a set has a node of any segment."""
    shared = [union_of(nodes.planes[heading :: network.n_headings]) for heading in range(network.n_headings)]
    return np.stack([network.layout.unpack(plane) for plane in shared], axis=2)


def floor_reasons(reasons: np.ndarray) -> np.ndarray:
    """(nx, ny) uint8 :class:`Reason` of each cell, from those of its headings (nx, ny, n_headings).

    EMBEDDED if any heading is; otherwise the most common one, and of equally common ones the first.
    """
    counts = np.stack([(reasons == reason).sum(axis=2) for reason in Reason], axis=2)
    most = counts.argmax(axis=2)
    embedded = counts[..., Reason.EMBEDDED] > 0
    return np.where(embedded, int(Reason.EMBEDDED), most).astype(np.uint8)


def rule_labels(environment: Environment) -> str:
    """Return the label of what the environment's regions require, if they all require the same."""
    tags = {region.tag for region in environment.regions if region.rule is RegionRule.REQUIRE}
    return f"Crossed by '{tags.pop()}' Only" if len(tags) == 1 else REASON_LABELS[Reason.RULE]


def place_reason(reason: Reason, environment: Environment, x: int, y: int) -> str:
    """The reason of a single cell in words, with the names of the regions whose rule must be kept there."""
    middle = SUBDIVISION // 2
    at = x * SUBDIVISION + middle, y * SUBDIVISION + middle
    rules = [r for r in environment.regions if r.rule is not RegionRule.CONFINE and r.mask[at]]
    if rules and reason in (Reason.RULE, Reason.FORBIDDEN):
        words = [f"'{r.tag}' {'only' if r.rule is RegionRule.REQUIRE else 'not'} ({r.name})" for r in rules]
        return f"Rule of the region: {', '.join(words)}"
    return REASON_LABELS[reason]


def reason_shares(floor: np.ndarray) -> dict[str, float]:
    """The share (0 to 1) of the floor that each reason has, by its name; those without any left out."""
    counts = np.bincount(floor.ravel(), minlength=len(Reason)).tolist()
    return {reason.name: float(counts[reason] / floor.size) for reason in Reason if counts[reason]}


@dataclass(frozen=True)
class LostLinks:
    """One-step links of an empty ground, by what became of them.

    Attributes
    ----------
    possible : int
        Links whose path stays on the ground, with nothing standing on it.
    obstacles : int
        Of these, links that an obstacle blocks.
    regions : int
        Of the rest, links that a region's rule forbids.
    free : int
        What is left; the embedding keeps those inside its component.
    embedded : int
        Links of the embedding.
    """

    possible: int
    obstacles: int
    regions: int
    free: int
    embedded: int


def lost_links_steps(embedding: Embedding) -> Generator[Progress, None, LostLinks]:
    """Count the one-step links that obstacles and regions cost."""
    environment, sweep = embedding.environment, embedding.unrolling.sweep
    nothing = np.zeros_like(environment.blocked) if environment.off_ground is None else environment.off_ground
    bare = replace(environment, blocked=nothing, regions=())
    unruled = replace(environment, regions=())
    on_bare_ground = yield from portion(unroll_steps(sweep, bare), 0.0, 0.3)
    possible = yield from portion(_count_steps(embedding, on_bare_ground.valid), 0.3, 0.4)
    past_obstacles = yield from portion(unroll_steps(sweep, unruled), 0.4, 0.7)
    unblocked = yield from portion(_count_steps(embedding, past_obstacles.valid), 0.7, 0.8)
    free = yield from portion(_count_steps(embedding, embedding.unrolling.valid), 0.8, 0.9)
    return LostLinks(possible, possible - unblocked, unblocked - free, free, embedding.n_links)


def _count_steps(embedding: Embedding, valid: tuple[int, ...]) -> Generator[Progress, None, int]:
    """Links of all one-step paths: each start cell counts once for every parent that may have led there."""
    n_parents = [len(parents) for parents in embedding.network.parents]
    segments = embedding.unrolling.stencils.segment.tolist()
    n_links = 0
    for done, (plane, segment) in enumerate(zip(valid, segments, strict=True)):
        if done % REPORTED_PATHS == 0:
            yield Progress(done / len(valid), _COUNTING)
        n_links += plane.bit_count() * n_parents[segment]
    return n_links
