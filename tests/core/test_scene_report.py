"""The report of a scene: says what the evaluations say, skips what it is told to, and needs nothing from elsewhere."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib import image

from core.embedding.embedding import embed
from core.environment.environment import Environment
from core.environment.grid import SUBDIVISION, Grid
from core.environment.regions import RegionMask, RegionRule
from core.errors import EvaluationError, StorageError
from core.evaluation.ablation import ablate_steps
from core.evaluation.environment_coverage import environment_coverage
from core.evaluation.floor import ruled_cells
from core.evaluation.goals import goal_at
from core.evaluation.reach import PAPER_TIMES, round_times, time_to_reach_steps
from core.evaluation.segment_groups import Grouping
from core.evaluation.turn_balance import turn_balance
from core.maps.colors import BLOCKED, OBSTACLE, RULED, STEP, UNREACHED
from core.motion.graph import MotionGraphSettings, build_motion_graph
from core.motion.repertoire import sample_repertoire
from core.progress import finish
from core.report.chart import Trace, map_chart
from core.report.drawing import Line, Picture
from core.report.finding import Goal, Questions
from core.report.floor_chart import FloorScene, amount_chart, band_chart, floor_pixels, picture_of
from core.report.scene_report import examine_scene_steps, write_report
from core.report.topics import (
    CAPTURE,
    COVERAGE,
    DETOURS,
    LINKS,
    METRICS,
    OCCUPANCY,
    REACH,
    SECTIONS,
    TURNS,
    WEAK_SPOTS,
)
from core.tuning.pruning_curve import pruning_curve_steps

from .reference import random_problem


@pytest.fixture(scope="module")
def walked():
    """The sample character in a coarse room with a block and a band that needs steps over."""
    grid = Grid((20, 24, 12), 0.25)
    blocked = np.zeros((80, 96), dtype=bool)
    blocked[20:32, 24:40] = True
    band = np.zeros_like(blocked)
    band[:, 66:68] = True
    environment = Environment(grid, blocked, (RegionMask("Sill", RegionRule.REQUIRE, "step", band),))
    names = ("walk", "turn_left_90", "turn_right_90", "arc")
    clips = [clip for clip in sample_repertoire() if clip.name.startswith(names)]
    return embed(build_motion_graph(clips, MotionGraphSettings(max_cost=0.1)), environment)


@pytest.fixture(scope="module")
def report(walked):
    """About everything but what takes long."""
    goal = Goal("the corner", goal_at(walked, (4.0, 1.0), 0.5))
    topics = frozenset(SECTIONS) - {DETOURS, OCCUPANCY, CAPTURE, METRICS}
    return finish(examine_scene_steps(walked, Questions(thorough=False, goal=goal), "Hall <1>", topics))


def test_numbers_are_those_of_the_evaluations(walked, report):
    numbers = report.numbers()
    covered = environment_coverage(walked)
    assert numbers["reach"]["covered_m2"] == covered.covered_area and numbers["reach"]["nodes"] == walked.n_nodes
    assert numbers["reach"]["links"] == walked.n_links
    lost = numbers["reach"]["links_lost_to_obstacles"] + numbers["reach"]["links_lost_to_regions"]
    assert walked.n_links <= numbers["reach"]["possible_links"] - lost
    assert numbers["turns"]["turn_balance"] == turn_balance(walked).total
    field = finish(time_to_reach_steps(walked, goal_at(walked, (4.0, 1.0), 0.5)))
    times = round_times(field.floor())
    assert numbers["times"]["areas_m2"] == dict(zip(map(str, times), field.areas(times), strict=True))
    losses = finish(ablate_steps(walked, [Grouping.CLIP])).ranked(Grouping.CLIP)
    assert [row["name"] for row in numbers["importance"]["ablation_clips"]] == [loss.group.name for loss in losses]
    curve = finish(pruning_curve_steps(walked))
    assert [row["nodes"] for row in numbers["pruning"]["pruning"]] == curve.n_nodes.tolist()


def test_topics_are_in_order_and_can_be_skipped(walked, report):
    assert list(report.contributions) == [topic for topic in SECTIONS if topic in report.contributions]
    assert DETOURS not in report.contributions and REACH in report.contributions
    page = finish(examine_scene_steps(walked, topics={TURNS, REACH})).html()
    assert "Does it turn both ways?" in page and "What can it reach?" not in page
    # Without a goal there is nothing to say about times.
    assert "How soon" not in page
    with pytest.raises(EvaluationError, match="at least one topic"):
        finish(examine_scene_steps(walked, topics=()))


def test_progress_never_goes_back(walked):
    fractions = []
    quick = {COVERAGE, WEAK_SPOTS, TURNS, LINKS, REACH}
    steps = examine_scene_steps(walked, Questions(thorough=False), topics=quick)
    finish(steps, lambda progress: fractions.append(progress.fraction))
    assert fractions == sorted(fractions) and fractions[0] >= 0 and fractions[-1] <= 1


def test_files_hold_what_the_report_says(tmp_path, report):
    files = write_report(tmp_path / "new", report)
    names = {file.name for file in files}
    assert {"report.html", "report.json", "sizes.csv", "variability.png", "variability.svg", "pruning.svg"} <= names
    assert {*names, ".wayfarer.json"} == {file.name for file in (tmp_path / "new").iterdir()}
    page = (tmp_path / "new" / "report.html").read_text()
    assert "Hall &lt;1&gt;" in page and "<script" not in page and "http:" not in page.replace("http://www.w3.org", "")
    read = json.loads((tmp_path / "new" / "report.json").read_text())
    assert read["reach"]["nodes"] == report.contributions[COVERAGE].numbers["nodes"]
    for part in report.contributions.values():
        for name, found in part.tables.items():
            rows = list(csv.reader(io.StringIO((tmp_path / "new" / f"{name}.csv").read_text())))
            assert tuple(rows[0]) == found.columns and len(rows) == len(found.rows) + 1
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot be written"):
        write_report(tmp_path / "file", report)


def test_pictures_show_obstacles_rules_and_what_is_out_of_reach(walked):
    obstacles = np.zeros((80, 96), dtype=bool)
    obstacles[24:28, 28:36] = True
    scene = FloorScene(walked.environment, obstacles)
    values = walked.covered().sum(axis=2)
    values[0:3, 0:3] = 0
    pixels = floor_pixels(scene, np.full((20, 24, 3), 0.5), values > 0)
    assert np.all(pixels[obstacles] == OBSTACLE)
    assert np.all(pixels[walked.environment.blocked & ~obstacles] == BLOCKED)
    assert np.all(pixels[0:8, 0:8] == UNREACHED)
    band = pixels[:, 66:68].reshape(-1, 3)
    assert (band == STEP).all(axis=1).any() and not (band == UNREACHED).all(axis=1).any()
    ruled = ruled_cells(walked.environment)
    assert ruled.any()
    assert np.all(ruled == (walked.environment.regions[0].mask[2::4, 2::4] & walked.environment.free_cells()))
    never = floor_pixels(scene, np.full((20, 24, 3), 0.5), np.zeros((20, 24), dtype=bool))
    assert (never[ruled.repeat(SUBDIVISION, 0).repeat(SUBDIVISION, 1)] == RULED).all(axis=1).any()


def test_a_map_as_png_is_the_map(walked, tmp_path, report):
    write_report(tmp_path, report)
    chart = report.contributions[COVERAGE].maps["variability"]
    floor = max((m.pixels for m in chart.marks if isinstance(m, Picture)), key=lambda p: p.size)
    read = np.round(255 * image.imread(tmp_path / "variability.png")).astype(np.uint8)
    assert np.array_equal(read, picture_of(chart)) and np.array_equal(read[1::3, 1::3], floor)
    assert floor.shape == (96, 80, 3)


def test_the_quicker_the_lighter(walked):
    field = finish(time_to_reach_steps(walked, goal_at(walked, (4.0, 1.0), 0.5)))
    chart = band_chart(FloorScene(walked.environment), "Times", field.floor(), PAPER_TIMES, "no way")
    floor = max((m.pixels for m in chart.marks if isinstance(m, Picture)), key=lambda p: p.size)[::-1].astype(int)
    light = floor.sum(axis=2).T[2::4, 2::4]
    plain = ~ruled_cells(walked.environment) & walked.environment.free_cells()
    bands = np.searchsorted(PAPER_TIMES, field.floor() - 1e-3)
    shades = [set(light[plain & (bands == band) & np.isfinite(field.floor())].tolist()) for band in range(5)]
    shades = [shade.pop() for shade in shades if len(shade) == 1]
    assert len(shades) >= 3 and shades == sorted(shades, reverse=True)


def test_a_common_scale_makes_maps_comparable(walked):
    ways = walked.covered().sum(axis=2).astype(float)
    scene = FloorScene(walked.environment)
    one, half = (amount_chart(scene, "", values, "ways", lightest=12.0) for values in (ways, ways / 4))
    brightness = [picture_of(chart).astype(int).sum() for chart in (one, half)]
    assert brightness[0] > brightness[1]
    assert np.array_equal(
        picture_of(amount_chart(scene, "", ways, "ways")), picture_of(amount_chart(scene, "", 4 * ways, "ways"))
    )


def test_walks_across_a_tiled_floor_come_back_on_the_other_side():
    trace = Trace(np.array([[8.0, 5.0], [9.0, 5.0], [10.0, 5.0], [11.0, 5.0]]), (0, 0, 0))
    chart = map_chart("", np.zeros((10, 10, 3)), 1.0, traces=[trace], width=132)
    pieces = [m.points for m in chart.marks if isinstance(m, Line) and m.width == 2.0]
    assert [len(piece) for piece in pieces] == [2, 2]
    left = pieces[1][0, 0] - 0.5 * (pieces[0][1, 0] - pieces[0][0, 0])
    # The third point is in the middle of the leftmost cell.
    assert np.isclose(pieces[0][1, 0] - pieces[1][0, 0], 9 * (pieces[0][1, 0] - pieces[0][0, 0])) and left >= 0


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("tiled", [False, True])
def test_any_small_scene_has_a_report(seed, tiled, tmp_path):
    graph, environment = random_problem(seed, tiled)
    embedding = embed(graph, environment)
    report = finish(examine_scene_steps(embedding, Questions(thorough=False)))
    assert set(report.contributions) == set(SECTIONS) - {REACH}
    assert report.numbers()["reach"]["nodes"] == embedding.n_nodes
    write_report(tmp_path, report)
    assert json.loads((tmp_path / "report.json").read_text())["title"] == "Scene"


def test_an_empty_embedding_is_said_to_be_empty(walked):
    blocked = replace(walked.environment, blocked=np.ones_like(walked.environment.blocked))
    report = finish(examine_scene_steps(embed(walked.graph, blocked), Questions(thorough=False)))
    assert report.numbers()["reach"]["covered_m2"] == 0
    assert "empty" in report.numbers()["occupancy"]["problem"]
