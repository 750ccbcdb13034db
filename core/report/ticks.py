"""Round numbers along an axis."""

import math

import numpy as np

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


def ticks(low: float, high: float, n: int = 5) -> np.ndarray:
    """Return about ``n`` round, evenly spaced numbers, from ``low`` or lower to ``high`` or higher.

    >>> ticks(0.0, 7.0).tolist()
    [0.0, 2.0, 4.0, 6.0, 8.0]
    """
    if not high > low:
        low, high = (low - 0.5, low + 0.5) if low else (0.0, 1.0)
    rough = (high - low) / max(n - 1, 1)
    magnitude = 10.0 ** math.floor(math.log10(rough))
    step = magnitude * min(s for s in _STEPS if s * magnitude >= rough * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return np.arange(first, last + 1) * step
