"""Goals: sets of nodes that stand for "at this place", "in this region", "facing that way", "able to begin that".

Every function returns only nodes of the embedding, and at least one; narrow a goal further with
``&``.
"""

from collections.abc import Iterable

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..environment.grid import SUBDIVISION
from ..errors import NOTHING_FITS, EvaluationError
from .segment_groups import segments_with_tag


def goal_at(embedding: Embedding, position: tuple[float, float] | np.ndarray, radius: float = 0.0) -> NodeSet:
    """The nodes of any heading in the cell at a world position (m), and in all cells whose centre is within ``radius``.

    On a tiled ground positions repeat.

    Raises
    ------
    EvaluationError
        The position is off the ground, in an obstacle, or at a place where no walk passes; the message names the
        nearest place that one does pass.
    """
    grid = embedding.environment.grid
    place = np.asarray(position, dtype=float)
    if place.shape != (2,) or not np.isfinite(place).all() or not radius >= 0:
        raise EvaluationError(
            f"The goal at {place.tolist()} with radius {radius} is no place; give x, y and a radius in metres."
        )
    size = np.array(grid.shape[:2])
    cell = grid.cells(place)
    if not grid.tiled and not np.all((cell >= 0) & (cell < size)):
        raise EvaluationError(
            f"The goal at {wording.place(place[0], place[1])} lies off the ground; move it onto the ground, or make "
            "the ground larger."
        )
    distance = np.linalg.norm(_offsets(embedding, place), axis=2)
    mask = distance <= radius
    mask[tuple(cell % size)] = True
    goal = _nodes_in(embedding, mask)
    if not goal:
        covered = embedding.covered().any(axis=2)
        if not covered.any():
            raise _nothing_covered()
        nearest = np.unravel_index(np.argmin(np.where(covered, distance, np.inf)), covered.shape)
        free = embedding.environment.free_cells()[tuple(cell % size)]
        reason = "no endless walk passes there" if free else "something stands there"
        raise EvaluationError(
            f"The goal at {wording.place(place[0], place[1])} cannot be reached: {reason}. The nearest place that can "
            f"be is {wording.length(distance[nearest])} away, at "
            f"{wording.place(*grid.positions(np.array(nearest)).tolist())}."
        )
    return goal


def goal_in_cells(embedding: Embedding, cells: np.ndarray, name: str = "The goal") -> NodeSet:
    """The nodes of any heading in the cells of an (nx, ny) bool mask; ``name`` begins the message if there are none."""
    expected = embedding.shape[:2]
    cells = np.asarray(cells)
    if cells.shape != expected or cells.dtype != bool:
        raise EvaluationError(f"{name} is a mask of {cells.shape} {cells.dtype}; the grid needs {expected} bool.")
    goal = _nodes_in(embedding, cells)
    if not goal:
        if not cells.any():
            reason = "it holds no cell of the ground; move it onto the ground, or make it larger than a cell"
        elif not (embedding.environment.free_cells() & cells).any():
            reason = "obstacles fill it; move it, or make the character's radius smaller"
        else:
            reason = "no endless walk passes there; move it, or add clips that fit in"
        raise EvaluationError(f"{name} cannot be reached: {reason}.")
    return goal


def goal_in_region(embedding: Embedding, region: str) -> NodeSet:
    """The nodes of any heading in the cells whose centre lies in a region of the environment, by its name."""
    regions = {mask.name: mask for mask in embedding.environment.regions}
    if region not in regions:
        known = ", ".join(f"'{name}'" for name in regions) or "none"
        raise EvaluationError(f"The scene has no region '{region}' (regions: {known}); mark one, or choose another.")
    middle = slice(SUBDIVISION // 2, None, SUBDIVISION)
    return goal_in_cells(embedding, regions[region].mask[middle, middle], f"The region '{region}'")


def facing(embedding: Embedding, goal: NodeSet, heading: float, tolerance: float = 0.0) -> NodeSet:
    """The nodes of a goal whose heading (rad) is the grid's nearest to ``heading``, or within ``tolerance`` (rad)."""
    grid = embedding.environment.grid
    if not (np.isfinite(heading) and tolerance >= 0):
        raise EvaluationError(
            f"A heading of {heading} with a tolerance of {tolerance} is no direction; give two angles in radians."
        )
    off = np.arange(grid.n_headings) * grid.heading_step - heading
    off = np.abs((off + np.pi) % (2 * np.pi) - np.pi)
    wanted = (off <= tolerance + 1e-9) | (off == off.min())
    chosen = wanted.tolist()
    narrowed = (goal & embedding.nodes).where(lambda index: chosen[index % len(chosen)])
    if not narrowed:
        raise EvaluationError(
            f"No walk stands at the goal facing {wording.angle(heading)} within {wording.angle(tolerance)}; "
            "allow more Give or Take."
        )
    return narrowed


def goal_with_tag(embedding: Embedding, tag: str) -> NodeSet:
    """The nodes that were arrived at by a segment with a tag on any of its frames: right after doing it."""
    return goal_after(embedding, segments_with_tag(embedding.graph, tag), f"a segment with the tag '{tag}'")


def goal_after(embedding: Embedding, segments: Iterable[int], name: str = "the action") -> NodeSet:
    """The nodes that were arrived at by any of the segments (indices)."""
    goal = _of_segments(embedding, segments)
    if not goal:
        raise _cannot_play(embedding, name)
    return goal


def goal_to_begin(embedding: Embedding, segments: Iterable[int], name: str = "the action") -> NodeSet:
    """The nodes from which any of the segments (indices) can be played and leads to a node of the embedding.

    The time to reach it is how soon an action can begin: the local maneuverability of Reitsma & Pollard 2007.
    """
    goal = embedding.network.preimage(_of_segments(embedding, segments)) & embedding.nodes
    if not goal:
        raise _cannot_play(embedding, name)
    return goal


def _of_segments(embedding: Embedding, segments: Iterable[int]) -> NodeSet:
    wanted, n_headings = set(segments), embedding.shape[2]
    return embedding.nodes.where(lambda index: index // n_headings in wanted)


def _nodes_in(embedding: Embedding, cells: np.ndarray) -> NodeSet:
    return embedding.nodes.on(embedding.network.layout.pack(cells))


def _offsets(embedding: Embedding, position: np.ndarray) -> np.ndarray:
    """(nx, ny, 2) metres from the position to each cell's centre, the short way around a tiled ground."""
    grid = embedding.environment.grid
    offset = grid.positions(np.moveaxis(np.indices(grid.shape[:2]), 0, -1)) - position
    if grid.tiled:
        size = np.array(grid.size)
        offset -= np.round(offset / size) * size
    return offset


def _nothing_covered() -> EvaluationError:
    return EvaluationError(f"The embedding is empty: {NOTHING_FITS}")


def _cannot_play(embedding: Embedding, name: str) -> EvaluationError:
    if not embedding.n_nodes:
        return _nothing_covered()
    return EvaluationError(
        f"No walk of the embedding plays {name}: it fits nowhere in this scene, or does not lead back. Make room for "
        "it, or add clips that lead to it and away from it."
    )
