"""A chapter of the reproduction: figures, numbers, and comparisons with the paper."""

from dataclasses import dataclass, field
from typing import Any

from ...core import wording
from ...core.report.drawing import Drawing
from ...core.report.page import Section

PAPER = "Reitsma & Pollard, CS-04-04 (2004)"


@dataclass(frozen=True)
class Comparison:
    """One of the paper's numbers beside ours.

    Attributes
    ----------
    what, paper, ours : str
    why : str
        A word on the difference.
    """

    what: str
    paper: str
    ours: str
    why: str = ""


@dataclass(frozen=True)
class Chapter:
    """One chapter of the report.

    Attributes
    ----------
    section : Section
    figures : dict of str to Drawing
        By the name of a file.
    numbers : dict of plain values
    comparisons : tuple of Comparison
    """

    section: Section
    figures: dict[str, Drawing] = field(default_factory=dict)
    numbers: dict[str, Any] = field(default_factory=dict)
    comparisons: tuple[Comparison, ...] = ()


def size_of(embedding) -> str:
    """Nodes and links: "198 k / 1.47 M"."""
    return f"{wording.short(embedding.n_nodes)} / {wording.short(embedding.n_links)}"
