"""Round times that tell places apart: limits for the areas and maps of the paper's Fig. 8 that suit a scene."""

import numpy as np

#: Of the places reached, those that each limit holds.
SHARES = (0.2, 0.5, 0.8, 0.95)

_ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)


def telling_times(seconds: np.ndarray) -> tuple[float, ...]:
    """Up to four ascending round times, within which about 20, 50, 80 and 95 % of the places with a finite time lie.

    ``seconds`` is an array of any shape, not finite where there is no time. (1.0,) if there is none at all.
    """
    known = seconds[np.isfinite(seconds)]
    if not known.size:
        return (1.0,)
    return tuple(sorted({_rounded(float(limit)) for limit in np.quantile(known, SHARES)}))


def _rounded(seconds: float) -> float:
    """The round number nearest to a time, by ratio; half a second at least."""
    if seconds <= 0.5:
        return 0.5
    magnitude = 10.0 ** np.floor(np.log10(seconds))
    nearest = min(_ROUND, key=lambda step: abs(np.log(step * magnitude / seconds)))
    # The digits that were meant, without what multiplying adds.
    return float(f"{nearest * magnitude:.2g}")
