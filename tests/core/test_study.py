"""Studies: every case is what doing it by hand gives, and nothing is lost whatever fails."""

import importlib
import json
import math
import os
import resource
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import fields, is_dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import matplotlib.image as mpimg
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
from core.evaluation.ablation import Verdict
from core.evaluation.capture.director import direct_capture_steps
from core.evaluation.floor import floor_cells
from core.evaluation.path_efficiency import path_efficiency_steps
from core.evaluation.segment_groups import Grouping, segment_groups
from core.evaluation.variability import coverage_share, floor_variability
from core.evaluation.why_not import Reason, why_not_steps
from core.maps.colors import RULED
from core.motion.graph import MotionGraphSettings, build_motion_graph
from core.parcels.work import Serial
from core.progress import finish
from core.study.case import embedding_settings
from core.study.clip_set import ClipSet, load_clip_set, save_clip_set
from core.study.geometry import SceneGeometry, environment_of, load_scene, save_scene
from core.study.lock import only_one
from core.study.maps import BLOCKED, NOT_REACHED, write_maps
from core.study.measures import QUANTITIES, Measure, checked_measure, measured
from core.study.picture import LONGEST_SIDE, NOT_PASSED, ONLY_CROSSED, small_map
from core.study.plan import plan_of, read_plan
from core.study.report import study_page
from core.study.results import failures, results_table
from core.study.run import run_study_steps
from core.study.settings import SETTINGS
from core.study.subject import WholeGround
from core.tuning.local_pruning import prune_local_steps

from .studies import few_clips, lay_out, plan, region, room, rows_of, run_case, run_study, small_graph

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
        embedding = finish(prune_local_steps(embedding, k))
    ways = floor_variability(embedding)
    assert list(found.numbers.values()) == [
        embedding.n_nodes,
        embedding.n_links,
        coverage_share(embedding),
        ways.sum(),
    ]
    levels = found.picture.levels
    standing, floor = environment.free_cells(), floor_cells(embedding)
    assert np.array_equal(np.isnan(levels), ~standing)
    assert np.array_equal(levels == ONLY_CROSSED, standing & ~floor)
    assert np.array_equal(levels == NOT_PASSED, floor & (ways == 0))
    assert np.array_equal(levels >= 0, ways > 0)
    assert np.allclose(10.0 ** levels[ways > 0], ways[ways > 0], rtol=1e-5)


def test_every_quantity_has_a_number():
    embedding = embed(small_graph(), build_environment(Grid((16, 16, 8), 0.25), np.empty((0, 3, 3))))
    ground = WholeGround(embedding)
    place = embedding.environment.grid.positions(np.argwhere(ground.covered)[0]).tolist()
    small = {"pairs": 8, "goals": 2}
    found = {}
    for name, quantity in QUANTITIES.items():
        given = small if "pairs" in quantity.options else {}
        if quantity.one_of:
            given = {"verdict": "essential"} if "verdict" in quantity.one_of else {"position": place}
        measure = checked_measure({"measure": name, **given})
        found[name] = measured(measure, ground)
        assert np.isfinite(found[name]), name
    assert found["nodes"] == embedding.n_nodes and found["segments"] == len(small_graph().segments)
    by_hand = finish(path_efficiency_steps(embedding, np.random.default_rng(0), 8, 2))
    assert found["path_efficiency"] == by_hand.mean and found["worst_path_efficiency"] == by_hand.efficiency.min()
    assert 0 < found["least_action_coverage"] <= found["action_coverage"] <= 1
    assert 0 < found["time_to_reach"] < found["worst_time_to_reach"]
    assert found["time_from"] != found["time_to_reach"] and 0 < found["area_within"] < found["covered_area"]
    assert found["left_links"] + found["right_links"] + found["straight_links"] == embedding.n_links
    assert found["places"] == np.count_nonzero(embedding.covered())
    advice = finish(direct_capture_steps(embedding))
    assert found["capture_area"] == advice.gains[0].floor > 0
    assert found["capture_motions"] == sum(gain.floor > 0 for gain in advice.gains)
    by_verdict = [
        measured(checked_measure({"measure": "judged_actions", "verdict": v.name.lower()}), ground) for v in Verdict
    ]
    assert sum(by_verdict) == len(segment_groups(embedding.graph, Grouping.CLIP))
    assert found["full_area"] <= found["covered_area"] <= found["free_area"] == pytest.approx(16.0)


