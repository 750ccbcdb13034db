"""Runs of frames."""

import numpy as np


def runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """List the first and the last index of each run of True in a (F,) mask.

    >>> runs(np.array([True, False, True, True]))
    [(0, 0), (2, 3)]
    """
    changes = np.flatnonzero(np.diff(np.asarray(mask, dtype=np.int8), prepend=0, append=0))
    return list(zip(changes[::2].tolist(), (changes[1::2] - 1).tolist(), strict=True))
