"""A problem in a folder: what every worker has to know, and what each keeps at hand."""

import json
import shutil
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from ..embedding.embedding import EmbeddingSettings
from ..embedding.footprint import FootprintRule, FootprintSettings
from ..embedding.network import StepNetwork
from ..embedding.node_set import NodeSet
from ..embedding.stencil import build_stencils
from ..embedding.sweep import Sweep, sweep_steps
from ..embedding.unroll import Unrolling, unroll_steps
from ..environment.environment import Environment
from ..environment.grid import Grid
from ..environment.regions import RegionMask, RegionRule
from ..errors import EmbeddingError
from ..files import from_json, map_array, read_regular, write_whole
from ..motion.graph import MotionGraph
from ..motion.graph_archive import load_motion_graph, save_motion_graph
from ..progress import finish
from .plan import ParcelPlan, plan_parcels
from .set_file import read_set, write_set

_FORMAT = "wayfarer parcels 1"


@dataclass(frozen=True)
class Problem:
    """A motion graph, a ground and how it is cut, as they lie in ``folder``; sets of nodes lie in ``folder/sets``."""

    folder: Path
    graph: MotionGraph
    environment: Environment
    settings: EmbeddingSettings
    plan: ParcelPlan

    @cached_property
    def sweep(self) -> Sweep:
        """The same for all parcels: no path depends on where it starts."""
        return _sweep(self.graph, self.plan.frame, self.environment.tags, self.settings)

    def network(self, index: int) -> StepNetwork:
        """Return the links that start in a parcel; they end in it or in its halo."""
        own = self.own(index)
        unrolling = finish(unroll_steps(self.sweep, self.plan.crop(self.environment, index)))
        valid = tuple(plane & own for plane in unrolling.valid)
        return StepNetwork(Unrolling(self.sweep, valid), self.graph.links, len(self.graph.segments))

    def own(self, index: int) -> int:
        """Return the plane of a parcel's own cells."""
        return self.sweep.layout.pack(self.plan.own_cells(index))

    def set_path(self, name: str, index: int) -> Path:
        return self.folder / "sets" / name / f"{index}.set"

    def message_path(self, name: str, sender: int, place: int) -> Path:
        """Return the file of the message of a parcel to its neighbour number ``place``."""
        return self.folder / "messages" / name / f"{sender}-{place}.set"

    def everywhere(self, plane: int) -> NodeSet:
        """Return the set of all nodes on the cells of a plane."""
        return NodeSet((plane,) * (len(self.graph.segments) * self.plan.grid.shape[2]))

    def read(self, name: str, index: int) -> NodeSet:
        """Read a set in a parcel, its own cells only."""
        return self.read_file(self.set_path(name, index))

    def read_file(self, path: Path) -> NodeSet:
        """Read a set in a file; EmbeddingError if it is none of this problem."""
        return read_set(path, len(self.graph.segments) * self.plan.grid.shape[2], self.sweep.layout.n_bytes)

    def union_of_files(self, paths: Sequence[str], nodes: NodeSet) -> NodeSet:
        """Return the union of a set with those in some files."""
        for path in paths:
            nodes = nodes | self.read_file(Path(path))
        return nodes

    def write(self, name: str, index: int, nodes: NodeSet, lasting: bool = False) -> None:
        write_set(self.set_path(name, index), nodes, self.sweep.layout.n_bytes, lasting)

    def send(self, name: str, sender: int, nodes: NodeSet, to_own: bool) -> dict[int, tuple[int, str]]:
        """Send all neighbours what concerns them: what of the nodes lies in their own cells, or in all their frame.

        Returns {number of the neighbour: (its parcel, path of the file)} of those that are sent anything.
        """
        layout, sent = self.sweep.layout, {}
        for place, neighbour in enumerate(self.plan.neighbours[sender]):
            seen, move = self._seen(sender, place, to_own), layout.shift(neighbour.dx, neighbour.dy)
            moved = []
            for plane in nodes.planes:
                part = plane & seen
                moved.append(part << move if move >= 0 else part >> -move)
            if any(moved):
                path = self.message_path(name, sender, place)
                write_set(path, NodeSet(tuple(moved)), self.sweep.layout.n_bytes)
                sent[place] = (neighbour.index, str(path))
        return sent

    def _seen(self, sender: int, place: int, to_own: bool) -> int:
        """Return the plane of the sender's cells that are the neighbour's own, or in the neighbour's frame."""
        nx, ny, _ = self.plan.frame.shape
        neighbour = self.plan.neighbours[sender][place]
        x, y = np.arange(nx) + neighbour.dx, np.arange(ny) + neighbour.dy
        if to_own:
            there, first = self.plan.parcels[neighbour.index], (self.plan.halo_x, self.plan.halo_y)
            in_x = (x >= first[0]) & (x < first[0] + there.nx)
            in_y = (y >= first[1]) & (y < first[1] + there.ny)
        else:
            in_x, in_y = (x >= 0) & (x < nx), (y >= 0) & (y < ny)
        return self.sweep.layout.pack(np.logical_and.outer(in_x, in_y))


