"""Studies: every case is what doing it by hand gives, and nothing is lost whatever fails."""

import json
import resource
import subprocess
import sys
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintRule, FootprintSettings
from core.environment.environment import EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.environment.regions import RegionRule
from core.errors import StudyError
from core.evaluation.path_efficiency import path_efficiency
from core.evaluation.variability import coverage_share, floor_variability
from core.expanse.work import Serial
from core.motion.graph import MotionGraphSettings, build_motion_graph
from core.progress import finish
from core.study.case import run_case
from core.study.clip_set import ClipSet, load_clip_set, save_clip_set
from core.study.geometry import SceneGeometry, load_scene, save_scene
from core.study.measures import QUANTITIES, Measure, measured
from core.study.picture import LONGEST_SIDE, small_map
from core.study.plan import plan_of, read_plan
from core.study.report import study_page
from core.study.results import failures, results_table
from core.study.run import run_study, run_study_steps
from core.study.settings import SETTINGS
from core.study.subject import WholeGround
from core.tuning.local_pruning import prune_local

from .studies import few_clips, lay_out, plan, region, room, rows_of, small_graph

ROOT = Path(__file__).resolve().parents[2]


# ------------------------------------------------------------------------------------------------------- cases


@settings(max_examples=8)
@given(
    st.floats(0.05, 0.4),
    st.sampled_from([0.25, 0.3]),
    st.sampled_from([6, 8]),
    st.floats(0.0, 0.2),
    st.sampled_from([0, 1, 3]),
    st.booleans(),
)
def test_a_case_is_what_doing_it_by_hand_gives(radius, cell_size, n_headings, rate, k, conservative):
    geometry = room(regions=[region(RegionRule.REQUIRE, "walk")])
    rule = FootprintRule.CONSERVATIVE if conservative else FootprintRule.SNAP
    values = {
        "radius": radius,
        "cell_size": cell_size,
        "n_headings": n_headings,
        "position_rate": rate,
        "footprint_rule": rule.value,
        "k": k,
    }
    names = ["nodes", "links", "coverage", "total_variability"]
    found = run_case(geometry, small_graph(), values, [Measure(n, n) for n in names])

    grid = Grid.over_rectangle(geometry.low, geometry.high, cell_size, n_headings)
    environment = build_environment(grid, geometry.obstacles, geometry.regions, EnvironmentSettings(radius=radius))
    footprint = FootprintSettings(position_rate=rate, rule=rule)
    embedding = embed(small_graph(), environment, EmbeddingSettings(footprint))
    if k:
        embedding = prune_local(embedding, k)
    ways = floor_variability(embedding)
    assert list(found.numbers.values()) == [
        embedding.n_nodes,
        embedding.n_links,
        coverage_share(embedding),
        ways.sum(),
    ]
    levels = found.picture.levels
    assert np.array_equal(np.isnan(levels), ~environment.free_cells() & (ways == 0))
    assert np.array_equal(levels >= 0, ways > 0)
    assert np.allclose(10.0 ** levels[ways > 0], ways[ways > 0], rtol=1e-5)


def test_every_quantity_has_a_number():
    embedding = embed(small_graph(), build_environment(Grid((16, 16, 8), 0.25), np.empty((0, 3, 3))))
    ground = WholeGround(embedding)
    place = embedding.environment.grid.positions(np.argwhere(ground.covered)[0]).tolist()
    options = {"time_to_reach": {"position": place}, "worst_time_to_reach": {"position": place}}
    small = {"pairs": 8, "goals": 2}
    found = {}
    for name, quantity in QUANTITIES.items():
        given = options.get(name, small if "pairs" in quantity.options else {})
        found[name] = measured(Measure(name, name, given), ground)
        assert np.isfinite(found[name]), name
    assert found["nodes"] == embedding.n_nodes and found["segments"] == len(small_graph().segments)
    by_hand = path_efficiency(embedding, np.random.default_rng(0), 8, 2)
    assert found["path_efficiency"] == by_hand.mean and found["worst_path_efficiency"] == by_hand.efficiency.min()
    assert 0 < found["least_action_coverage"] <= found["action_coverage"] <= 1
    assert 0 < found["time_to_reach"] < found["worst_time_to_reach"]
    assert found["full_area"] <= found["covered_area"] <= found["free_area"] == pytest.approx(16.0)