def test_what_can_only_be_crossed_is_not_missing():
    # Nothing that is played carries the tag: no walk stands there, and some of the floor around it is out of reach.
    geometry = room(regions=[region(RegionRule.REQUIRE, "swim")])
    ground = WholeGround(embed(small_graph(), environment_of(geometry, {}), embedding_settings(geometry, {})))

    def missing(**options):
        return measured(checked_measure({"measure": "missing", **options}), ground)

    why, floor = finish(why_not_steps(ground.embedding)), floor_cells(ground.embedding)
    assert (why == Reason.RULE).any() and floor.any() and not (why[floor] == Reason.RULE).any()
    assert 0 < missing() == pytest.approx(1 - measured(checked_measure("heading_coverage"), ground))
    by_reason = {
        r: missing(reason=r.name.lower())
        for r in Reason
        if r not in (Reason.EMBEDDED, Reason.BLOCKED, Reason.NO_GROUND)
    }
    n_places = np.count_nonzero(floor) * why.shape[2]
    assert all(share == np.count_nonzero(why == reason) / n_places for reason, share in by_reason.items())
    outside = by_reason[Reason.RULE] + by_reason[Reason.FORBIDDEN]
    assert sum(by_reason.values()) - outside == pytest.approx(missing())


def test_evaluations_of_one_name_are_told_apart():
    ground = WholeGround(embed(small_graph(), build_environment(Grid((16, 16, 8), 0.25), np.empty((0, 3, 3)))))
    asked = []

    def one_of(number):
        def evaluation(embedding, options):
            asked.append(number)
            return number

        return evaluation

    first, second = one_of(1), one_of(2)
    found = [ground.once(first, {}), ground.once(second, {}), ground.once(first, {}), ground.once(first, {"a": 1})]
    assert found == [1, 2, 1, 1] and asked == [1, 2, 1]


#: What modules of core.evaluation tell that is one number, by (class, attribute): the measure that it is, or why none.
NUMBERS = {
    "Detours": {},
    "EnvironmentCoverage": {
        "covered_area": "covered_area",
        "free_area": "free_area",
        "position_share": "coverage",
        "task_share": "heading_coverage",
        "full_area": "full_area",
    },
    "EmbeddingSize": {
        "floor": "covered_area",
        "share": "coverage",
        "places": "places",
        "nodes": "nodes",
        "links": "links",
    },
    "JointDeletion": {"share": "spare_loss", "places_share": "spare_places_loss"},
    "LinkUtility": {"n_nodes": "nodes", "n_links": "links"},
    "LostLinks": {
        "possible": "possible_links",
        "obstacles": "obstacle_links",
        "regions": "region_links",
        "free": "free_links",
        "embedded": "links",
    },
    "Loss": {"share": "greatest_loss", "places_share": "greatest_places_loss"},
    "Gain": {"floor": "capture_area", "places": "capture_places"},
    "Maneuverability": {
        "mean": "maneuverability",
        "worst": "worst_maneuverability",
        "at_once": "at_once",
        "promptly": "promptly",
    },
    "Metrics": {"mean_wait": "maneuverability", "n_never": "idle_actions"},
    "Occupancy": {
        "visited_area": "visited_area",
        "effective_area": "effective_area",
        "half_time_share": "half_time_share",
    },
    "PathEfficiency": {"mean": "path_efficiency", "standard_error": "path_efficiency_error"},
    "TurnBalance": {
        "n_left": "left_links",
        "n_right": "right_links",
        "n_straight": "straight_links",
        "total": "turn_balance",
    },
    "WeakSpots": {"area": "weak_area"},
}
#: Numbers that are no measures: what was asked for, how the number was found, or the same by another name.
OF_THEIR_OWN = {
    ("Detours", "speed"): "the measure 'speed'",
    ("JointDeletion", "allowed"): "what was asked for",
    ("Loss", "floor"): "its share is the measure",
    ("Loss", "places"): "its share is the measure",
    ("Loss", "nodes"): "its share is the measure",
    ("Loss", "links"): "its share is the measure",
    ("Occupancy", "cell_area"): "a setting of the scene",
    ("Occupancy", "residual"): "how well it was found",
    ("Occupancy", "error"): "how well it was found",
    ("Occupancy", "n_steps"): "how it was found",
    ("PathEfficiency", "n_goals"): "how it was found",
    ("PathEfficiency", "worst"): "an index; the measure 'worst_path_efficiency' is its number",
    ("ReachField", "limit"): "what was asked for",
    ("ReachField", "frame_rate"): "a setting",
}
#: Parts of results (one spot, one column), what was asked for, and tools of the evaluation itself.
NO_RESULTS = {
    "WeakSpot",
    "WeakSpotSettings",
    "Candidate",
    "CandidateFamily",
    "SegmentGroup",
    "Objective",
    "PlaceReport",
    "Query",
}
NO_RESULTS |= {"Trials", "BitCounter", "StationaryFlow", "Front"}


