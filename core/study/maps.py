"""The maps of a ground in parcels, put together: arrays for programs, pictures for people."""

import io
from pathlib import Path

import numpy as np

from ..files import write_files
from ..maps.colors import RULED
from ..maps.scales import CIVIDIS
from ..report.png import png_bytes
from .subject import Subject

#: Colours (sRGB) of cells where something stands, and of floor that nothing passes.
BLOCKED, NOT_REACHED = (0.25, 0.25, 0.27), (0.86, 0.36, 0.30)

#: Rows of a picture that are coloured at once.
_ROWS_AT_ONCE = 256


def shaded(shares: np.ndarray, passed: np.ndarray, free: np.ndarray, ruled: np.ndarray) -> np.ndarray:
    """(..., 3) float: the colour of each cell, for shares (...) of the way from the least to the most; ``RULED`` where
    floor can only be crossed."""
    colors = CIVIDIS.colors(np.where(passed, shares, 0.0))
    colors[~passed] = BLOCKED
    colors[~passed & ruled] = RULED
    colors[~passed & free] = NOT_REACHED
    return colors


def write_maps(subject: Subject, origin: tuple[float, float], folder: Path) -> None:
    """Write ``maps.npz``, ``variability.png`` and ``coverage.png`` into a folder; StorageError if that cannot be done.

    The arrays are (nx, ny): ``variability`` (ways through a cell), ``coverage`` (headings in which it can be passed)
    and ``free``; further ``cell_size`` and ``origin`` (the lowest corner of cell (0, 0)) in metres. A pixel is a cell,
    x to the right and y upwards; variability is shown by its logarithm.
    """
    ways, headings, free = subject.ways, subject.headings, subject.free
    buffer = io.BytesIO()
    arrays = {"variability": ways, "coverage": headings, "free": free}
    np.savez_compressed(buffer, **arrays, cell_size=subject.cell_size, origin=np.array(origin))
    files = {"maps.npz": buffer.getvalue()}
    most = np.log10(max(int(ways.max(initial=0)), 10))
    pictures = {"variability": np.log10(np.maximum(ways, 1)) / most, "coverage": headings / subject.n_headings}
    for name, shares in pictures.items():
        files[f"{name}.png"] = png_bytes(_picture(shares, headings > 0, free, subject.ruled))
    write_files(folder, files)


def _picture(shares: np.ndarray, passed: np.ndarray, free: np.ndarray, ruled: np.ndarray) -> np.ndarray:
    """(ny, nx, 3) uint8, the highest y first."""
    nx, ny = shares.shape
    pixels = np.empty((ny, nx, 3), dtype=np.uint8)
    for y in range(0, ny, _ROWS_AT_ONCE):
        part = np.s_[:, y : y + _ROWS_AT_ONCE]
        colors = shaded(shares[part], passed[part], free[part], ruled[part])
        pixels[y : y + _ROWS_AT_ONCE] = np.round(255 * colors).astype(np.uint8).swapaxes(0, 1)
    return np.ascontiguousarray(pixels[::-1])
