"""A colour for each reason why a place is not in the embedding, that everybody can tell apart."""

import numpy as np

from ..evaluation.why_not import REASON_LABELS, Reason
from .colors import opaque_map

# sRGB, after Okabe and Ito's palette for all kinds of colour vision; lightness differs, too.
_COLORS = {
    Reason.EMBEDDED: (0.88, 0.88, 0.87),
    Reason.BLOCKED: (0.07, 0.08, 0.10),
    Reason.RULE: (0.40, 0.15, 0.00),
    Reason.FORBIDDEN: (0.94, 0.89, 0.26),
    Reason.NO_WAY_OUT: (0.84, 0.37, 0.00),
    Reason.NO_WAY_IN: (0.00, 0.36, 0.62),
    Reason.NO_MATCH: (0.80, 0.47, 0.65),
    Reason.OTHER_COMPONENT: (0.00, 0.62, 0.45),
    Reason.UNREACHABLE: (0.45, 0.45, 0.47),
}


def reason_colors(floor: np.ndarray) -> np.ndarray:
    """(nx, ny, 4) linear RGBA for the floor, from (nx, ny) reasons."""
    table = np.array([_COLORS[reason] for reason in Reason])
    return opaque_map(table[floor])


def reason_legend() -> dict[str, tuple[str, tuple[float, float, float]]]:
    """Label and sRGB colour of each reason, by its name."""
    return {reason.name: (REASON_LABELS[reason], _COLORS[reason]) for reason in Reason}