def test_every_number_of_the_evaluation_can_be_measured():
    folder = ROOT / "core" / "evaluation"
    unknown = []
    for file in sorted(folder.rglob("*.py")):
        name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        module = importlib.import_module(name)
        for kind in vars(module).values():
            ours = isinstance(kind, type) and kind.__module__ == name and not kind.__name__.startswith("_")
            if not (ours and is_dataclass(kind)) or kind.__name__ in NO_RESULTS:
                continue
            types = {field.name: str(getattr(field.type, "__name__", field.type)) for field in fields(kind)}
            for attribute, value in vars(kind).items():
                if isinstance(value, property):
                    told = value.fget.__annotations__.get("return")
                    types[attribute] = str(getattr(told, "__name__", told))
            numbers = {attribute for attribute, told in types.items() if told in ("int", "float")}
            numbers -= {attribute for owner, attribute in OF_THEIR_OWN if owner == kind.__name__}
            unknown += [(kind.__name__, a) for a in numbers if NUMBERS.get(kind.__name__, {}).get(a) not in QUANTITIES]
    assert not unknown, f"neither a measure nor explained: {sorted(unknown)}"
    assert all(measure in QUANTITIES for numbers in NUMBERS.values() for measure in numbers.values())


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


def test_results_of_another_version_are_not_mixed_with_ours(tmp_path):
    study = lay_out(tmp_path, clips={"clips": "clips.npz"})
    first = run_study(study, tmp_path / "out")
    files = sorted((tmp_path / "out" / "cases").glob("*.json"))
    for file, version in zip(files[:2], ["another", None], strict=True):
        found = json.loads(file.read_text())
        found["version"] = version
        if version is None:  # as results were written before they told
            del found["version"]
        found["numbers"]["nodes"] = -1
        file.write_text(json.dumps(found))
    said = []
    again = finish(run_study_steps(study, tmp_path / "out"), lambda progress: said.append(progress.message))
    assert (again.n_known, again.n_outdated, again.n_failed) == (2, 2, 0)
    assert "2 of 4 cases had been finished before" in said
    assert "2 cases that another version of Wayfarer had finished will be run again" in said
    assert rows_of(again) == rows_of(first)
    assert run_study(study, tmp_path / "out").n_known == 4
    # What could not be run again yet is still there, and still not ours.
    found = json.loads(files[0].read_text())
    files[0].write_text(json.dumps({**found, "version": "another"}))
    with pytest.raises(StudyError, match="workers are gone"):
        run_study(study, tmp_path / "out", Failing(0, None))
    assert json.loads(files[0].read_text())["version"] == "another"


def test_stopping_is_possible_at_every_step(tmp_path):
    study = lay_out(tmp_path)
    for n_steps in (1, 2, 3):
        steps = run_study_steps(study, tmp_path / "out")
        for _ in range(n_steps):
            assert 0 <= next(steps).fraction <= 1
        steps.close()
    assert run_study(study, tmp_path / "out").n_failed == 0


def test_a_worker_that_dies_costs_its_case_only(tmp_path, caplog):
    study = lay_out(tmp_path)
    outcome = run_study(study, tmp_path / "out", Failing(3, RuntimeError("killed, as too large")))
    assert outcome.n_failed == 1
    assert "not foreseen" in failures(outcome)[0]
    assert "killed" not in failures(outcome)[0] and "killed, as too large" in caplog.text
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
    command = [sys.executable, "-c", code, str(ROOT / "addon" / "cli"), str(file), *map(str, words)]
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
    assert (
        "cannot be written (its disk does not hold files as large as that)" in full.stderr
        and "finished is kept" in full.stderr
    )
    assert "Traceback" not in full.stderr
    assert not list(out.rglob(".writing-*"))
    again = run_study(read_plan(file), out)
    assert again.n_known == 1 and again.n_failed == 0


