"""What one section gives to a report: text and figures for its page, and the numbers behind them."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...embedding.embedding import Embedding
from ...embedding.network import Nodes
from ...progress import Progress
from ..drawing import Drawing
from ..floor_chart import FloorScene
from ..page import Section
from ..table import Table


@dataclass(frozen=True)
class Goal:
    """A place, or something to do, that it should not take long to get to.

    Attributes
    ----------
    name : str
        As it stands in a sentence: "the door".
    nodes : Nodes
        A set of the embedding's network; see :mod:`core.evaluation.goals`.
    """

    name: str
    nodes: Nodes


@dataclass(frozen=True)
class Questions:
    """What all sections are told.

    Attributes
    ----------
    thorough : bool
        Whether to look at single segments, at every motion that might be captured, and at many places; otherwise a
        good part of that.
    goal : Goal or None
    obstacles : (4 nx, 4 ny) bool array or None
        Samples on which something stands, for the maps.
    seed : int
        Of the places that are drawn.
    n_pairs : int
        Pairs of places that are drawn for path efficiency.
    allowed_loss : float
        Share of the covered floor that deleting clips together may cost.
    """

    thorough: bool = True
    goal: Goal | None = None
    obstacles: np.ndarray | None = None
    seed: int = 0
    n_pairs: int = 100
    allowed_loss: float = 0.01

    def floor_scene(self, embedding: Embedding) -> FloorScene:
        return FloorScene(embedding.environment, self.obstacles, embedding.unrolling.sweep.classes)


@dataclass(frozen=True)
class Contribution:
    """What one section gives to a report.

    Attributes
    ----------
    section : Section
        For the page.
    numbers : dict
        Plain values, units in their names, for JSON.
    tables : dict of str to Table
        By the name of a file.
    maps, charts : dict of str to Drawing
        Floor maps and curves by the name of a file.
    """

    section: Section
    numbers: dict[str, Any] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    maps: dict[str, Drawing] = field(default_factory=dict)
    charts: dict[str, Drawing] = field(default_factory=dict)


SectionSteps = Callable[[Embedding, Questions], Generator[Progress, None, Contribution]]
