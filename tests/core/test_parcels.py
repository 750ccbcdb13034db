"""Grounds embedded in parcels: equal to the embedding in one piece, to the last node and link."""

import json
import tempfile
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, reject, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.node_set import NodeSet
from core.environment.environment import Environment
from core.environment.grid import SUBDIVISION, Grid
from core.environment.regions import RegionMask, RegionRule
from core.errors import EmbeddingError
from core.evaluation.floor import floor_cells
from core.evaluation.variability import floor_variability
from core.parcels.embedding import MAPS, NODES, embed_parcels_steps
from core.parcels.problem import create_problem, open_problem
from core.parcels.set_file import read_set, write_set
from core.parcels.work import Serial
from core.progress import finish

from .motion_graphs import recorded_graph
from .reference import random_problem


def larger_problem(seed, tiled):
    """A random problem on a ground of several parcels, with obstacles that leave many components or few."""
    rng = np.random.default_rng(seed)
    graph, environment = random_problem(seed, tiled)
    shape = (*rng.integers(12, 30, 2).tolist(), environment.grid.n_headings)
    grid = replace(environment.grid, shape=shape)
    size = (shape[0] * SUBDIVISION, shape[1] * SUBDIVISION)
    coarse = rng.random((shape[0], shape[1])) < rng.choice([0.0, 0.1, 0.4])
    blocked = np.kron(coarse, np.ones((SUBDIVISION, SUBDIVISION))).astype(bool)
    if rng.random() < 0.3:  # a wall across, so that there are two of everything
        blocked[rng.integers(size[0])] = True
    regions = tuple(
        RegionMask(r.name, r.rule, r.tag, np.kron(rng.random(shape[:2]) < 0.2, np.ones((4, 4))).astype(bool))
        for r in environment.regions
    )
    return graph, Environment(grid, blocked, regions)


def assembled(folder, whole):
    """The planes of the set of nodes of the whole ground, put together from the parcels."""
    problem = open_problem(str(folder))
    plan, layout = problem.plan, problem.sweep.layout
    nx, ny, n_headings, n_segments = whole.shape
    mask = np.zeros((n_segments * n_headings, nx, ny), dtype=bool)
    for index, parcel in enumerate(plan.parcels):
        own = np.s_[plan.halo_x : plan.halo_x + parcel.nx, plan.halo_y : plan.halo_y + parcel.ny]
        there = np.s_[parcel.x0 : parcel.x0 + parcel.nx, parcel.y0 : parcel.y0 + parcel.ny]
        for i, plane in enumerate(problem.read(NODES, index).planes):
            mask[i][there] = layout.unpack(plane)[own]
    return mask.reshape(n_segments, n_headings, nx, ny).transpose(2, 3, 1, 0)


def assembled_map(folder, name, shape):
    found = np.zeros(shape, dtype=np.int64)
    for path in (folder / MAPS).glob("*.npz"):
        part = np.load(path)
        x, y = part["corner"]
        found[x : x + part[name].shape[0], y : y + part[name].shape[1]] = part[name]
    return found


@settings(max_examples=6)
@example(4, True, 0)  # everything by closures, nothing written out
@example(6, False, 20)  # what is left over is searched by closures first, then written out
@given(st.integers(0, 10**6), st.booleans(), st.just(10**6))
def test_parcels_agree_with_the_whole(seed, tiled, explicit_links):
    graph, environment = larger_problem(seed, tiled)
    options = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))
    whole = embed(graph, environment, options)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        try:
            create_problem(folder, graph, environment, options, parcel_size=8 * environment.grid.cell_size)
        except EmbeddingError:
            reject()  # a step longer than a parcel
        found = finish(embed_parcels_steps(folder, explicit_links=explicit_links))
        assert np.array_equal(assembled(folder, whole), whole.node_mask())
        assert (found.n_nodes, found.n_links) == (whole.n_nodes, whole.n_links)
        covered = whole.covered()
        assert np.array_equal(assembled_map(folder, "coverage", covered.shape[:2]), covered.sum(axis=2))
        assert np.array_equal(assembled_map(folder, "variability", covered.shape[:2]), floor_variability(whole))
        free = floor_cells(whole)
        assert found.free_cells == free.sum()
        assert found.covered_cells == np.count_nonzero(covered.any(axis=2))


def test_random_grounds_are_cut_into_several_parcels_and_mostly_not_empty():
    n_parcels, n_nodes = [], []
    for seed in range(30):
        graph, environment = larger_problem(seed, seed % 2 == 0)
        with tempfile.TemporaryDirectory() as name:
            try:
                problem = create_problem(
                    Path(name), graph, environment, EmbeddingSettings(), 8 * environment.grid.cell_size
                )
            except EmbeddingError:
                continue
            n_parcels.append(len(problem.plan.parcels))
            n_nodes.append(embed(graph, environment).n_nodes)
    assert len(n_parcels) > 15 and np.median(n_parcels) >= 4 and np.count_nonzero(n_nodes) > 8


def small_ground(folder):
    """A problem of four parcels that has an embedding, laid out in a folder."""
    graph, environment = larger_problem(1, True)
    options = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))
    create_problem(folder, graph, environment, options, 8 * environment.grid.cell_size)
    return embed(graph, environment, options)


