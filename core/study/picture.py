"""Small floor maps, as they are kept with every case for comparison."""

import base64
import zlib
from dataclasses import dataclass

import numpy as np

from ..files import inflate
from .subject import Subject

#: Cells of a small map along its longer side, at most.
LONGEST_SIDE = 120

#: Levels of floor that is free, but that nothing passes, and of floor under a region's rule that can only be crossed.
NOT_PASSED, ONLY_CROSSED = -1.0, -2.0


@dataclass(frozen=True)
class SmallMap:
    """A floor map, made coarser if it was large.

    Attributes
    ----------
    levels : (nx, ny) float32 array
        Base-10 logarithm of the variability, in the mean over what is passed; ``NOT_PASSED``, ``ONLY_CROSSED``; not a
        number where something stands.
    cell_size : float
        Metres.
    """

    levels: np.ndarray
    cell_size: float


def small_map(subject: Subject) -> SmallMap:
    """Draw the floor map of a subject, coarser if it is large."""
    ways, free = subject.ways, subject.free
    step = -(-max(ways.shape) // LONGEST_SIDE)
    pad = [(0, -n % step) for n in ways.shape]

    def blocks(cells: np.ndarray) -> np.ndarray:
        padded = np.pad(cells, pad)
        nx, ny = padded.shape
        return padded.reshape(nx // step, step, ny // step, step).sum(axis=(1, 3))

    passed = blocks((ways > 0).astype(np.int64))
    with np.errstate(divide="ignore", invalid="ignore"):
        levels = np.log10(blocks(ways) / passed)
    levels[passed == 0] = np.nan
    for cells, level in ((subject.ruled, ONLY_CROSSED), (free, NOT_PASSED)):
        levels[(passed == 0) & (blocks(cells.astype(np.int64)) > 0)] = level
    return SmallMap(levels.astype(np.float32), subject.cell_size * step)


def map_to_json(picture: SmallMap) -> dict:
    """Convert a map for JSON."""
    packed = zlib.compress(np.ascontiguousarray(picture.levels, dtype="<f4").tobytes())
    return {
        "shape": list(picture.levels.shape),
        "cell_size": picture.cell_size,
        "levels": base64.b64encode(packed).decode("ascii"),
    }


def map_from_json(found: dict) -> SmallMap:
    """Read the map of :func:`map_to_json`; ValueError or another exception if it is damaged."""
    nx, ny = map(int, found["shape"])
    if not (0 <= nx <= LONGEST_SIDE and 0 <= ny <= LONGEST_SIDE):
        raise ValueError("a small map is not so large")
    raw = inflate(base64.b64decode(found["levels"]), 4 * nx * ny)
    levels = np.frombuffer(raw, dtype="<f4").reshape(nx, ny)
    return SmallMap(levels, float(found["cell_size"]))
