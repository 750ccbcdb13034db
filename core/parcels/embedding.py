"""Embedding a large ground: parcels, their cores, and what the cores reach and are reached from.

The search is that of :mod:`core.embedding.component`, forward-backward, but it does not start from a single pivot: from
one, a closure would cross the ground parcel by parcel while all workers but one wait. Every parcel finds the largest
strongly connected component within itself, its *core*, and which cores of its neighbours that leads to. Cores that lead
to each other belong to one component of the whole; from all of them together, forwards and backwards, every parcel is
visited a few times, wherever it lies.
"""

from collections.abc import Generator
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import count as numbers
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..embedding.component import EXPLICIT_LINKS, WORTHWHILE_TRIM
from ..errors import EmbeddingError
from ..progress import Progress
from . import tasks
from .problem import open_problem
from .work import Phase, Serial, Work

#: The set that holds the nodes of the embedding when all is done.
NODES = "nodes"
#: The folder that holds the maps.
MAPS = "maps"


@dataclass(frozen=True)
class ParcelSummary:
    """The figures of an embedded large ground.

    Attributes
    ----------
    n_nodes, n_links : int
    free_cells, covered_cells : int
        Cells of the free floor (:func:`..evaluation.floor.floor_cells`), and those of them that it can pass through.
    n_parcels : int
    """

    n_nodes: int
    n_links: int
    free_cells: int
    covered_cells: int
    n_parcels: int

    @property
    def coverage(self) -> float:
        """Share of the free floor that can be passed through."""
        return self.covered_cells / max(self.free_cells, 1)


def embed_parcels_steps(
    folder: Path, executor: Executor | None = None, explicit_links: int = EXPLICIT_LINKS
) -> Generator[Progress, None, ParcelSummary]:
    """Embed the problem in a folder (see :func:`.problem.create_problem`); go on where it was left. Yields progress.

    The nodes are the set ``nodes``, the maps lie in ``maps``. Raises EmbeddingError if files cannot be read or written:
    when that is repaired, the same call goes on.
    """
    problem = open_problem(str(folder))
    work = Work(problem, executor or Serial())
    if work.known("done") is None:
        found = yield from _largest_component(work, explicit_links)
        if found is None:
            yield from work.all_steps(NODES, tasks.clear, NODES)
        else:
            yield from work.all_steps(NODES, tasks.keep, found, NODES)
        work.record("done", True)
    halo = yield from work.all_steps("halo of nodes", tasks.send_nodes, NODES)
    links = yield from work.numbers_steps("links", tasks.count_links, NODES, halo.inboxes())
    cells = yield from work.numbers_steps("maps", tasks.write_maps, NODES, halo.inboxes(), MAPS)
    work.forget(NODES)
    return ParcelSummary(
        n_nodes=halo.total,
        n_links=sum(links),
        free_cells=sum(free for free, _ in cells),
        covered_cells=sum(covered for _, covered in cells),
        n_parcels=work.n_parcels,
    )


def _largest_component(work: Work, explicit_links: int) -> Generator[Progress, None, str | None]:
    """Return the name of the set with the largest strongly connected component; None if no node lies on a cycle."""
    number = numbers()
    # Turn 0 searches everything, and need not know what that is: only how much of it is left over.
    image = yield from work.all_steps("image", tasks.send_image, None, "image")
    everything = yield from work.all_steps("everything", tasks.join_messages, "image", image.inboxes(), None, None)
    best, best_size = None, 0
    rests: list[tuple[int, str | None, str | None]] = [(everything.total, None, None)]
    while rests:
        rests.sort(key=lambda rest: rest[0])
        left, whole, part = rests.pop()
        if left < max(best_size, 1):
            break
        turn, nodes = next(number), whole
        if turn > 0:
            nodes = yield from _rest(work, f"rest {turn}", image, whole, part)
            left, nodes = yield from _trimmed(work, f"rest {turn}", nodes, left, max(best_size, 1))
            if left < max(best_size, 1):
                continue
        if nodes is None or not (yield from _is_small(work, nodes, f"rest {turn}", explicit_links)):
            seed = yield from _seed(work, image, nodes, f"seed {turn}")
            reached = yield from work.closure_steps(tasks.go_on, seed, nodes, f"reached {turn}")
            found = yield from work.closure_steps(tasks.go_back, seed, f"reached {turn}", f"component {turn}")
            rests.append((reached.total - found.total, f"reached {turn}", f"component {turn}"))
            rests.append((left - reached.total, nodes, f"reached {turn}"))
        else:
            found = yield from _largest_written_out(work, nodes, f"component {turn}")
        size = found.total
        if size > 0 and (yield from _has_cycle(work, f"component {turn}", size)):
            better = size > best_size
            if size == best_size and best is not None:
                first = yield from _first_node(work, f"component {turn}")
                better = first < (yield from _first_node(work, best))
            if better:
                best, best_size = f"component {turn}", size
    return best


def _rest(work: Work, name: str, image: Phase, whole: str | None, part: str | None) -> Generator[Progress, None, str]:
    """Subtract a part from a set; None stands for everything that any link leads to. Returns the name of the rest."""
    if whole is None:
        whole = "everything"
        yield from work.all_steps("everything written", tasks.join_messages, "image", image.inboxes(), None, whole)
    if part is None:
        return whole
    yield from work.all_steps(name, tasks.subtract, whole, part, name)
    return name


