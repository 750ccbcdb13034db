"""Sets of nodes as bit-planes, and planes of several headings packed into one integer."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import and_, or_, xor

from .bitplane import PlaneLayout

#: Beyond this size packing planes costs more than it saves (measured).
PACKED_BYTES = 4096


@dataclass(frozen=True)
class NodeSet:
    """A set of nodes (cell, heading, segment) of one network.

    ``len`` is the number of nodes. ``a - b``, ``a & b`` and ``a | b`` are those of Python's sets, ``a <= b`` tests for
    a subset.

    Attributes
    ----------
    planes : tuple of int
        For each segment and heading (index segment * n_headings + heading) a bit-plane over the cells. Loops that count
        each microsecond work on these.

    Examples
    --------
    >>> a, b = NodeSet((0b0110, 0b1000)), NodeSet((0b0011, 0b1000))
    >>> a & b, len(a | b), bool(a - a), a & b <= a
    (NodeSet(planes=(2, 8)), 4, False, True)
    """

    planes: tuple[int, ...]

    def __and__(self, other: "NodeSet") -> "NodeSet":
        return NodeSet(tuple(map(and_, self.planes, other.planes)))

    def __or__(self, other: "NodeSet") -> "NodeSet":
        return NodeSet(tuple(map(or_, self.planes, other.planes)))

    def __sub__(self, other: "NodeSet") -> "NodeSet":
        return NodeSet(tuple(map(xor, self.planes, map(and_, self.planes, other.planes))))

    def __le__(self, other: "NodeSet") -> bool:
        return (self & other).planes == self.planes

    def __len__(self) -> int:
        return sum(map(int.bit_count, self.planes))

    def __bool__(self) -> bool:
        return any(self.planes)

    def where(self, keep: Callable[[int], object]) -> "NodeSet":
        """Return the nodes in the planes whose index is to be kept."""
        return NodeSet(tuple(plane if keep(index) else 0 for index, plane in enumerate(self.planes)))

    def on(self, plane: int) -> "NodeSet":
        """Return the nodes on the cells of a plane."""
        return NodeSet(tuple(nodes & plane for nodes in self.planes))


def union_of(planes: Iterable[int]) -> int:
    """Return the plane of all cells that are set in any of some planes."""
    union = 0
    for plane in planes:
        union |= plane
    return union


@dataclass(frozen=True)
class HeadingPacking:
    """Planes of one segment and of several neighbouring headings, a *block*, side by side in one integer.

    What concerns all headings alike - "how many segments may follow here?" - is then one operation for many planes. On
    small grounds, where an operation costs more than the bits it moves, a block holds all headings; on large ones,
    where packing would cost more than it saves, just one.

    Attributes
    ----------
    n_headings, plane_bytes : int
    headings : int
        How many there are in a block.
    """

    n_headings: int
    plane_bytes: int
    headings: int

    @classmethod
    def for_planes(cls, layout: PlaneLayout, n_headings: int, packed_bytes: int = PACKED_BYTES) -> "HeadingPacking":
        """Return the packing that is fastest: planes of up to ``packed_bytes`` bytes lie in blocks of all headings."""
        plane_bytes = layout.n_bytes
        return cls(n_headings, plane_bytes, n_headings if plane_bytes <= packed_bytes else 1)

    @property
    def n_blocks(self) -> int:
        return self.n_headings // self.headings

    def pack(self, planes: Sequence[int]) -> list[int]:
        """Return the blocks of the planes of any number of whole blocks."""
        if self.headings == 1:
            return list(planes)
        size = self.plane_bytes
        return [
            int.from_bytes(
                b"".join([plane.to_bytes(size, "little") for plane in planes[i : i + self.headings]]), "little"
            )
            for i in range(0, len(planes), self.headings)
        ]

    def unpack(self, block: int) -> list[int]:
        """Return the plane of each heading of a block."""
        if self.headings == 1:
            return [block]
        size = self.plane_bytes
        raw = block.to_bytes(size * self.headings, "little")
        return [int.from_bytes(raw[i : i + size], "little") for i in range(0, len(raw), size)]

    def unpack_all(self, blocks: Iterable[int]) -> NodeSet:
        """Return the set of nodes of which :meth:`pack` made the blocks."""
        return NodeSet(tuple(plane for block in blocks for plane in self.unpack(block)))