def test_thresholds_make_graphs(tmp_path):
    lay_out(tmp_path)
    study = plan(
        tmp_path,
        clips={"clips": "clips.npz", "ready": "graph.npz"},
        scenes={"open": "open.npz"},
        settings={"max_cost": [0.1, 0.3], "radius": 0.2},
        measures=["segments", "transitions", "nodes"],
    )
    outcome = run_study(study, tmp_path / "out")
    # A graph that is there already has no threshold.
    assert [entry.case.clips for entry in outcome.outcomes] == ["clips", "clips", "ready"]
    for entry, cost in zip(outcome.outcomes, (0.1, 0.3), strict=False):
        graph = build_motion_graph(few_clips(), MotionGraphSettings(max_cost=cost))
        assert entry.result is not None
        assert list(entry.result.numbers.values())[:2] == [len(graph.segments), len(graph.links)]
    assert results_table(outcome).records()[2]["max_cost"] is None


# --------------------------------------------------------------------------------------------- running, resuming


def test_processes_find_the_same(tmp_path):
    study = lay_out(tmp_path, settings={"radius": [0.2, 0.3], "k": ["all", 2]})
    here = run_study(study, tmp_path / "a")
    with ProcessPoolExecutor(2, get_context("spawn")) as executor:
        there = run_study(study, tmp_path / "b", executor)
    assert rows_of(here) == rows_of(there)
    assert len(here.outcomes) == 8 and here.n_failed == 0
    for entry in here.outcomes:
        geometry = load_scene(tmp_path / f"{entry.case.scene}.npz")
        by_hand = run_case(geometry, small_graph(), entry.case.values, study.measures)
        assert entry.result.numbers == by_hand.numbers


class Failing(Serial):
    """Does a few tasks, then loses every other one."""

    def __init__(self, n_tasks, error):
        self.left, self.error = n_tasks, error

    def submit(self, fn, /, *args, **kwargs):
        self.left -= 1
        if self.left >= 0:
            return super().submit(fn, *args, **kwargs)
        future = Future()
        if self.error is None:
            future.cancel()
            future.set_running_or_notify_cancel()
        else:
            future.set_exception(self.error)
        return future


def test_what_was_stopped_goes_on(tmp_path):
    study = lay_out(tmp_path)
    whole = run_study(study, tmp_path / "whole")
    out = tmp_path / "out"
    for n_known in range(3):
        with pytest.raises(StudyError, match="workers are gone"):
            run_study(study, out, Failing(1, None))
        assert len(list((out / "cases").glob("*.json"))) == n_known + 1
    last = run_study(study, out, Failing(1, None))
    assert last.n_known == 3
    again = run_study(study, out, Failing(0, None))
    assert again.n_known == 4
    assert rows_of(again) == rows_of(whole)


def test_only_what_is_new_is_run(tmp_path):
    run_study(lay_out(tmp_path), tmp_path / "out")
    more = plan(tmp_path, settings={"radius": [0.2, 0.25, 0.3]})
    assert run_study(more, tmp_path / "out").n_known == 4
    save_scene(room(pillar=(0.5, 0.5)), tmp_path / "open.npz")
    moved = run_study(more, tmp_path / "out")
    assert moved.n_known == 3
    # What is damaged is run again, too.
    victim = sorted((tmp_path / "out" / "cases").glob("*.json"))[0]
    victim.write_text(victim.read_text()[:-20])
    again = run_study(more, tmp_path / "out")
    assert again.n_known in (5, 6) and again.n_failed == 0
    assert rows_of(again) == rows_of(moved)


