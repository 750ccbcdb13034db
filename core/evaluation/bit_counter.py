"""Bit-sliced counters: a count for every cell, as bit-planes of the counts' binary digits.

Adding up thousands of planes, or multiplying the counts of a whole ground, is then a row of ANDs and XORs of whole
planes: no array of numbers is ever laid out, and a count takes as many bits as it needs. Planes may just as well be
packed ones (see :class:`.HeadingPacking`); each bit is a cell of its own and never carries into its neighbour.
"""

from collections.abc import Sequence

#: Binary digits of a count for every cell, lowest first; the last one is not 0. No digits: 0 everywhere.
BitCounts = list[int]


class BitCounter:
    """Planes that wait to be added up by carry-save adders; those in column i count 2**i.

    Examples
    --------
    >>> counter = BitCounter()
    >>> for plane in (0b011, 0b001, 0b101):
    ...     counter.add(plane)
    >>> counter.total()  # 3, 1 and 1 in the three cells: 111 and 001
    [7, 1]
    """

    def __init__(self):
        self._columns: list[list[int]] = []

    def add(self, plane: int, digit: int = 0) -> None:
        """Count 2**digit more in every cell of a plane."""
        if plane:
            while len(self._columns) <= digit:
                self._columns.append([])
            self._columns[digit].append(plane)

    def add_counts(self, counts: BitCounts) -> None:
        for digit, plane in enumerate(counts):
            self.add(plane, digit)

    def add_product(self, a: BitCounts, b: BitCounts) -> None:
        """Count a x b more."""
        for i, x in enumerate(a):
            for j, y in enumerate(b):
                self.add(x & y, i + j)

    def total(self) -> BitCounts:
        """Return the sum of everything that was added; the columns are empty afterwards.

        A carry-save adder makes three planes of a column into one and a carry, until one is left: five operations for
        each plane.
        """
        columns, self._columns = self._columns, []
        counts = []
        carries: list[int] = []
        while columns or carries:
            column = carries + (columns.pop(0) if columns else [])
            carries = []
            while len(column) > 1:
                a, b, c = column.pop(), column.pop(), column.pop() if column else 0
                half = a ^ b
                carry = (a & b) | (half & c) if c else a & b
                if carry:
                    carries.append(carry)
                column.append(half ^ c)
            counts.append(column[0] if column else 0)
        return _stripped(counts)


def masked(counts: BitCounts, plane: int) -> BitCounts:
    """Return the counts in the cells of a plane, 0 elsewhere."""
    return _stripped([digit & plane for digit in counts])


def product(a: BitCounts, b: BitCounts) -> BitCounts:
    """Multiply the counts of every cell."""
    columns = BitCounter()
    columns.add_product(a, b)
    return columns.total()


def sum_of_products(a: BitCounts, b: BitCounts) -> int:
    """Return a x b, summed over all cells."""
    return sum((x & y).bit_count() << i + j for i, x in enumerate(a) for j, y in enumerate(b))


def constant(number: int, everywhere: int) -> BitCounts:
    """Return the same count in all cells of the plane ``everywhere``."""
    return [everywhere if number >> digit & 1 else 0 for digit in range(number.bit_length())]


def less(a: BitCounts, b: BitCounts) -> int:
    """Return the plane of the cells where a < b.

    >>> less(constant(2, 0b11), [0b01, 0b11])  # 2 < 3 in the first cell, not 2 < 2 in the second
    1
    """
    below = 0
    for digit in range(max(len(a), len(b))):
        x, y = digit_of(a, digit), digit_of(b, digit)
        below ^= (x ^ y) & (below ^ y)
    return below


def minus(a: BitCounts, b: BitCounts) -> BitCounts:
    """Return a - b, which must not be negative anywhere."""
    rest, borrow = [], 0
    for digit, x in enumerate(a):
        y = digit_of(b, digit)
        differ = x ^ y
        rest.append(differ ^ borrow)
        borrow ^= differ & (borrow ^ y)
    return _stripped(rest)


def digit_of(counts: Sequence[int], digit: int) -> int:
    """Return the plane of one binary digit."""
    return counts[digit] if digit < len(counts) else 0


def _stripped(counts: BitCounts) -> BitCounts:
    while counts and not counts[-1]:
        counts.pop()
    return counts
