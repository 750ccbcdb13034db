"""Exact shortest times over a whole embedding: Dial's buckets, over whole planes of times.

A bucket is a window of D frames, where D is the shortest segment's duration: every link takes at least as long, so that
whatever lies in the window [t, t + D) cannot be improved any more by anything in it (Denardo and Fox 1979), and is
passed on, once, by every stencil that moves it. Each stencil is then two array operations over all of its start cells,
whose views are laid out before the first wave; nothing is sorted, and no link is stored.

Times are kept in the narrowest type that holds a few windows and the longest segment (one byte, as a rule), counted
from a base that moves along with the waves: the work is bound by memory, and one byte instead of two halves it.
"""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.bitplane import PlaneLayout
from ..embedding.embedding import Embedding
from ..embedding.network import StepNetwork
from ..embedding.node_set import NodeSet
from ..errors import EmbeddingError
from ..progress import Progress

#: In uint16 frames: never.
NEVER = 65535

#: Bytes that the views of a stencil's times take (measured).
STENCIL_BYTES = 1000


@dataclass(frozen=True)
class Front:
    """Tables of times for every heading and cell, and the groups that gather and pass them on.

    Backwards, a table belongs to an entry group (the least time from its starts) and a group is an exit group (the
    least of its entry groups); forwards, a table belongs to a segment (when it arrives) and a group is an entry group
    (when it starts).

    Attributes
    ----------
    n_tables : int
    sources : for each group the tables whose least time it takes
    players : for each group the segments that pass its time on, later by their duration
    table_of : for each segment the table that it writes to
    forwards : bool
    """

    n_tables: int
    sources: Sequence[Sequence[int]]
    players: Sequence[Sequence[int]]
    table_of: Sequence[int]
    forwards: bool

    @classmethod
    def of(cls, network: StepNetwork, forwards: bool) -> "Front":
        if forwards:
            parents = [network.parents[members[0]] for members in network.entry_groups]
            return cls(network.n_segments, parents, network.entry_groups, range(network.n_segments), True)
        return cls(
            len(network.entry_groups), network.entry_groups_after, network.exit_groups, network.entry_group_of, False
        )


def wave_steps(
    embedding: Embedding,
    forwards: bool,
    seed: NodeSet,
    limit: int | None = None,
    delayed: tuple[np.ndarray, np.ndarray] | None = None,
) -> Generator[Progress, None, np.ndarray]:
    """Find the frames from the ``seed`` to each table's places, or back: (n_tables, n_headings, n_bits) uint16.

    NEVER where there is no way.

    Parameters
    ----------
    forwards : bool
        False: times to the seed, a table for each entry group. True: times from it, a table for each segment.
    seed : NodeSet
        Where each segment is passed on at time 0: backwards its ends in the goal, forwards its starts.
    limit : int, optional
        Frames after which to stop; later times are NEVER.
    delayed : (n, 4) int array of x, y, heading, segment and (n,) int array of frames, optional
        More seeds, each once, that are passed on from frames of their own.

    Raises
    ------
    EmbeddingError
        The times do not fit into the embedding's memory limit, or last longer than 65,534 frames.
    """
    waves = _Waves(embedding, Front.of(embedding.network, forwards))
    window, longest = waves.window, waves.longest
    # No time that is passed on from here is longer than 65,534 frames.
    horizon = NEVER - 1 - window - longest
    last = horizon if limit is None else min(limit, horizon)
    waves.begin(seed)
    nodes, frames = (np.empty((0, 4), dtype=int), np.empty(0, dtype=int)) if delayed is None else delayed
    now, quiet, latest = 0, 0, int(frames.max(initial=0))
    while (quiet < longest or now <= latest) and now <= last:
        yield _progress(now, limit, embedding)
        passed = now == 0 or waves.pass_on(now)
        starting = (now <= frames) & (frames < now + window)
        if starting.any():
            waves.begin_at(nodes[starting], frames[starting])
            passed = True
        quiet = 0 if passed else quiet + window
        now += window
    if now > horizon and (quiet < longest or now <= latest):
        raise EmbeddingError(
            f"Some ways last longer than {wording.time(horizon / embedding.graph.frame_rate)}; set a time limit."
        )
    settled = waves.settle()
    if limit is not None:
        settled[settled > last] = NEVER
    return settled