def test_stopping_is_possible_at_every_step(tmp_path):
    study = lay_out(tmp_path)
    for n_steps in (1, 2, 3):
        steps = run_study_steps(study, tmp_path / "out")
        for _ in range(n_steps):
            assert 0 <= next(steps).fraction <= 1
        steps.close()
    assert run_study(study, tmp_path / "out").n_failed == 0


def test_a_worker_that_dies_costs_its_case_only(tmp_path):
    study = lay_out(tmp_path)
    outcome = run_study(study, tmp_path / "out", Failing(3, RuntimeError("killed, as too large")))
    assert outcome.n_failed == 1
    assert "RuntimeError (killed, as too large)" in failures(outcome)[0]
    # A fault is tried again with the next start.
    assert run_study(study, tmp_path / "out").n_known == 3


def test_poisoned_input_is_reported_and_the_rest_goes_on(tmp_path):
    lay_out(tmp_path)
    (tmp_path / "torn.npz").write_bytes((tmp_path / "door.npz").read_bytes()[:-30])
    save_scene(replace(room(), high=(0.1, 0.1)), tmp_path / "speck.npz")
    obstacles = room().obstacles.copy()
    obstacles[3, 1, 0] = np.nan
    save_scene(replace(room(), obstacles=obstacles), tmp_path / "nowhere.npz")
    save_clip_set(ClipSet(few_clips(), MotionGraphSettings(max_cost=1e-6)), tmp_path / "apart.npz")
    names = ["open", "torn", "speck", "nowhere", "missing"]
    study = plan(
        tmp_path,
        scenes={name: f"{name}.npz" for name in names},
        clips={"graph": "graph.npz", "apart": "apart.npz", "scene": "open.npz"},
        settings={},
        measures=["nodes", {"measure": "time_to_reach", "region": "door"}],
    )
    outcome = run_study(study, tmp_path / "out")
    problem = {(e.case.scene, e.case.clips): e.problem for e in outcome.outcomes}
    assert outcome.n_failed == len(outcome.outcomes) - 1 and problem["open", "graph"] == ""
    assert "damaged" in problem["torn", "graph"]
    assert "smaller than one cell" in problem["speck", "graph"]
    assert "not a number" in problem["nowhere", "graph"]
    assert "missing.npz' cannot be read" in problem["missing", "graph"]
    assert "Nothing connects" in problem["open", "apart"]
    assert "no clip set" in problem["open", "scene"]
    # A question without an answer is no failure.
    record = next(r for r in results_table(outcome).records() if (r["scene"], r["clips"]) == ("open", "graph"))
    assert record["nodes"] > 0 and record["time_to_reach (s)"] is None
    assert "no region 'door'" in record["problem"]
    page = study_page(outcome)
    assert "What failed" in page and "smaller than one cell" in page and page.count("<svg") >= 3


def cluster_program(file, *words, limit=None, first="pass"):
    """The program that runs studies, where no file may become larger than ``limit`` bytes: as on a full disk.

    ``first`` is Python that is run before it.
    """

    def confine():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    # A second to wait for schedulers: there is none.
    code = f"import sys; {first}; sys.path.insert(0, sys.argv[1]); import cluster; cluster._PATIENCE = 1; "
    code += "sys.exit(cluster.main(sys.argv[2:]))"
    command = [sys.executable, "-c", code, str(ROOT / "addon"), str(file), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, preexec_fn=confine if limit else None)


def test_a_full_disk_is_said_and_nothing_is_lost(tmp_path):
    file, out = tmp_path / "study.toml", tmp_path / "out"
    run_study(lay_out(tmp_path, scenes={"open": "open.npz"}, settings={"radius": 0.2}, measures=["nodes"]), out)
    file.write_text(
        'measures = ["nodes"]\n[scenes]\nopen = "open.npz"\n[clips]\ngraph = "graph.npz"\n'
        "[settings]\nradius = [0.2, 0.3]"
    )
    full = cluster_program(file, "--out", out, "--scheduler", "processes", "--workers", 1, limit=200)
    assert full.returncode == 1
    assert "cannot be written (File too large)" in full.stderr and "finished is kept" in full.stderr
    assert "Traceback" not in full.stderr
    assert not list(out.rglob(".writing-*"))
    again = run_study(read_plan(file), out)
    assert again.n_known == 1 and again.n_failed == 0


