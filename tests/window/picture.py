"""Pictures of the screen: files to keep, and pixels to look at."""

import subprocess

import bpy
import numpy as np

_GRAB = ["import", "-window", "root", "-depth", "8"]


def save_picture(path: str) -> None:
    subprocess.run([*_GRAB, path], check=True)


def pixels() -> np.ndarray:
    """The window: (height, width, 3) uint8 sRGB, rows from the bottom upwards as in Blender's own coordinates."""
    raw = subprocess.run([*_GRAB, "rgb:-"], check=True, stdout=subprocess.PIPE).stdout
    window = bpy.context.window_manager.windows[0]
    return np.frombuffer(raw, np.uint8).reshape(window.height, window.width, 3)[::-1]


def changed_box(before: np.ndarray, after: np.ndarray, least: int = 8) -> tuple[int, int, int, int] | None:
    """x, y, width and height of what differs by ``least`` or more; None if nothing does."""
    differs = np.abs(before.astype(int) - after.astype(int)).max(axis=2) >= least
    if not differs.any():
        return None
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    return (
        int(columns[0]),
        int(rows[0]),
        int(columns[-1] - columns[0] + 1),
        int(rows[-1] - rows[0] + 1),
    )


def n_changed(before: np.ndarray, after: np.ndarray, least: int = 24) -> int:
    """How many pixels differ by more than ``least``."""
    return int((np.abs(after.astype(int) - before) > least).any(axis=2).sum())


def nearest_distance(colors: np.ndarray, wanted) -> int:
    """How far the nearest pixel is from an sRGB colour (0 to 1): the largest difference of a channel, in 1/255."""
    differences = np.abs(colors.reshape(-1, 3).astype(int) - np.round(255 * np.asarray(wanted)).astype(int))
    return int(differences.max(axis=1).min())


def _bright(pixels: np.ndarray) -> np.ndarray:
    """Where a line of an icon is: much brighter than most."""
    grey = pixels.astype(int).max(axis=2)
    return grey > np.median(grey) + 60


def bright_part(pixels: np.ndarray) -> tuple[np.ndarray, int]:
    """The smallest mask that holds all bright pixels, and the x where it begins."""
    mask = _bright(pixels)
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], int(columns[0])


def find_all(mask: np.ndarray, pixels: np.ndarray) -> list[tuple[int, int]]:
    """x, y of the middle of every place that is bright as the mask is, and nowhere else."""
    windows = np.lib.stride_tricks.sliding_window_view(_bright(pixels), mask.shape)
    rows, columns = np.nonzero((windows != mask).sum(axis=(2, 3)) <= 0.06 * mask.size)
    height, width = mask.shape
    return [(int(x) + width // 2, int(y) + height // 2) for y, x in zip(rows, columns, strict=True)]