def test_a_full_disk_is_said_of_large_grounds_too(tmp_path):
    file, out = tmp_path / "study.toml", tmp_path / "out"
    lay_out(tmp_path)
    save_scene(room(width=500.0), tmp_path / "long.npz")
    file.write_text(
        'measures = ["nodes"]\n[scenes]\nlong = "long.npz"\n[clips]\ngraph = "graph.npz"\n[settings]\nparcel_size = 4.0'
    )
    # Room for what is copied, but not for the mask of the ground.
    size = max((tmp_path / name).stat().st_size for name in ("long.npz", "graph.npz"))
    full = cluster_program(file, "--out", out, "--scheduler", "processes", "--workers", 1, limit=size + 100)
    assert full.returncode == 1, full.stderr
    assert "cannot be written (" in full.stderr and "None" not in full.stderr and "Traceback" not in full.stderr
    # What is half there is not taken for a problem that was laid out.
    assert not [path for name in ("graph.npz", "problem.json", ".making*") for path in out.rglob(name)]


def test_what_is_stopped_by_hand_goes_on(tmp_path):
    """Ctrl-C, which reaches the program and its workers alike, in the middle of a large ground."""
    file, out = tmp_path / "study.toml", tmp_path / "out"
    lay_out(tmp_path)
    save_scene(room(width=24.0), tmp_path / "long.npz")
    file.write_text(
        'measures = ["nodes", "links"]\n[scenes]\nlong = "long.npz"\n[clips]\ngraph = "graph.npz"\n'
        "[settings]\nparcel_size = 4.0"
    )
    command = [sys.executable, str(ROOT / "addon" / "cli" / "cluster.py"), str(file), "--out", str(out)]
    command += ["--scheduler", "processes", "--workers", "2"]
    # Also where the tests themselves were started in the background, which would have all heed it not.
    listening = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(command, process_group=0, preexec_fn=listening, **pipes)
    try:
        while not list(out.rglob("journal.json")) and process.poll() is None:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=300)[1]
    finally:
        process.kill()
    assert process.returncode == 130, said
    assert "stopped; start it again to go on" in said
    journals = list(out.rglob("journal.json"))
    assert len(journals) == 1 and not list((out / "cases").glob("*.json"))
    n_phases = len(json.loads(journals[0].read_text()))
    assert n_phases > 0
    result = run_study(read_plan(file), out).outcomes[0].result
    alone = run_case(room(width=24.0), small_graph(), {}, [Measure(n, n) for n in ("nodes", "links")])
    assert dict(result.numbers) == dict(alone.numbers)


def test_two_do_not_work_in_the_same_folder(tmp_path):
    fcntl = pytest.importorskip("fcntl", reason="this machine locks files otherwise")
    lay_out(tmp_path)
    file, out = tmp_path / "study.toml", tmp_path / "out"
    file.write_text('measures = ["nodes"]\n[scenes]\nopen = "open.npz"\n[clips]\ngraph = "graph.npz"')
    out.mkdir()
    words = [file, "--out", out, "--scheduler", "processes", "--workers", 1]
    with open(out / ".lock", "ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        result = cluster_program(*words)
        assert result.returncode == 1 and f"Another study works in '{out}' right now" in result.stderr
    assert cluster_program(*words).returncode == 0
    out.joinpath("file").write_text("")
    result = cluster_program(file, "--out", out / "file" / "folder", "--scheduler", "processes")
    assert result.returncode == 1 and "cannot be written to" in result.stderr


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
    result = cluster_program(
        file, "--out", tmp_path / "out", "--scheduler", "local", first="sys.modules['distributed'] = None"
    )
    assert result.returncode == 1 and "Dask is not installed" in result.stderr
    assert "--scheduler processes" in result.stderr and "Traceback" not in result.stderr


@pytest.mark.parametrize("how", ["processes", "local"])
def test_nothing_in_the_current_folder_is_run(tmp_path, how):
    if how == "local":
        pytest.importorskip("distributed", reason="Dask is not installed")
        pytest.importorskip("cryptography", reason="there is no TLS")
    lay_out(tmp_path)
    (tmp_path / "study.toml").write_text(
        'measures = ["nodes"]\n[scenes]\nopen = "open.npz"\n[clips]\ngraph = "graph.npz"'
    )
    for name in ("multiprocessing", "numpy", "core", "json", "signal", "distributed"):
        (tmp_path / f"{name}.py").write_text("import pathlib\npathlib.Path(__file__).with_suffix('.ran').touch()")
    command = [sys.executable, ROOT / "addon" / "cli" / "cluster.py", "study.toml", "--out", "out"]
    result = subprocess.run(
        [*command, "--scheduler", how, "--workers", "1"], cwd=tmp_path, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    assert not list(tmp_path.glob("*.ran"))


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this machine ends programs otherwise")
@pytest.mark.parametrize(("how", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGKILL, -9)])
def test_whatever_ends_a_study_ends_its_workers(tmp_path, how, code):
    """Also those in the middle of a long task, without a traceback, and the folder is free again."""
    lay_out(tmp_path, settings={})
    save_scene(room(width=60.0), tmp_path / "open.npz")
    (tmp_path / "study.toml").write_text(
        'measures = ["nodes"]\n[scenes]\nopen = "open.npz"\n[clips]\ngraph = "graph.npz"\n[settings]\ncell_size = 0.02'
    )
    program = ROOT / "addon" / "cli" / "cluster.py"
    command = [sys.executable, program, tmp_path / "study.toml", "--out", tmp_path / "out", "--workers", "1"]
    # Whoever runs the tests in the background has Ctrl-C ignored, by what they start as well.
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heard
    ) as process:
        until = time.monotonic() + 120
        while not (workers := children(process.pid)):
            assert process.poll() is None and time.monotonic() < until
            time.sleep(0.1)
        time.sleep(2.0)
        (os.killpg if how == signal.SIGINT else os.kill)(process.pid, how)
        assert process.wait(30) == code
        until = time.monotonic() + 30
        while any(map(is_running, workers)):
            assert time.monotonic() < until, "a worker goes on"
            time.sleep(0.1)
        said = process.stderr.read()
    assert "Traceback" not in said
    assert how == signal.SIGKILL or "start it again to go on" in said
    with only_one(tmp_path / "out"):
        pass