def test_a_scheduler_that_does_not_answer_is_said(tmp_path):
    pytest.importorskip("distributed", reason="Dask is not installed")
    lay_out(tmp_path)
    file = tmp_path / "study.toml"
    file.write_text('[scenes]\nopen = "open.npz"\n[clips]\ngraph = "graph.npz"')
    result = cluster_program(file, "--out", tmp_path / "out", "--scheduler", "tcp://127.0.0.1:1")
    assert result.returncode == 1 and "No scheduler answers at 'tcp://127.0.0.1:1'" in result.stderr


def test_that_dask_is_missing_is_said(tmp_path):
    lay_out(tmp_path)
    file = tmp_path / "study.toml"
    file.write_text('[scenes]\nopen = "open.npz"\n[clips]\ngraph = "graph.npz"')
    result = cluster_program(file, "--out", tmp_path / "out", first="sys.modules['distributed'] = None")
    assert result.returncode == 1 and "Dask is not installed" in result.stderr
    assert "--scheduler processes" in result.stderr and "Traceback" not in result.stderr


# ----------------------------------------------------------------------------------------------- large grounds


def test_a_ground_in_parcels_is_the_same_ground(tmp_path):
    lay_out(tmp_path)
    save_scene(room(width=12.0, regions=[region()]), tmp_path / "long.npz")
    wanted = ["nodes", "links", "coverage", "full_area", "heading_coverage", "median_variability"]
    study = plan(
        tmp_path,
        scenes={"long": "long.npz"},
        settings={"parcel_size": [0.0, 4.0], "k": [0, 2], "tiled": [False, True]},
        measures=[*wanted, "turn_balance"],
    )
    outcome = run_study(study, tmp_path / "out")
    found = {tuple(e.case.values[n] for n in ("parcel_size", "k", "tiled")): e for e in outcome.outcomes}
    for tiled in (False, True):
        whole, parcels = found[0.0, 0, tiled].result, found[4.0, 0, tiled].result
        assert whole.numbers["nodes"] > 0
        assert [whole.numbers[name] for name in wanted] == [parcels.numbers[name] for name in wanted]
        assert np.array_equal(whole.picture.levels, parcels.picture.levels, equal_nan=True)
        assert parcels.numbers["turn_balance"] is None and "in parcels" in parcels.remarks[0]
        assert "cannot be pruned" in found[4.0, 2, tiled].problem
    assert run_study(study, tmp_path / "out", Failing(2, None)).n_known == 6


def test_parcels_that_are_too_small_are_said(tmp_path):
    lay_out(tmp_path)
    study = plan(tmp_path, scenes={"open": {"file": "open.npz", "parcel_size": 0.5}}, settings={})
    outcome = run_study(study, tmp_path / "out")
    assert "longest step" in outcome.outcomes[0].problem
    assert results_table(outcome).records()[0]["parcel_size"] == 0.5


# -------------------------------------------------------------------------------------------------------- files


