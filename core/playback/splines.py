"""Cubic Hermite splines that close a gap over a window of frames."""

import numpy as np


def closing(steps: np.ndarray, window: np.ndarray | int) -> tuple[np.ndarray, np.ndarray]:
    """Factors of a gap's value and of its slope (per frame), ``steps`` frames away from it.

    At the gap (step 0) they are 1 and 0 with slopes 0 and 1; at the end of the window, of ``window`` frames, both are
    0 with slope 0, as they are beyond.
    """
    s = np.minimum(steps / window, 1.0)
    return 2 * s**3 - 3 * s**2 + 1, (s**3 - 2 * s**2 + s) * window
