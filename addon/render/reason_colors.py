"""Why not, on the floor: one reason for each cell, and a colour for each reason that everybody can tell apart."""

import numpy as np

from ...core.environment.environment import Environment
from ...core.environment.grid import SUBDIVISION
from ...core.environment.regions import RegionRule
from ...core.evaluation.why_not import Reason
from .map_colors import opaque_map

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
_LABELS = {
    Reason.EMBEDDED: "Can Go Here",
    Reason.BLOCKED: "Too Near an Obstacle",
    Reason.RULE: "Crossed by a Region's Rule",
    Reason.FORBIDDEN: "Forbidden by Regions",
    Reason.NO_WAY_OUT: "No Way Out",
    Reason.NO_WAY_IN: "No Way In",
    Reason.NO_MATCH: "Ways In and Out Do Not Match",
    Reason.OTHER_COMPONENT: "Only in Another Component",
    Reason.UNREACHABLE: "No Segment Fits",
}


def floor_reasons(reasons: np.ndarray) -> np.ndarray:
    """(nx, ny) uint8 :class:`Reason` of each cell, from those of its headings (nx, ny, n_headings).

    EMBEDDED if any heading is; otherwise the most common one, and of equally common ones the first.
    """
    counts = np.stack([(reasons == reason).sum(axis=2) for reason in Reason], axis=2)
    most = counts.argmax(axis=2)
    embedded = counts[..., Reason.EMBEDDED] > 0
    return np.where(embedded, int(Reason.EMBEDDED), most).astype(np.uint8)


def rule_labels(environment: Environment) -> str:
    """What the environment's regions require, if they all require the same."""
    tags = {region.tag for region in environment.regions if region.rule is RegionRule.REQUIRE}
    return f"Crossed by '{tags.pop()}' Only" if len(tags) == 1 else _LABELS[Reason.RULE]


def place_reason(reason: Reason, environment: Environment, x: int, y: int) -> str:
    """The reason of a single cell in words, with the names of the regions whose rule must be kept there."""
    middle = SUBDIVISION // 2
    at = x * SUBDIVISION + middle, y * SUBDIVISION + middle
    rules = [r for r in environment.regions if r.rule is not RegionRule.CONFINE and r.mask[at]]
    if rules and reason in (Reason.RULE, Reason.FORBIDDEN):
        words = [f"'{r.tag}' {'only' if r.rule is RegionRule.REQUIRE else 'not'} ({r.name})" for r in rules]
        return f"Rule of the region: {', '.join(words)}"
    return _LABELS[reason]


def reason_colors(floor: np.ndarray) -> np.ndarray:
    """(nx, ny, 4) linear RGBA for the floor, from (nx, ny) reasons."""
    table = np.array([_COLORS[reason] for reason in Reason])
    return opaque_map(table[floor])


def reason_legend() -> dict[str, tuple[str, tuple[float, float, float]]]:
    """Label and sRGB colour of each reason, by its name."""
    return {reason.name: (_LABELS[reason], _COLORS[reason]) for reason in Reason}


def reason_shares(floor: np.ndarray) -> dict[str, float]:
    """The share (0 to 1) of the floor that each reason has, by its name; those without any left out."""
    counts = np.bincount(floor.ravel(), minlength=len(Reason)).tolist()
    return {reason.name: float(counts[reason] / floor.size) for reason in Reason if counts[reason]}