def test_scenes_and_clips_are_read_back(tmp_path):
    geometry = replace(
        room(regions=[region(), region(RegionRule.CONFINE, "jump")]),
        tiled=True,
        body=EnvironmentSettings(0.31, 0.1, 1.7, -0.25),
        footprint=FootprintSettings(0.01, 0.1, 0.02, 0.2, FootprintRule.CONSERVATIVE),
    )
    save_scene(geometry, tmp_path / "scene.npz")
    again = load_scene(tmp_path / "scene.npz")
    assert np.array_equal(again.obstacles, geometry.obstacles)
    for ours, theirs in zip(geometry.regions, again.regions, strict=True):
        assert np.array_equal(ours.triangles, theirs.triangles)
        assert replace(ours, triangles=0) == replace(theirs, triangles=0)
    assert replace(again, obstacles=0, regions=()) == replace(geometry, obstacles=0, regions=())
    save_scene(SceneGeometry(np.empty((0, 3, 3)), (0, 0), (1, 1)), tmp_path / "empty.npz")
    assert load_scene(tmp_path / "empty.npz").obstacles.shape == (0, 3, 3)

    contacts = replace(MotionGraphSettings().contacts, feet=(("LeftFoot", "LeftToes"), ("RightFoot",)))
    cost = replace(MotionGraphSettings().cost, joint_weights={"Spine": 0.5})
    settings = MotionGraphSettings(max_cost=0.2, sigma=0.1, contacts=contacts, cost=cost)
    save_clip_set(ClipSet(few_clips(), settings), tmp_path / "clips.npz")
    clips = load_clip_set(tmp_path / "clips.npz")
    assert clips.settings == settings
    for ours, theirs in zip(few_clips(), clips.clips, strict=True):
        assert ours.name == theirs.name and np.array_equal(ours.rotations, theirs.rotations)
    with pytest.raises(StudyError, match=r"holds a clip set and no scene"):
        load_scene(tmp_path / "clips.npz")


def entries(**changes):
    return {"scenes": {"a": "a.npz"}, "clips": {"c": "c.blend"}, **changes}


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (entries(scenes={}), "There are no scenes"),
        ({"scenes": {"a": "a.npz"}}, "There are no clips"),
        (entries(sceens={}), "no entry 'sceens'"),
        (entries(scenes={"a": "a.fbx"}), "must be a .blend or an .npz"),
        (entries(scenes={"a": {"scene": "x"}}), "names no file"),
        (entries(scenes={"a": {"file": "a.npz", "rig": "x"}}), "has no 'rig'"),
        (entries(scenes={"../a": "a.npz"}), "is no name"),
        (entries(clips={"c": {"file": "c.blend", "actions": "walk"}}), "a list of names"),
        (entries(settings={"radios": 1}), "no setting 'radios'"),
        (entries(settings={"radius": -1}), "'radius' cannot be -1"),
        (entries(settings={"radius": "wide"}), "'radius' cannot be 'wide'"),
        (entries(settings={"n_headings": 2.5}), "'n_headings' cannot be 2.5"),
        (entries(settings={"tiled": 1}), "'tiled' cannot be 1"),
        (entries(settings={"footprint_rule": "round"}), "snap or conservative"),
        (entries(settings={"radius": []}), "has no values"),
        (entries(settings=3), "must be a table"),
        (entries(measures=["beauty"]), "no measure 'beauty'"),
        (entries(measures=[{"measure": "nodes", "tag": "x"}]), "no option 'tag'"),
        (entries(measures=[{"measure": "time_to_reach", "region": 3}]), "cannot be 3"),
        (entries(measures=["nodes", "nodes"]), "Two measures are called 'nodes'"),
        (entries(measures=[]), "a list of names"),
        (entries(settings={"radius": [i / 1e6 for i in range(100_001)]}), "more than 100,000"),
    ],
)
def test_mistakes_in_the_file_are_named(table, sentence, tmp_path):
    with pytest.raises(StudyError, match=sentence):
        plan_of(table, tmp_path, "x")


def test_the_file_is_read_as_it_is_described(tmp_path):
    text = Path(ROOT / "core" / "study" / "plan.py").read_text().split('"""')[1]
    example = text.split("::")[1].rsplit("Files are sought", 1)[0]
    file = tmp_path / "levels.toml"
    file.write_text("\n".join(line.removeprefix("    ") for line in example.splitlines()))
    study = read_plan(file)
    assert study.title == "Three levels" and [s.name for s in study.scenes] == ["plaza", "alley", "cellar", "valley"]
    assert study.scenes[3].parcel_size == 25 and study.clip_sets[1].actions == ("walk*", "turn*")
    assert dict(study.settings) == {"radius": (0.2, 0.3), "max_cost": (0.1, 0.2), "k": (0, 2)}
    assert study.measures[3] == Measure("to the door", "time_to_reach", {"position": [3.0, 1.5]})
    assert len(list(study.cases())) == 4 * 3 * 8
    file.write_text("scenes = [")
    with pytest.raises(StudyError, match="is no TOML"):
        read_plan(file)
    with pytest.raises(StudyError, match="cannot be read"):
        read_plan(tmp_path / "none.toml")


