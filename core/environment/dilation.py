"""Dilation: everything that lies near what is occupied, found on all samples at once.

The samples are one Python integer, a bit each, so that moving all of them is a single shift. The disc of all offsets
that are near is a stack of rows; what is occupied is widened to each of them once, from the shortest to the longest,
and moved to where the row lies in the disc. That gives what a distance transform compared with the radius gives, in a
small part of its time, and in memory of some bits for a sample instead of 40 bytes.
"""

import numpy as np


def samples_near(occupied: np.ndarray, distance: float) -> np.ndarray:
    """Return the samples with a point nearer than ``distance`` to an occupied one, or that are occupied (dilation).

    The distance between two samples is that of the nearest points of their squares: growing the occupied ones by one
    sample in all eight directions and measuring between centres gives exactly that.

    >>> occupied = np.zeros((5, 5), dtype=bool)
    >>> occupied[2, 2] = True
    >>> samples_near(occupied, 0.5).astype(int)
    array([[0, 0, 0, 0, 0],
           [0, 1, 1, 1, 0],
           [0, 1, 1, 1, 0],
           [0, 1, 1, 1, 0],
           [0, 0, 0, 0, 0]])

    Parameters
    ----------
    occupied : (width, depth) bool array
    distance : float
        In samples; more than 0.

    Returns
    -------
    (width, depth) bool array: right wherever the border is more than ``distance`` + 1 samples away. Nearer to it, what
    is occupied on the opposite side of the next row shows, too.
    """
    width, depth = occupied.shape
    n_bits = width * depth
    bits = int.from_bytes(np.packbits(occupied, axis=None, bitorder="little").tobytes(), "little")
    if not bits:
        return np.zeros(occupied.shape, dtype=bool)
    row = bits | bits << 1 | bits >> 1
    row, half = row | row << depth | row >> depth, 0
    near = 0
    for dx, longest in reversed(list(enumerate(_half_rows(distance)))):
        while half < longest:
            # Farther at a time, there would be gaps.
            step = min(longest - half, 2 * half + 1)
            row, half = row | row << step | row >> step, half + step
        near |= row << dx * depth | row >> dx * depth
    raw = (near & ((1 << n_bits) - 1)).to_bytes((n_bits + 7) // 8, "little")
    found = np.unpackbits(np.frombuffer(raw, dtype=np.uint8), count=n_bits, bitorder="little")
    return found.view(bool).reshape(occupied.shape)


def _half_rows(distance: float) -> list[int]:
    """Return, for each row of the disc from its middle outwards, the samples beside the one in the middle."""
    # A hair of tolerance on the safe side, against rounding in the distance itself.
    limit = distance * (1 + 1e-9)
    across = np.arange(int(np.ceil(limit)) + 1)
    counts = (int(np.count_nonzero(np.sqrt((across**2 + dx * dx).astype(float)) < limit)) for dx in across)
    return [n - 1 for n in counts if n > 0]
