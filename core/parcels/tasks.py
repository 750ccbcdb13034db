"""Tasks of a worker on one parcel. Every one reads files, writes new ones and returns a few numbers.

The first arguments of all of them are the problem's folder and the parcel's index.
"""

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..embedding.closure import reached_from_steps, reaching_steps
from ..embedding.component import largest_component_steps
from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..embedding.unroll import unroll_steps
from ..evaluation.floor import floor_cells
from ..evaluation.variability import floor_variability
from ..files import write_whole
from ..progress import finish
from .problem import open_network, open_problem

#: Files of messages by the parcels that they are for.
Messages = dict[int, list[str]]


@dataclass(frozen=True)
class TaskResult:
    """The number of nodes that a task wrote, and the messages for the neighbours.

    Attributes
    ----------
    n_nodes : int
    messages : tuple of (parcel, path)
    """

    n_nodes: int
    messages: tuple[tuple[int, str], ...] = ()


def _beyond(folder: str, index: int) -> NodeSet:
    """Return all nodes in a parcel's halo."""
    problem = open_problem(folder)
    return problem.everywhere(problem.sweep.layout.ground ^ problem.own(index))


def _read(folder: str, index: int, name: str | None) -> NodeSet:
    """Read a set on a parcel's own cells: None for all nodes there."""
    problem = open_problem(folder)
    return problem.everywhere(problem.own(index)) if name is None else problem.read(name, index)


# --------------------------------------------------------------------------------------- one step forwards and back


def send_image(folder: str, index: int, name: str | None, out: str) -> TaskResult:
    """Write the image of a set (None for all nodes) as ``out`` on the own cells, and send the rest of it."""
    problem, network = open_problem(folder), open_network(folder, index)
    image = network.image(_read(folder, index, name))
    sent = problem.send(out, index, image, to_own=True)
    kept = image.on(problem.own(index))
    problem.write(out, index, kept)
    return TaskResult(len(kept), tuple(sent.values()))


def send_nodes(folder: str, index: int, name: str) -> TaskResult:
    """Send the neighbours the nodes of a set that lie in their frames."""
    problem = open_problem(folder)
    planes = problem.read(name, index)
    return TaskResult(len(planes), tuple(problem.send(f"halo of {name}", index, planes, to_own=False).values()))


def join_messages(
    folder: str, index: int, name: str, messages: Sequence[str], within: str | None, out: str | None
) -> TaskResult:
    """Join a set with what the neighbours sent of it, inside another; only count it if ``out`` is None."""
    problem = open_problem(folder)
    planes = problem.union_of_files(messages, problem.read(name, index))
    if within is not None:
        planes = planes & problem.read(within, index)
    if out is not None:
        problem.write(out, index, planes)
    return TaskResult(len(planes))


def keep(folder: str, index: int, name: str, out: str) -> TaskResult:
    """Write a copy of a set that takes little room."""
    problem = open_problem(folder)
    planes = problem.read(name, index)
    problem.write(out, index, planes, lasting=True)
    return TaskResult(len(planes))


def keep_able(folder: str, index: int, name: str, messages: Sequence[str], out: str) -> TaskResult:
    """Keep the nodes of a set with a link to one of the set, here or in what the neighbours sent of it."""
    problem, network = open_problem(folder), open_network(folder, index)
    planes = problem.read(name, index)
    kept = planes & network.preimage(problem.union_of_files(messages, planes))
    problem.write(out, index, kept)
    return TaskResult(len(kept))


def subtract(folder: str, index: int, name: str, other: str, out: str) -> TaskResult:
    """Write the nodes of a set that are not in ``other``."""
    problem = open_problem(folder)
    planes = problem.read(name, index) - problem.read(other, index)
    problem.write(out, index, planes)
    return TaskResult(len(planes))


# ------------------------------------------------------------------------------------------------------------ seeds


def find_core(folder: str, index: int, within: str | None, out: str) -> TaskResult:
    """Find the largest strongly connected component of a parcel for itself; send the neighbours where it leads."""
    problem, network = open_problem(folder), open_network(folder, index)
    nodes = _read(folder, index, within)
    core = finish(largest_component_steps(network, within=nodes)).nodes
    problem.write(out, index, core)
    if not core:
        return TaskResult(0)
    reached = finish(reached_from_steps(network, core, nodes | _beyond(folder, index)))
    sent = problem.send(out, index, reached, to_own=True)
    return TaskResult(len(core), tuple(sent.values()))