def _trimmed(work: Work, name: str, nodes: str, left: int, enough: int) -> Generator[Progress, None, tuple[int, str]]:
    """Trim most loose ends of a set, see :func:`core.embedding.component.largest_component_steps`."""
    for turn in numbers():
        entered, kept = f"{name} entered {turn}", f"{name} kept {turn}"
        image = yield from work.all_steps(f"{name} image {turn}", tasks.send_image, nodes, f"{name} image {turn}")
        yield from work.all_steps(entered, tasks.join_messages, f"{name} image {turn}", image.inboxes(), nodes, entered)
        halo = yield from work.all_steps(f"halo of {entered}", tasks.send_nodes, entered)
        phase = yield from work.all_steps(kept, tasks.keep_able, entered, halo.inboxes(), kept)
        before, left, nodes = left, phase.total, kept
        if left < enough or left > before * (1 - WORTHWHILE_TRIM):
            break
    return left, nodes


def _is_small(work: Work, nodes: str, name: str, explicit_links: int) -> Generator[Progress, None, bool]:
    halo = yield from work.all_steps(f"halo of {nodes}", tasks.send_nodes, nodes)
    counts = yield from work.numbers_steps(f"links of {name}", tasks.count_links, nodes, halo.inboxes(), explicit_links)
    return sum(counts) <= explicit_links


def _seed(work: Work, image: Phase, nodes: str | None, name: str) -> Generator[Progress, None, dict[int, str]]:
    """Choose nodes that all lie in one component of ``nodes``: the cores that lead to each other, or one node.

    Returns the parcels that have any, each with the name of the set.
    """
    cores = yield from work.all_steps(f"{name} cores", tasks.find_core, nodes, f"{name} cores")
    size, messages = np.array(cores.n_nodes), cores.inboxes()
    if not size.any():
        # No parcel has a cycle within itself: whatever there is runs through several.
        if nodes is None:
            nodes = yield from _rest(work, name, image, None, None)
        where = yield from work.numbers_steps(f"{name} first", tasks.first_node, nodes)
        parcel = min((n, parcel) for parcel, n in enumerate(where) if n is not None)[1]
        tasks.place_node(str(work.problem.folder), parcel, nodes, name)
        return {parcel: name}
    touched = yield from work.numbers_steps(f"{name} touched", tasks.touched, f"{name} cores", nodes, messages)
    # The sender is in the name of the file.
    pairs = [
        (int(Path(path).name.split("-")[0]), parcel)
        for parcel, hits in enumerate(touched)
        for path, hit in zip(messages.get(parcel, []), hits, strict=True)
        if hit
    ]
    starts, ends = np.array(pairs, dtype=int).reshape(-1, 2).T
    graph = sparse.csr_array((np.ones(len(starts), dtype=bool), (starts, ends)), shape=(len(size),) * 2)
    _, group = connected_components(graph, directed=True, connection="strong")
    chosen = np.flatnonzero((group == np.argmax(np.bincount(group, weights=size))) & (size > 0))
    return dict.fromkeys(chosen.tolist(), f"{name} cores")


def _largest_written_out(work: Work, nodes: str, out: str):
    """Return the largest component inside a set of few links, by SciPy."""
    halo = yield from work.all_steps(f"halo of {nodes}", tasks.send_nodes, nodes)
    if work.known(out) is None:
        parts = yield from work.results_steps(f"{nodes} written out", tasks.written_out, nodes, halo.inboxes())
        numbers_of_largest = _largest(*(np.concatenate([part[i] for part in parts]) for i in range(3)))
    else:
        numbers_of_largest = np.empty(0, dtype=int)
    return (yield from work.all_steps(out, tasks.keep_numbers, numbers_of_largest, out))


def _largest(nodes: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the nodes of the largest component that has a cycle; of equal ones, that of the lowest number."""
    nodes = np.sort(nodes)
    start, end = np.searchsorted(nodes, starts), np.searchsorted(nodes, ends)
    matrix = sparse.csr_array((np.ones(len(start), dtype=bool), (start, end)), shape=(len(nodes),) * 2)
    _, label = connected_components(matrix, directed=True, connection="strong")
    size = np.bincount(label)
    looped = np.zeros(len(size), dtype=bool)
    looped[label[start[start == end]]] = True
    size[(size == 1) & ~looped] = 0
    if size.max(initial=0) == 0:
        return np.empty(0, dtype=int)
    first = np.flatnonzero(size[label] == size.max())[0]
    return nodes[label == label[first]]


def _has_cycle(work: Work, name: str, size: int) -> Generator[Progress, None, bool]:
    """Test whether a strongly connected set is more than one node that no link joins to itself."""
    if size > 1:
        return True
    halo = yield from work.all_steps(f"halo of {name}", tasks.send_nodes, name)
    links = yield from work.numbers_steps(f"links of {name}", tasks.count_links, name, halo.inboxes())
    return sum(links) > 0


def _first_node(work: Work, name: str) -> Generator[Progress, None, int]:
    found = yield from work.numbers_steps(f"first of {name}", tasks.first_node, name)
    lowest = min((n for n in found if n is not None), default=None)
    if lowest is None:
        raise EmbeddingError(f"The set '{name}' is empty.")
    return lowest
