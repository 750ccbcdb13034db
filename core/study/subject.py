"""Subjects of measures: an embedding in one piece, or the maps and counts of a ground in parcels."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..embedding.embedding import Embedding
from ..errors import StudyError
from ..evaluation.floor import floor_cells
from ..evaluation.variability import floor_variability
from ..files import read_arrays
from ..motion.graph import MotionGraph
from ..parcels.embedding import MAPS, ParcelSummary
from ..parcels.problem import Problem

Found = TypeVar("Found")


class Subject(ABC):
    """Maps and counts that every measure may ask for."""

    graph: MotionGraph
    cell_size: float

    @property
    @abstractmethod
    def n_nodes(self) -> int: ...

    @property
    @abstractmethod
    def n_links(self) -> int: ...

    @cached_property
    @abstractmethod
    def ways(self) -> np.ndarray:
        """(nx, ny) int64: variability summed over headings; 0 where nothing passes."""

    @cached_property
    @abstractmethod
    def headings(self) -> np.ndarray:
        """(nx, ny) int: headings in which a cell can be passed."""

    @cached_property
    @abstractmethod
    def free(self) -> np.ndarray:
        """(nx, ny) bool: the free floor (:func:`..evaluation.floor.floor_cells`)."""

    @cached_property
    @abstractmethod
    def ruled(self) -> np.ndarray:
        """(nx, ny) bool: where nothing stands, but a region's rule takes the cell from the free floor: it can only be
        crossed."""

    @property
    @abstractmethod
    def n_headings(self) -> int: ...

    @cached_property
    def covered(self) -> np.ndarray:
        """(nx, ny) bool: cells that can be passed; all of them are on the free floor."""
        return self.headings > 0


class WholeGround(Subject):
    """An embedding."""

    def __init__(self, embedding: Embedding):
        self.embedding = embedding
        self.graph = embedding.graph
        self.cell_size = embedding.environment.grid.cell_size
        self._kept: dict[tuple[Callable, str], Any] = {}

    def once(self, evaluate: Callable[[Embedding, Mapping[str, Any]], Found], options: Mapping[str, Any]) -> Found:
        """Evaluate the embedding, once for all measures with the same options."""
        key = evaluate, str(sorted(options.items()))
        if key not in self._kept:
            self._kept[key] = evaluate(self.embedding, options)
        return self._kept[key]

    @property
    def n_nodes(self) -> int:
        return self.embedding.n_nodes

    @property
    def n_links(self) -> int:
        return self.embedding.n_links

    @cached_property
    def ways(self) -> np.ndarray:
        return floor_variability(self.embedding)

    @cached_property
    def headings(self) -> np.ndarray:
        return self.embedding.covered().sum(axis=2)

    @cached_property
    def free(self) -> np.ndarray:
        return floor_cells(self.embedding)

    @cached_property
    def ruled(self) -> np.ndarray:
        return self.embedding.environment.free_cells() & ~self.free

    @property
    def n_headings(self) -> int:
        return self.embedding.shape[2]


class ParcelledGround(Subject):
    """A ground that was embedded in parcels; its maps are put together from those of the parcels."""

    def __init__(self, problem: Problem, summary: ParcelSummary):
        self.graph = problem.graph
        self._environment = problem.environment
        self.cell_size = problem.plan.grid.cell_size
        self._shape = problem.plan.grid.shape
        self._folder = problem.folder / MAPS
        self._summary = summary

    @property
    def n_nodes(self) -> int:
        return self._summary.n_nodes

    @property
    def n_links(self) -> int:
        return self._summary.n_links

    @cached_property
    def ways(self) -> np.ndarray:
        return self._assembled("variability", np.int64)

    @cached_property
    def headings(self) -> np.ndarray:
        return self._assembled("coverage", np.uint16)

    @cached_property
    def free(self) -> np.ndarray:
        return self._assembled("free", bool)

    @cached_property
    def ruled(self) -> np.ndarray:
        return self._environment.free_cells() & ~self.free

    @property
    def n_headings(self) -> int:
        return self._shape[2]

    def _assembled(self, name: str, kind: type) -> np.ndarray:
        whole = np.zeros(self._shape[:2], dtype=kind)
        for index in range(self._summary.n_parcels):
            path = Path(self._folder) / f"{index}.npz"
            try:
                maps = read_arrays(path)
                (x, y), part = maps["corner"], maps[name]
                whole[x : x + part.shape[0], y : y + part.shape[1]] = part
            except (OSError, ValueError, LookupError, TypeError) as error:
                raise StudyError(f"'{path}' is damaged; delete the folder 'large', and start again.") from error
        return whole
