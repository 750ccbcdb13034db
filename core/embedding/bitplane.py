"""Bit-planes: one bool for every cell of the ground, in one Python integer.

Shifting a whole plane by (dx, dy) cells is one shift of the integer, because rows are padded so that what leaves a
row lands in padding. On planes of this size (some thousands of bits) Python's integers are several times faster
than NumPy, whose calls cost more than the work; on large planes both run at the speed of memory.

On a tiled ground the padding is a halo on all sides: :meth:`PlaneLayout.extend` fills it with the repetitions of the
tile, :meth:`PlaneLayout.fold` brings back what was shifted into it. Single steps never need to know about the torus.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class PlaneLayout:
    """The places of the cells in a plane.

    Attributes
    ----------
    nx, ny : int
        Cells of the ground.
    reach_x, reach_y : int
        No shift is longer than this many cells.
    tiled : bool

    Examples
    --------
    >>> layout = PlaneLayout(nx=3, ny=2, reach_x=1, reach_y=1, tiled=False)
    >>> plane = layout.pack(np.array([[True, False], [False, False], [False, False]]))
    >>> layout.cells(plane << layout.shift(2, 1)).tolist()
    [[2, 1]]
    """

    nx: int
    ny: int
    reach_x: int
    reach_y: int
    tiled: bool

    @property
    def halo_x(self) -> int:
        return self.reach_x if self.tiled else 0

    @property
    def halo_y(self) -> int:
        return self.reach_y if self.tiled else 0

    @property
    def stride(self) -> int:
        """Bits from one row (x) to the next."""
        return self.ny + self.reach_y + self.halo_y

    @property
    def n_bits(self) -> int:
        return (self.nx + 2 * self.halo_x) * self.stride

    @property
    def n_bytes(self) -> int:
        return (self.n_bits + 7) // 8

    @property
    def expected_rounds(self) -> float:
        """About how many of the longest shifts it takes to cross the ground."""
        return (self.nx + self.ny) / max(self.reach_x, self.reach_y, 1)

    def shift(self, dx, dy):
        """Bits by which a plane moves for a step of (dx, dy) cells; integers or integer arrays."""
        return dx * self.stride + dy

    def bit(self, x, y):
        """Index of the bit of cell (x, y); integers or integer arrays."""
        return (x + self.halo_x) * self.stride + y + self.halo_y

    def pack(self, cells: np.ndarray) -> int:
        """Return the plane of an (nx, ny) bool array."""
        rows = np.zeros((self.nx + 2 * self.halo_x, self.stride), dtype=bool)
        rows[self.halo_x : self.halo_x + self.nx, self.halo_y : self.halo_y + self.ny] = cells
        return int.from_bytes(np.packbits(rows.ravel(), bitorder="little").tobytes(), "little")

    def unpack(self, plane: int) -> np.ndarray:
        """Return the (nx, ny) bool array of a plane."""
        raw = np.frombuffer(plane.to_bytes((self.n_bits + 7) // 8, "little"), dtype=np.uint8)
        rows = np.unpackbits(raw, bitorder="little", count=self.n_bits).reshape(-1, self.stride)
        ground = rows[self.halo_x : self.halo_x + self.nx, self.halo_y : self.halo_y + self.ny]
        return ground.astype(bool)

    def to_rows(self, planes: Sequence[int]) -> np.ndarray:
        """Return the bytes of planes, lowest first: (n, n_bytes) uint8."""
        raw = b"".join([plane.to_bytes(self.n_bytes, "little") for plane in planes])
        return np.frombuffer(raw, dtype=np.uint8).reshape(-1, self.n_bytes)

    def cells(self, plane: int) -> np.ndarray:
        """Return (n, 2) int array of the cells whose bit is set, in order of x, then y."""
        return np.argwhere(self.unpack(plane))

    def flat_cells(self, plane: int) -> np.ndarray:
        """Return (n,) int array of the cells x * ny + y whose bit is set, ascending."""
        return np.flatnonzero(self.unpack(plane))

    def moved(self, cells: np.ndarray, shift: int) -> np.ndarray:
        """Return where cells x * ny + y lie after a shift that keeps them on the ground, or around a tiled one."""
        x, y = np.divmod(self.bit(*np.divmod(cells, self.ny)) + shift, self.stride)
        return (x - self.halo_x) % self.nx * self.ny + (y - self.halo_y) % self.ny

    @cached_property
    def ground(self) -> int:
        """The plane with every cell of the ground set."""
        return self.pack(np.ones((self.nx, self.ny), dtype=bool))

    def extend(self, plane: int) -> int:
        """Return the plane with its halo filled by the tile's repetitions; unchanged where the ground is not tiled."""
        if not self.tiled:
            return plane
        row = 0
        for columns, moved in self._column_moves:
            part = plane & columns
            row |= part << moved if moved >= 0 else part >> -moved
        extended = 0
        for moved in self._row_moves:
            extended |= row << moved if moved >= 0 else row >> -moved
        return extended & self._everything

    def fold(self, plane: int) -> int:
        """Return the ground part of a plane, with what lies in the halo brought in; unchanged where not tiled."""
        if not self.tiled:
            return plane
        rows = 0
        for moved in self._row_moves:
            rows |= plane >> moved if moved >= 0 else plane << -moved
        folded = 0
        for columns, moved in self._column_moves:
            landed = columns << moved if moved >= 0 else columns >> -moved
            part = rows & landed
            folded |= part >> moved if moved >= 0 else part << -moved
        return folded & self.ground

    @cached_property
    def _everything(self) -> int:
        return (1 << self.n_bits) - 1

    @cached_property
    def _row_moves(self) -> list[int]:
        """Shifts that carry the tile's rows onto each of its repetitions in x."""
        repeats = -(-self.halo_x // self.nx)
        return [a * self.nx * self.stride for a in range(-repeats, repeats + 1)]

    @cached_property
    def _column_moves(self) -> list[tuple[int, int]]:
        """For each repetition in y: the columns of the tile that it shows (on every row), and the shift to it."""
        repeats = -(-self.halo_y // self.ny)
        moves = []
        for a in range(-repeats, repeats + 1):
            y = np.arange(self.ny)
            shown = (y + self.halo_y + a * self.ny >= 0) & (y + self.halo_y + a * self.ny < self.stride)
            rows = np.zeros((self.nx + 2 * self.halo_x, self.stride), dtype=bool)
            rows[:, self.halo_y : self.halo_y + self.ny] = shown
            columns = int.from_bytes(np.packbits(rows.ravel(), bitorder="little").tobytes(), "little")
            moves.append((columns, a * self.ny))
        return moves