class _Waves:
    """The tables of times, and views of them for every stencil."""

    def __init__(self, embedding: Embedding, front: Front):
        self._embedding, self._front, self._network = embedding, front, embedding.network
        self._layout = layout = self._network.layout
        self._durations = [segment.n_frames - 1 for segment in embedding.graph.segments]
        self.window, self.longest = min(self._durations), max(self._durations)
        self._kind = np.uint8 if self.window + 2 * self.longest < np.iinfo(np.uint8).max else np.uint16
        # A time that is far: nothing has come there yet. Adding a duration does not make it near.
        self._far = int(np.iinfo(self._kind).max) - self.longest
        moves = list(self._network.moves_within(embedding.nodes))
        _refuse_if_too_large(embedding, front, len(moves), np.dtype(self._kind).itemsize)

        shape = (front.n_tables, self._network.n_headings, layout.n_bits)
        self._times = np.full(shape, self._far, dtype=self._kind)
        self._settled = np.full(shape, NEVER, dtype=np.uint16)
        self._gathered = np.full((len(front.sources), *shape[1:]), self._far, dtype=self._kind)
        self._passed = np.empty(shape[1:], dtype=self._kind)
        self._later = np.empty(shape[1:], dtype=self._kind)
        self._stencils = self._lay_out(moves)
        self._halo = list(_halo_copies(self._passed, layout))
        #: Which tables have changed since they were gathered.
        self._changed = [False] * front.n_tables
        #: Times are counted from the base; 0 is what was settled before the base moved.
        self._base = 0

    def begin(self, seed: NodeSet) -> None:
        """Pass on the seed, at time 0."""
        n_headings = self._network.n_headings
        for segment in range(self._network.n_segments):
            planes = seed.planes[segment * n_headings : (segment + 1) * n_headings]
            used = [heading for heading, plane in enumerate(planes) if plane]
            if used:
                bits = _unpacked([self._layout.extend(planes[heading]) for heading in used], self._layout)
                self._passed[used] = np.where(bits, 0, self._far)
                self._passed[used] += self._kind(self._durations[segment])
                self._spread(segment, used)

    def begin_at(self, nodes: np.ndarray, frames: np.ndarray) -> None:
        """Pass on single nodes at their frames, which lie in the window that is being passed on."""
        for segment in np.unique(nodes[:, 3]).tolist():
            here = nodes[:, 3] == segment
            x, y, heading, _ = nodes[here].T
            used = np.unique(heading).tolist()
            self._passed[used] = self._far
            self._passed[heading, self._layout.bit(x, y)] = frames[here] - self._base
            for halo, ground in self._halo:
                halo[...] = ground
            self._passed[used] += self._kind(self._durations[segment])
            self._spread(segment, used)

    def pass_on(self, now: int) -> bool:
        """Pass on all times in the window that begins at frame ``now``; return True if there were any."""
        if now + self.window - 1 + self.longest - self._base >= self._far:
            self.settle()
            self._move_base(now - 1)
        fresh, self._changed = self._changed, [False] * len(self._changed)
        any_passed = False
        for group, tables in enumerate(self._front.sources):
            least = self._gathered[group]
            for table in tables:
                if fresh[table]:
                    np.minimum(least, self._times[table], out=least)
            np.subtract(least, self._kind(now - self._base), out=self._later)
            headings = np.flatnonzero(self._later.min(axis=1) < self.window).tolist()
            if not headings:
                continue
            any_passed = True
            for segment in self._front.players[group]:
                np.add(least, self._kind(self._durations[segment]), out=self._passed)
                for halo, ground in self._halo:
                    halo[...] = ground
                self._spread(segment, headings)
        return any_passed

    def settle(self) -> np.ndarray:
        """Note the times found so far. Those not settled yet may be too late; they are noted again when they are.

        What was settled before the base moved is 0 now, which is later than what was noted of it.
        """
        for table, noted in zip(self._times, self._settled, strict=True):
            found = table.astype(np.uint16)
            found += np.uint16(self._base)
            found |= np.negative((table >= self._far).view(np.uint8).astype(np.uint16))
            np.minimum(noted, found, out=noted)
        return self._settled

    def _spread(self, segment: int, headings: Sequence[int]) -> None:
        """Let a segment take the times passed on to where they lead."""
        stencils = self._stencils[segment]
        for heading in headings:
            for moving, barred, room, arriving in stencils[heading]:
                np.maximum(moving, barred, out=room)
                np.minimum(arriving, room, out=arriving)
        self._changed[self._front.table_of[segment]] = True

    def _move_base(self, base: int) -> None:
        """Count times from a later base: what lies before it becomes 0, what is far stays far."""
        moved, kind = base - self._base, self._kind
        for table in (*self._times, *self._gathered):
            np.maximum(table, kind(moved), out=table)
            table -= kind(moved)
            # Only what was far is as late as that now.
            late = (table >= self._far - moved).astype(kind)
            late *= kind(moved)
            table += late
        self._base = base

    def _lay_out(self, moves: list[tuple[int, int, int, int, int]]) -> list[list[list[tuple[np.ndarray, ...]]]]:
        """Lay out views for each segment and heading of the times passed on: of each stencil's moving times, of what
        bars them, of room for the result, and of the times where they arrive."""
        layout, passed, forwards = self._layout, self._passed, self._front.forwards
        able = [move[4] for move in moves]
        # Forwards, what arrives around a tiled ground started in its halo.
        barred = _unpacked([layout.extend(plane) for plane in able] if forwards else able, layout)
        barred ^= 1
        barred = barred.astype(self._kind, copy=False)
        barred *= self._kind(self._far)
        room = np.empty(layout.n_bits, dtype=self._kind)
        laid_out = [[[] for _ in range(self._network.n_headings)] for _ in range(self._network.n_segments)]
        for (segment, heading, turned, shift, plane), barring in zip(moves, barred, strict=True):
            first, end = (plane & -plane).bit_length() - 1, plane.bit_length()
            if forwards and layout.tiled:
                first, end = layout.bit(0, 0) - shift, layout.bit(layout.nx - 1, layout.ny - 1) + 1 - shift
            into = self._times[self._front.table_of[segment]]
            bars, space = barring[first:end], room[: end - first]
            if forwards:
                views = passed[heading, first:end], bars, space, into[turned, first + shift : end + shift]
                laid_out[segment][heading].append(views)
            else:
                views = passed[turned, first + shift : end + shift], bars, space, into[heading, first:end]
                laid_out[segment][turned].append(views)
        return laid_out


