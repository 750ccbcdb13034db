"""Findings: what was found out about an embedding on one topic, for panels, pages, files and studies alike."""

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..evaluation.segment_groups import Grouping
from ..evaluation.weak_spots import WeakSpotSettings
from ..progress import Progress
from .drawing import Drawing
from .floor_chart import FloorScene
from .page import Section
from .quantity import Quantity
from .table import EMPTY, Table


@dataclass(frozen=True)
class Goal:
    """A place, or something to do, that it should not take long to get to.

    Attributes
    ----------
    name : str
        As it stands in a sentence: "the door".
    nodes : NodeSet
        A set of the embedding's network; see :mod:`core.evaluation.goals`.
    """

    name: str
    nodes: NodeSet


@dataclass(frozen=True)
class Questions:
    """Settings of all topics; each heeds a few of them.

    Attributes
    ----------
    thorough : bool
        Look at single segments, at every motion that might be captured, and at many places; otherwise at fewer.
    goal : Goal, optional
    obstacles : (4 nx, 4 ny) bool array, optional
        Samples on which something stands; without it maps show only what is too near an obstacle.
    seed, n_pairs : int
        Of the pairs of places that are drawn for path efficiency.
    allowed_loss : float
        Share of the covered floor that deleting clips together may cost.
    parts : Grouping
        What is taken away at a time.
    weak_spots : WeakSpotSettings, optional
        Without it a place is weak by comparison with the others.
    n_candidates : int, optional
        Motions that are tried; without it as many as ``thorough`` says.
    """

    thorough: bool = True
    goal: Goal | None = None
    obstacles: np.ndarray | None = None
    seed: int = 0
    n_pairs: int = 100
    allowed_loss: float = 0.01
    parts: Grouping = Grouping.CLIP
    weak_spots: WeakSpotSettings | None = None
    n_candidates: int | None = None

    def floor_scene(self, embedding: Embedding) -> FloorScene:
        """Return what all maps of the embedding share."""
        return FloorScene(embedding.environment, self.obstacles, embedding.unrolling.sweep.classes)


@dataclass(frozen=True)
class Contribution:
    """The part of one topic in a report.

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


@dataclass(frozen=True)
class Row:
    """A line of a list.

    Attributes
    ----------
    name, value, note : str
        Its three columns.
    sentence : str
        Said when the line is chosen.
    sign : str
        A word for what the line is about, or how grave it is, to be shown as an icon: "clip", "essential".
    place : (x, y) in metres, or None
    size : float
        Metres across of what is at the place.
    """

    name: str
    value: str = ""
    note: str = ""
    sentence: str = ""
    sign: str = ""
    place: tuple[float, float] | None = None
    size: float = 0.0


@dataclass(frozen=True)
class Finding:
    """Answer of an embedding to the question of one topic.

    Attributes
    ----------
    topic : Topic
    embedding : Embedding
    table : Table
        All numbers.
    numbers : tuple of (name, text)
        The most important ones, with units, for a panel.
    rows : tuple of Row
        For a list.
    sentences : tuple of str
    summary : str
        One line without a full stop; the first sentence if it is empty.
    contribute : callable, optional
        Draws and writes the topic's part of a report. Panels do without it, because maps of large grounds take long.
    also : tuple of Finding
        On other topics, found out at the same time.
    """

    topic: "Topic"
    embedding: Embedding
    table: Table = EMPTY
    numbers: tuple[tuple[str, str], ...] = ()
    rows: tuple[Row, ...] = ()
    sentences: tuple[str, ...] = ()
    summary: str = ""
    contribute: Callable[[], Contribution] | None = None
    also: tuple["Finding", ...] = ()

    def summarised(self) -> str:
        """Return the line for a status bar."""
        return self.summary or self.sentences[0].rstrip(".")


FindSteps = Callable[[Embedding, Questions], Generator[Progress, None, Finding]]


@dataclass(frozen=True, eq=False)
class Topic:
    """Something to be found out about an embedding.

    Panels, operators, reports, exports and studies are made from these entries alone.

    Attributes
    ----------
    name : str
        Of the finding, where it is kept, and in lower case of its files.
    title : str
    find : callable, optional
        ``(embedding, questions)``, a generator that yields progress and returns a :class:`Finding`. None for what is
        found along with another topic.
    operator, button, help : str
        Name of the operator that finds it out, its label and what it says about itself; without a name a report alone
        asks for it.
    part : str
        Name of its part of the panel, if that is not the title.
    settings : tuple of str
        Those of the evaluation that it heeds, by their names in the scene.
    columns : str
        Heading of its list.
    of_whole : bool
        It is about the embedding before that was pruned.
    of_empty : bool
        It can be asked of an embedding without nodes.
    chart : callable, optional
        Draws a table that has rows.
    section : str
        Its key in a report; empty if it has no section there.
    effort : float
        About how long its section takes compared to the others.
    quantities : mapping of str to Quantity
        Numbers that studies can measure, by name.
    """

    name: str
    title: str
    find: FindSteps | None = None
    operator: str = ""
    button: str = ""
    help: str = ""
    part: str = ""
    settings: tuple[str, ...] = ()
    columns: str = ""
    of_whole: bool = False
    of_empty: bool = False
    chart: Callable[[Table], Drawing] | None = None
    section: str = ""
    effort: float = 1.0
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