@pytest.mark.skipif(os.name != "posix", reason="launchers of Python come in between")
def test_a_worker_that_begins_when_its_study_has_ended_ends():
    """As on a busy machine, where the study was killed while the worker started: it would wait for tasks for ever."""
    nobody = subprocess.Popen([sys.executable, "-c", ""])
    nobody.wait()
    words = "import sys, time; from core.study.tasks import end_with; end_with(int(sys.argv[1])); time.sleep(60)"
    ended = subprocess.run([sys.executable, "-c", words, str(nobody.pid)], cwd=ROOT, timeout=50)
    assert ended.returncode == 1


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def children(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children")
    if not found.exists():
        pytest.skip("this machine does not tell which processes a process has")
    return [int(child) for child in found.read_text().split()]


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


def test_maps_of_large_grounds_are_put_together(tmp_path):
    lay_out(tmp_path)
    geometry = room(width=12.0, regions=[region(RegionRule.REQUIRE, "swim")])
    save_scene(geometry, tmp_path / "long.npz")
    study = plan(tmp_path, scenes={"long": {"file": "long.npz", "parcel_size": 4.0}}, settings={})
    maps_of = run_study(study, tmp_path / "out").outcomes[0].maps
    ground = WholeGround(embed(small_graph(), environment_of(geometry, {}), embedding_settings(geometry, {})))
    write_maps(ground, (0.0, 0.0), tmp_path / "whole")
    written = tmp_path / "out" / maps_of
    assert written.parent == tmp_path / "out" / "maps" and written.name.startswith("long, graph ")
    assert sorted(path.name for path in written.glob("[!.]*")) == ["coverage.png", "maps.npz", "variability.png"]
    with np.load(written / "maps.npz") as maps:
        assert np.array_equal(maps["variability"], ground.ways) and maps["variability"].any()
        assert np.array_equal(maps["coverage"], ground.headings) and np.array_equal(maps["free"], ground.free)
        assert maps["cell_size"] == 0.25 and maps["origin"].tolist() == [0, 0]
    for name in ("coverage.png", "variability.png"):
        assert (written / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    pixels = np.round(255 * mpimg.imread(written / "coverage.png")).astype(int)
    assert pixels.shape[:2] == ground.ways.T.shape

    def painted(color):
        return np.all(pixels[..., :3] == (255 * np.array(color)).round(), axis=2)[::-1].T

    standing = ground.embedding.environment.free_cells()
    assert np.array_equal(painted(BLOCKED), ~standing) and not standing.all()
    assert np.array_equal(painted(RULED), standing & ~ground.free) and painted(RULED).any()
    missed = painted(NOT_REACHED)
    assert np.array_equal(missed, (ground.headings == 0) & ground.free) and missed.any()


def test_maps_stay_with_their_case(tmp_path):
    lay_out(tmp_path)
    save_scene(room(width=12.0), tmp_path / "long.npz")
    names = ["ö" * 200, "ö" * 200 + "o"]

    def maps_of(radius):
        study = plan(
            tmp_path,
            scenes={name: {"file": "long.npz", "parcel_size": 4.0} for name in names[: 1 if radius > 0.2 else 2]},
            settings={"radius": radius},
            measures=["nodes", "covered_area"],
        )
        outcome = run_study(study, tmp_path / "out")
        assert outcome.n_failed == 0
        for entry in outcome.outcomes:
            with np.load(tmp_path / "out" / entry.maps / "maps.npz") as maps:
                area = np.count_nonzero(maps["coverage"]) * 0.25**2
            assert area == entry.result.numbers["covered_area"] > 0
        return [entry.maps for entry in outcome.outcomes], outcome.n_known

    narrow, _ = maps_of(0.2)
    wide, _ = maps_of(0.35)
    assert maps_of(0.2) == (narrow, 2)
    assert not set(narrow) & set(wide) and all(len(Path(name).name.encode()) <= 255 for name in narrow)


def test_maps_tell_what_can_only_be_crossed():
    geometry = room(regions=[region(RegionRule.REQUIRE, "swim")])
    ground = WholeGround(embed(small_graph(), environment_of(geometry, {}), embedding_settings(geometry, {})))
    levels = small_map(ground).levels
    ruled = ground.embedding.environment.free_cells() & ~floor_cells(ground.embedding)
    assert np.array_equal(levels == ONLY_CROSSED, ruled) and ruled.any()
    assert np.array_equal(np.isnan(levels), ~ground.embedding.environment.free_cells())


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
        (entries(measures=[{"measure": "time_to_reach", "position": ["here", 2]}]), "two numbers, x and y"),
        (entries(measures=[{"measure": "time_to_reach", "position": [1.0, math.nan]}]), "two numbers, x and y"),
        (entries(measures=[{"measure": "time_to_reach", "position": [1.0, True]}]), "two numbers, x and y"),
        (entries(measures=[{"measure": "time_to_reach", "position": [1.0]}]), "two numbers, x and y"),
        (entries(measures=[{"measure": "time_to_reach"}]), "needs one of its options region, tag"),
        (entries(measures=[{"measure": "time_to_reach", "tag": "a", "region": "b"}]), "needs one of"),
        (entries(measures=[{"measure": "path_efficiency", "pairs": 0}]), "1 or more"),
        (entries(measures=[{"measure": "missing", "reason": "blocked"}]), "one of rule, forbidden, no_way_out"),
        (entries(measures=[{"measure": "missing", "reason": "embedded"}]), "one of rule, forbidden, no_way_out"),
        (entries(measures=[{"measure": "maneuverability", "tag": "a", "clip": "b"}]), "one of its options tag, clip;"),
        (entries(measures=[{"measure": "promptly", "kind": "clip", "clip": "b"}]), "one of its options kind, clip;"),
        (entries(measures=[{"measure": "time_from", "tag": "a", "radius": 1.0}]), "nothing without 'position'"),
        (entries(measures=[{"measure": "area_within", "tag": "a", "tolerance": 1}]), "nothing without 'heading'"),
        (entries(measures=[{"measure": "action_coverage", "kind": "limb"}]), "'segment' or 'clip' or 'tag'"),
        (entries(measures=[{"measure": "detour", "spacing": math.inf}]), "a number, more than 0"),
        (entries(measures=[]), "a list of names"),
        (entries(table="parquet"), "no entry 'table'"),
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
    assert "left out" not in page + flat
    record = json.loads(next((tmp_path / "out" / "cases").glob("*.json")).read_text())
    assert set(record) == {"format", "version", "numbers", "remarks", "picture", "seconds"}


def test_charts_leave_out_cases_without_an_answer(tmp_path):
    """A goal that cannot be reached is not one that is reached in no time."""
    study = lay_out(tmp_path, settings={}, measures=[{"measure": "time_to_reach", "region": "door"}])
    # Only one of the rooms has the region.
    outcome = run_study(study, tmp_path / "out")
    page = study_page(outcome)
    assert [entry.result.numbers["time_to_reach"] is None for entry in outcome.outcomes] == [True, False]
    assert "Without an answer, and left out: 1 case." in page
    chart = page[page.index("<svg") : page.index("</svg>")]
    assert "door, graph" in chart and "open, graph" not in chart
    lines = run_study(plan(tmp_path, measures=[{"measure": "time_to_reach", "region": "door"}]), tmp_path / "out")
    page = study_page(lines)
    assert "left out: 2 cases." in page and "in door" in page and "in open" not in page


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