def touched(folder: str, index: int, core: str, within: str | None, messages: Sequence[str]) -> list[bool]:
    """Test, for each neighbour that sent where its core leads, whether that leads into a parcel's own core."""
    problem = open_problem(folder)
    seed, limits = problem.read(core, index), _read(folder, index, within)
    if not messages or not seed:
        return [False] * len(messages)
    hits = []
    for path in messages:
        arrived = problem.read_file(Path(path)) & limits
        hit = bool(arrived & seed)
        if not hit and arrived:
            around = limits | _beyond(folder, index)
            hit = bool(finish(reached_from_steps(open_network(folder, index), arrived, around)) & seed)
        hits.append(hit)
    return hits


def clear(folder: str, index: int, out: str) -> TaskResult:
    """Write an empty set."""
    problem = open_problem(folder)
    problem.write(out, index, problem.everywhere(0))
    return TaskResult(0)


def place_node(folder: str, index: int, within: str, out: str) -> TaskResult:
    """Write the set of one node of a parcel's nodes."""
    problem = open_problem(folder)
    nodes = problem.read(within, index)
    first = next((i for i, plane in enumerate(nodes.planes) if plane), None)
    chosen = nodes.where(lambda i: i == first)
    chosen = chosen.on(max(chosen.planes) & -max(chosen.planes))
    problem.write(out, index, chosen)
    return TaskResult(len(chosen))


# --------------------------------------------------------------------------------------------------------- closures


def go_on(
    folder: str, index: int, known: str | None, messages: Sequence[str], within: str | None, out: str
) -> TaskResult:
    """Follow all links from what is new, inside a parcel, and send the neighbours where it goes on.

    ``known`` is what the parcel had reached before (None: nothing); ``messages`` what may be new. The first call of a
    closure has no messages: there all of ``known`` is new.
    """
    problem, network = open_problem(folder), open_network(folder, index)
    before, limits = _known(folder, index, known), _read(folder, index, within)
    arrived = (problem.union_of_files(messages, problem.everywhere(0)) & limits) if messages else before
    new = (arrived - before) if messages else before
    if not new:
        problem.write(out, index, before)
        return TaskResult(len(before))
    left = (limits - before) if messages else limits
    reached = finish(reached_from_steps(network, new, left | _beyond(folder, index)))
    sent = problem.send(out, index, reached, to_own=True)
    planes = before | reached.on(problem.own(index))
    problem.write(out, index, planes)
    return TaskResult(len(planes), tuple(sent.values()))


def go_back(
    folder: str, index: int, known: str | None, messages: Sequence[str], within: str | None, out: str
) -> TaskResult:
    """Follow links as :func:`go_on` does, but backwards."""
    problem, network = open_problem(folder), open_network(folder, index)
    before, limits = _known(folder, index, known), _read(folder, index, within)
    # What the neighbours send lies in the halo and is new to this parcel, whatever it knows of its own cells.
    new = problem.union_of_files(messages, problem.everywhere(0)) if messages else before
    if not new:
        problem.write(out, index, before)
        return TaskResult(len(before))
    left = (limits - before) if messages else limits
    fresh = finish(reaching_steps(network, new, left | new)).on(problem.own(index))
    sent = problem.send(out, index, fresh, to_own=False)
    planes = before | fresh
    problem.write(out, index, planes)
    return TaskResult(len(planes), tuple(sent.values()))


def _known(folder: str, index: int, known: str | None) -> NodeSet:
    problem = open_problem(folder)
    return problem.everywhere(0) if known is None else problem.read(known, index)


# ---------------------------------------------------------------------------------------------------------- results


def count_links(folder: str, index: int, name: str, messages: Sequence[str], enough: float = np.inf) -> int:
    """Count the links between nodes of a set that start in a parcel."""
    problem, network = open_problem(folder), open_network(folder, index)
    around = problem.union_of_files(messages, problem.read(name, index))
    return network.count_links(around, enough)


