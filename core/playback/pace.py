"""Standing about and turning back, as an onlooker sees them."""

import numpy as np

from ..motion.runs import runs

#: Metres per second, at a person's size, below which one stands, turns on the spot or shuffles.
IDLE_SPEED = 0.45

#: Seconds over which that speed is told, half of them to each side.
SPEED_TIME = 0.5

#: Seconds within which who turns by more than ``TURN_ANGLE`` radians turns back.
TURN_TIME, TURN_ANGLE = 2.0, float(np.radians(120))


def idle_frames(path: np.ndarray, frame_rate: float, size: float = 1.0) -> np.ndarray:
    """Return (F,) bool: where someone of a relative ``size`` hardly moves on, from x, y, heading (F, 3) of the root."""
    every, half = np.arange(len(path)), max(round(SPEED_TIME / 2 * frame_rate), 1)
    before, after = np.maximum(every - half, 0), np.minimum(every + half, len(path) - 1)
    metres = np.linalg.norm(path[after, :2] - path[before, :2], axis=1)
    return metres * frame_rate < IDLE_SPEED * size * np.maximum(after - before, 1)


def times_turned_back(heading: np.ndarray, frame_rate: float) -> int:
    """Count how often someone turns back, from unwrapped headings (F,).

    >>> times_turned_back(np.radians([0, 0, 90, 180, 180, 180, 180]), 1.0)
    1
    """
    window = round(TURN_TIME * frame_rate)
    if len(heading) <= window:
        return 0
    return len(runs(np.abs(heading[window:] - heading[:-window]) > TURN_ANGLE))