class Failing(Serial):
    """Loses every task after the first few, as a machine that is switched off does."""

    def __init__(self, n_tasks):
        self.left = n_tasks

    def submit(self, fn, /, *args, **kwargs):
        self.left -= 1
        if self.left < 0:
            future = Future()
            future.set_exception(ConnectionError("the worker is gone"))
            return future
        return super().submit(fn, *args, **kwargs)


def test_what_was_stopped_goes_on_and_ends_with_the_same(tmp_path):
    whole = small_ground(tmp_path)
    n_runs = 0
    while True:
        n_runs += 1
        try:
            found = finish(embed_parcels_steps(tmp_path, Failing(5 * n_runs)))
        except ConnectionError:
            continue
        break
    assert n_runs > 3
    assert (found.n_nodes, found.n_links) == (whole.n_nodes, whole.n_links)
    assert np.array_equal(assembled(tmp_path, whole), whole.node_mask())


def test_finished_work_is_not_done_again(tmp_path):
    small_ground(tmp_path)
    first = finish(embed_parcels_steps(tmp_path))
    assert finish(embed_parcels_steps(tmp_path, Failing(0))) == first


def test_cancelling_is_possible_at_every_step(tmp_path):
    whole = small_ground(tmp_path)
    for n_steps in (1, 5, 9):
        steps = embed_parcels_steps(tmp_path)
        for _ in range(n_steps):
            progress = next(steps)
            assert 0 <= progress.fraction <= 1
        steps.close()
    assert finish(embed_parcels_steps(tmp_path)).n_nodes == whole.n_nodes


def test_damaged_and_missing_files_are_named(tmp_path):
    small_ground(tmp_path)
    finish(embed_parcels_steps(tmp_path))
    (tmp_path / "journal.json").write_text(json.dumps({"done": True}))
    victim = tmp_path / "sets" / NODES / "2.set"
    raw = bytearray(victim.read_bytes())
    raw[-3] ^= 1
    victim.write_bytes(raw)
    with pytest.raises(EmbeddingError, match=r"2\.set' is damaged"):
        finish(embed_parcels_steps(tmp_path))
    victim.unlink()
    with pytest.raises(EmbeddingError, match=r"2\.set' cannot be read"):
        finish(embed_parcels_steps(tmp_path))
    open_problem.cache_clear()
    (tmp_path / "problem.json").write_text("{}")
    with pytest.raises(EmbeddingError, match="no large ground"):
        finish(embed_parcels_steps(tmp_path))


@given(st.lists(st.integers(0, 2**40 - 1), max_size=5))
def test_sets_are_read_back(planes):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a" / "0.set"
        write_set(path, NodeSet(tuple(planes)), 5)
        assert read_set(path, len(planes), 5) == NodeSet(tuple(planes))
        assert [p.name for p in path.parent.iterdir()] == ["0.set"]


def test_refuses_parcels_shorter_than_a_step(tmp_path):
    graph, environment = larger_problem(1, True)
    with pytest.raises(EmbeddingError, match="longest step"):
        create_problem(tmp_path, graph, environment, EmbeddingSettings(), environment.grid.cell_size)
    tiny = Environment(Grid((1, 30, 4), 0.05, tiled=True), np.zeros((4, 120), dtype=bool))
    with pytest.raises(EmbeddingError, match="tile is smaller"):
        create_problem(tmp_path, graph, tiny, EmbeddingSettings(), 5.0)


def test_a_folder_holds_one_ground_only(tmp_path):
    small_ground(tmp_path)
    with pytest.raises(EmbeddingError, match="holds a large ground already"):
        small_ground(tmp_path)


@pytest.mark.parametrize("tiled", [False, True])
def test_recorded_motion_with_regions(data_folder, tmp_path, tiled):
    """24 x 24 m with pillars, a strip that asks for a tag, a forbidden and a confining region: the same nodes."""
    graph, rng = recorded_graph(data_folder), np.random.default_rng(7)
    tagged = [replace(s, tags={"low": np.full(s.n_frames, rng.random() < 0.2)}) for s in graph.segments]
    graph = replace(graph, segments=tuple(tagged))
    grid = Grid.over_rectangle((0, 0), (24, 24), 0.2, 12, tiled=tiled)
    n = grid.shape[0] * SUBDIVISION
    blocked = np.zeros((n, n), dtype=bool)
    for x, y in rng.integers(0, n - 16, (20, 2)):
        blocked[x : x + 16, y : y + 10] = True
    strip, forbidden, confined = (np.zeros((n, n), dtype=bool) for _ in range(3))
    strip[:, n // 2 : n // 2 + 6], forbidden[: n // 3, : n // 4], confined[n // 5 :] = True, True, True
    environment = Environment(
        grid,
        blocked,
        (
            RegionMask("strip", RegionRule.REQUIRE, "low", strip),
            RegionMask("lawn", RegionRule.FORBID, "low", forbidden),
            RegionMask("yard", RegionRule.CONFINE, "low", confined),
        ),
    )
    whole = embed(graph, environment)
    create_problem(tmp_path, graph, environment, EmbeddingSettings(), 8.0)
    found = finish(embed_parcels_steps(tmp_path))
    assert whole.n_nodes > 1_000_000 and found.n_parcels >= 9
    assert (found.n_nodes, found.n_links) == (whole.n_nodes, whole.n_links)
    assert np.array_equal(assembled(tmp_path, whole), whole.node_mask())