def test_blend_files_must_have_been_read(tmp_path):
    study = plan_of(entries(scenes={"a": "a.blend"}), tmp_path, "x")
    with pytest.raises(StudyError, match="has not been read"):
        run_study(study, tmp_path / "out")


def test_tables_and_pages_hold_every_case(tmp_path):
    study = lay_out(tmp_path, settings={"radius": [0.2, 0.25, 0.3], "k": ["all", 2], "cell_size": 0.25})
    outcome = finish(run_study_steps(study, tmp_path / "out"))
    table = results_table(outcome)
    assert table.columns[:5] == ("scene", "clips", "radius", "k", "cell_size")
    assert len(table.rows) == 12 and table.records()[1]["k"] == "2"
    page = study_page(outcome)
    # A chart for each measure and scene, a legend, a map for each case.
    assert page.count("<svg") == 4 * 2 + 1 + 12
    assert "12 cases" in page and "cell_size 0.25" in page and "nan" not in page.lower().replace("nanum", "")
    flat = study_page(run_study(plan(tmp_path, settings={}, measures=["turn_balance", "nodes"]), tmp_path / "out"))
    assert flat.count("<svg") == 2 + 1 + 2
    record = json.loads(next((tmp_path / "out" / "cases").glob("*.json")).read_text())
    assert set(record) == {"format", "numbers", "remarks", "picture", "seconds"}


def test_the_documentation_names_everything():
    text = (ROOT / "docs" / "studies.md").read_text()
    assert {name for name in [*QUANTITIES, *SETTINGS] if f"| `{name}` |" not in text} == set()
    assert all(f"| {quantity.meaning} |" in text for quantity in QUANTITIES.values())


def test_maps_of_large_grounds_are_made_coarser():
    environment = build_environment(Grid((LONGEST_SIDE + 11, 13, 6), 0.25), room().obstacles)
    ground = WholeGround(embed(small_graph(), environment))
    found = small_map(ground)
    assert found.levels.shape == (66, 7) and found.cell_size == 0.5
    kinds = set()
    for x, y in np.ndindex(found.levels.shape):
        block = np.s_[2 * x : 2 * x + 2, 2 * y : 2 * y + 2]
        ways, level = ground.ways[block], found.levels[x, y]
        if (ways > 0).any():
            assert level == pytest.approx(np.log10(ways[ways > 0].mean()), abs=1e-5)
            kinds.add("passed" if (ways > 0).all() else "partly")
        elif ground.free[block].any():
            assert level == -1
            kinds.add("free")
        else:
            assert np.isnan(level)
            kinds.add("blocked")
    assert kinds == {"passed", "partly", "free", "blocked"}


class Stumbling(Serial):
    """Every task fails when it is first tried."""

    def __init__(self):
        self.tried = set()

    def submit(self, fn, /, *args, **kwargs):
        if args[-1] in self.tried:
            return super().submit(fn, *args, **kwargs)
        self.tried.add(args[-1])
        future = Future()
        future.set_exception(RuntimeError("stumbled"))
        return future


def test_a_fault_is_given_another_try(tmp_path):
    study = lay_out(tmp_path, clips={"clips": "clips.npz"}, scenes={"open": "open.npz"})
    stumbling = run_study(study, tmp_path / "out", Stumbling())
    assert stumbling.n_failed == 0
    assert rows_of(stumbling) == rows_of(run_study(study, tmp_path / "whole"))