def _sweep(graph: MotionGraph, frame: Grid, tags: frozenset[str], settings: EmbeddingSettings) -> Sweep:
    stencils = build_stencils(graph.segments, frame, settings.footprint)
    return finish(sweep_steps(graph.segments, stencils, frame, tags))


def create_problem(
    folder: Path, graph: MotionGraph, environment: Environment, settings: EmbeddingSettings, parcel_size: float
) -> Problem:
    """Lay out a problem in a folder that all workers can read and write.

    Parameters
    ----------
    parcel_size : float
        Metres; the sides of the parcels are at least that.

    Raises
    ------
    EmbeddingError
        The graph is empty, the parcels are too small for its steps, or the folder cannot be written.
    """
    if not graph.segments:
        raise EmbeddingError("The motion graph has no segments; build it from clips that connect.")
    grid = environment.grid
    small = _sweep(graph, Grid((1, 1, grid.shape[2]), grid.cell_size), environment.tags, settings)
    halo_x, halo_y = max(small.layout.reach_x, 1), max(small.layout.reach_y, 1)
    if grid.tiled and (grid.shape[0] < halo_x or grid.shape[1] < halo_y):
        raise EmbeddingError("The tile is smaller than the longest step; leave --parcels out.")
    parcel_cells = max(int(parcel_size / grid.cell_size), 1)
    plan_parcels(grid, halo_x, halo_y, parcel_cells)
    if (folder / "problem.json").exists():
        raise EmbeddingError(f"'{folder}' holds a large ground already; choose another folder, or delete it.")
    if folder.is_symlink() or (folder.exists() and any(folder.iterdir())):
        raise EmbeddingError(f"'{folder}' is in the way; move it away, or choose another folder.")
    footprint = settings.footprint
    header = {
        "format": _FORMAT,
        "shape": list(grid.shape),
        "cell_size": grid.cell_size,
        "origin": list(grid.origin),
        "tiled": grid.tiled,
        "regions": [[region.name, region.rule.name, region.tag] for region in environment.regions],
        "footprint": {**vars(footprint), "rule": footprint.rule.name},
        "halo": [halo_x, halo_y],
        "parcel_cells": parcel_cells,
    }
    # Another name until all of it is there: whatever stands in the folder then is ours.
    making = folder.with_name(f".making-{uuid.uuid4().hex}")
    try:
        making.mkdir(parents=True)
        save_motion_graph(graph, making / "graph.npz")
        np.save(making / "blocked.npy", environment.blocked)
        for i, region in enumerate(environment.regions):
            np.save(making / f"region-{i}.npy", region.mask)
        write_whole(making / "problem.json", json.dumps(header).encode())
        if folder.exists():
            folder.rmdir()
        making.rename(folder)
    finally:
        shutil.rmtree(making, ignore_errors=True)
    return open_problem(str(folder))


@lru_cache(maxsize=1)
def open_problem(folder: str) -> Problem:
    """Return the problem in a folder; large masks stay on the disk until a parcel is cut out of them.

    Raises EmbeddingError if the folder holds none.
    """
    path = Path(folder)
    try:
        header = from_json(read_regular(path / "problem.json"))
        if header["format"] != _FORMAT:
            raise ValueError
        grid = Grid(tuple(header["shape"]), header["cell_size"], tuple(header["origin"]), header["tiled"])
        footprint = {**header["footprint"], "rule": FootprintRule[header["footprint"]["rule"]]}
        regions = tuple(
            RegionMask(name, RegionRule[rule], tag, map_array(path / f"region-{i}.npy"))
            for i, (name, rule, tag) in enumerate(header["regions"])
        )
        environment = Environment(grid, map_array(path / "blocked.npy"), regions)
        halo_x, halo_y = header["halo"]
        plan = plan_parcels(grid, halo_x, halo_y, header["parcel_cells"])
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError) as error:
        raise EmbeddingError(
            f"'{folder}' holds no large ground that this version can read; lay it out anew in an empty folder."
        ) from error
    graph = load_motion_graph(path / "graph.npz")
    return Problem(path, graph, environment, EmbeddingSettings(FootprintSettings(**footprint)), plan)


@lru_cache(maxsize=2)
def open_network(folder: str, index: int) -> StepNetwork:
    """Return the links of a parcel, kept by the worker that made them: the next task is often about the same one."""
    return open_problem(folder).network(index)