def written_out(
    folder: str, index: int, name: str, messages: Sequence[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """List a set's nodes on a parcel's own cells, and the links that start there, by numbers on the whole ground.

    Returns (n,) nodes, (L,) starts and (L,) ends; the number of a node is (cell * n_headings + heading) * n_segments +
    segment, its cell x * ny + y, so that numbers are in the order of x, y, heading, segment.
    """
    problem, network = open_problem(folder), open_network(folder, index)
    plan, layout = problem.plan, problem.sweep.layout
    parcel, (nx, ny, n_headings) = plan.parcels[index], plan.grid.shape
    around = problem.union_of_files(messages, problem.read(name, index))
    indices, starts, ends = network.links_within(around)
    x, y = np.divmod(indices[:, 1], layout.ny)
    own = plan.own_cells(index)[x, y]
    x, y = (x - plan.halo_x + parcel.x0) % nx, (y - plan.halo_y + parcel.y0) % ny
    segment, heading = np.divmod(indices[:, 0], n_headings)
    number = ((x * ny + y) * n_headings + heading) * len(problem.graph.segments) + segment
    return number[own], number[starts], number[ends]


def keep_numbers(folder: str, index: int, numbers: np.ndarray, out: str) -> TaskResult:
    """Write the set of the nodes with these numbers (see :func:`written_out`) that lie on a parcel's own cells."""
    problem, network = open_problem(folder), open_network(folder, index)
    plan, n_segments = problem.plan, len(problem.graph.segments)
    parcel, (_, ny, n_headings) = plan.parcels[index], plan.grid.shape
    place, segment = np.divmod(numbers, n_segments)
    cell, heading = np.divmod(place, n_headings)
    x, y = cell // ny - parcel.x0, cell % ny - parcel.y0
    mine = (x >= 0) & (x < parcel.nx) & (y >= 0) & (y < parcel.ny)
    local = (x + plan.halo_x) * problem.sweep.layout.ny + y + plan.halo_y
    nodes = network.nodes(np.column_stack([segment * n_headings + heading, local])[mine])
    problem.write(out, index, nodes)
    return TaskResult(len(nodes))


def first_node(folder: str, index: int, name: str) -> int | None:
    """Return the lowest number (see :func:`written_out`) of a node of a set in a parcel; None if it has none."""
    problem = open_problem(folder)
    plan, layout, n_segments = problem.plan, problem.sweep.layout, len(problem.graph.segments)
    parcel, (_, ny, n_headings) = plan.parcels[index], plan.grid.shape
    lowest = None
    for i, plane in enumerate(problem.read(name, index).planes):
        if plane:
            x, y = divmod((plane & -plane).bit_length() - 1, layout.stride)
            cell = (x - plan.halo_x + parcel.x0) * ny + y - plan.halo_y + parcel.y0
            segment, heading = divmod(i, n_headings)
            number = (cell * n_headings + heading) * n_segments + segment
            lowest = number if lowest is None else min(lowest, number)
    return lowest


def write_maps(folder: str, index: int, name: str, messages: Sequence[str], out: str) -> tuple[int, int]:
    """The floor maps of a parcel's own cells as ``out/<index>.npz``: ``coverage``, headings in which a cell can be
    passed, and ``variability`` (paper, eq. 2, summed over headings). Returns how many cells are free, and covered.
    """
    problem = open_problem(folder)
    plan, layout = problem.plan, problem.sweep.layout
    planes = problem.union_of_files(messages, problem.read(name, index))
    # Nodes in the halo have links too; what these pass lies within twice the halo.
    wide = plan.crop(problem.environment, index, margin=2)
    sweep = _wide_sweep(folder, wide.grid.shape[:2])
    unrolling = finish(unroll_steps(sweep, wide))
    pad = ((plan.halo_x,) * 2, (plan.halo_y,) * 2)
    widened = tuple(sweep.layout.pack(np.pad(layout.unpack(plane), pad)) if plane else 0 for plane in planes.planes)
    embedding = Embedding(problem.graph, wide, problem.settings, unrolling, widened)
    parcel = plan.parcels[index]
    own = (
        slice(2 * plan.halo_x, 2 * plan.halo_x + parcel.nx),
        slice(2 * plan.halo_y, 2 * plan.halo_y + parcel.ny),
    )
    covered, free = embedding.covered()[own].sum(axis=2).astype(np.uint16), floor_cells(embedding)[own]
    variability = floor_variability(embedding)[own]
    path = problem.folder / out / f"{index}.npz"
    write_arrays(path, coverage=covered, variability=variability, free=free, corner=np.array([parcel.x0, parcel.y0]))
    return int(free.sum()), int(np.count_nonzero((covered > 0) & free))


def _wide_sweep(folder: str, cells: tuple[int, int]):
    sweep = open_problem(folder).sweep
    return replace(sweep, **_moved_shifts(sweep, cells))


def _moved_shifts(sweep, cells: tuple[int, int]) -> dict:
    """Return the same paths on a larger ground: shifts depend on how long its rows are."""
    old, layout = sweep.layout, replace(sweep.layout, nx=cells[0], ny=cells[1])
    shift = np.array(sweep.shift, dtype=int)
    dx = np.floor_divide(shift + old.reach_y, old.stride)
    return {"layout": layout, "shift": layout.shift(dx, shift - dx * old.stride).tolist()}


def write_arrays(path: Path, **arrays: np.ndarray) -> None:
    """Write an .npz, whole or not at all."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_whole(path, buffer.getvalue())