def _unpacked(planes: Sequence[int], layout: PlaneLayout) -> np.ndarray:
    """(n, n_bits) uint8: the bits of planes, padding and halo included."""
    return np.unpackbits(layout.to_rows(planes), axis=1, bitorder="little", count=layout.n_bits)


def _halo_copies(passed: np.ndarray, layout: PlaneLayout) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of views of (n_headings, n_bits) times: parts of a tiled ground's halo, and what they repeat; in order."""
    if not layout.tiled:
        return
    rows = passed.reshape(len(passed), -1, layout.stride)
    ground = rows[:, layout.halo_x : layout.halo_x + layout.nx]
    for there, here in _repetitions(layout.halo_y, layout.ny, layout.stride):
        yield ground[:, :, there], ground[:, :, here]
    for there, here in _repetitions(layout.halo_x, layout.nx, rows.shape[1]):
        yield rows[:, there], rows[:, here]


def _repetitions(halo: int, n: int, total: int) -> Iterator[tuple[slice, slice]]:
    """Slices of a line of ``total`` cells outside its n cells from ``halo`` on, and of those that they repeat."""
    for first in range(halo % n - n, total, n):
        start, stop = max(first, 0), min(first + n, total)
        if first != halo and stop > start:
            yield slice(start, stop), slice(halo + start - first, halo + stop - first)


def _progress(now: int, limit: int | None, embedding: Embedding) -> Progress:
    """Estimate how far the waves are: towards the limit, or across the ground at a metre per second."""
    if limit is not None:
        return Progress(now / (max(now, limit) + 1), "Following links")
    nx, ny, _, _ = embedding.shape
    expected = embedding.graph.frame_rate * (nx + ny) * embedding.environment.grid.cell_size
    return Progress(now / (now + expected), "Following links")


def needed_bytes(embedding: Embedding, front: Front, n_stencils: int, item_size: int) -> float:
    """Estimate the bytes that the waves take at their peak, never less and at most twice as many.

    A time for every bit of the planes of all stencils, tables and groups, two more bytes for the tables, the stencils'
    planes and their single bits while they are unpacked, and what is known of each stencil.
    """
    n_bits, n_headings = embedding.network.layout.n_bits, embedding.network.n_headings
    n_tables, n_groups = front.n_tables * n_headings, (len(front.sources) + 4) * n_headings
    times = n_stencils * (item_size + (1.5 if item_size > 1 else 0.5)) + n_tables * (item_size + 2)
    return n_bits * (times + n_groups * item_size + 8) + n_stencils * STENCIL_BYTES


def _refuse_if_too_large(embedding: Embedding, front: Front, n_stencils: int, item_size: int) -> None:
    needed, limit = needed_bytes(embedding, front, n_stencils, item_size), embedding.settings.memory_limit
    if needed > limit:
        nx, ny, n_headings = embedding.environment.grid.shape
        raise EmbeddingError(
            f"Times over {nx} x {ny} cells and {n_headings} headings would need about {wording.memory(needed)}, more "
            f"than the limit of {wording.memory(limit)}; use a larger Cell Size, fewer Headings or a smaller ground."
        )
