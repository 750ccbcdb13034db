"""The reproduction of the paper as it is run: a process of its own that writes figures, a page and numbers."""

import base64
import json
import re
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

RUN = Path(__file__).resolve().parents[2] / "tools" / "run.py"
FIGURES = (
    *("figure_1", "figure_1_without_step", "figure_4_straight_12.5cm", "figure_5_k16", "figure_5_k4", "figure_6_36"),
    *("figure_6_8", "figure_7_a", "figure_7_b", "figure_8", "figure_9_tile", "figure_9_walk", "figure_10_s_hall"),
    *("figure_10_two_steps", "cost_links", "cost_area", "crowd_step_room", "motion_graph_links"),
)


def run(*arguments) -> subprocess.CompletedProcess:
    command = [sys.executable, str(RUN), "reproduce", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=900)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The folder and the numbers of a quick run on the sample character."""
    out = tmp_path_factory.mktemp("reproduce") / "out"
    result = run("--quick", "--out", out)
    assert result.returncode == 0, result.stderr
    return out, json.loads((out / "report.json").read_text())


def pixels(drawing: str, folder: Path) -> np.ndarray | None:
    """(height, width, 4) of the largest picture in an SVG drawing; None if there is none."""
    found = []
    for number, data in enumerate(re.findall(r'href="data:image/png;base64,([^"]+)"', drawing)):
        path = folder / f"{number}.png"
        path.write_bytes(base64.b64decode(data))
        image = bpy.data.images.load(str(path))
        values = np.empty(len(image.pixels), dtype=np.float32)
        image.pixels.foreach_get(values)
        found.append(values.reshape(image.size[1], image.size[0], 4))
        bpy.data.images.remove(image)
    return max(found, key=lambda picture: picture.size, default=None)


def has_color(picture, srgb) -> bool:
    return float((np.abs(picture[..., :3] - srgb).max(axis=2) < 0.02).mean()) > 0.001


def test_every_number_of_the_paper_stands_beside_ours(quick):
    _, report = quick
    rows = report["comparisons"]
    papers = " ".join(row["paper"] for row in rows)
    for number in ("55, 147", "198 k / 1.47 M", "30 minutes", "33% / 18%", "76% / 78%", "27% / 27%", "linear"):
        assert number in papers, number
    for figure in ("Fig. 4", "Fig. 5", "Fig. 6", "Fig. 7", "Fig. 8", "Fig. 9", "Fig. 10"):
        assert any(figure in row["what"] for row in rows), figure
    # Whoever sees a number that differs is told why.
    assert all(len(row["why"]) > 20 for row in rows)


def test_numbers_agree_with_each_other(quick):
    _, report = quick
    graph = report["motion_graph"]
    assert graph["nearest"]["links"] <= 147 and graph["best"]["steps_over"]
    room = report["room"]
    assert 0 < room["with_step"]["nodes"] < room["without_step"]["nodes"] and room["with_step"]["beyond_m2"] > 5
    assert room["node_share"] == pytest.approx(room["with_step"]["nodes"] / room["without_step"]["nodes"])
    k16, k4 = report["local"]["pruned"]
    assert (k16["k"], k4["k"]) == (16, 4) and k4["nodes"] < k16["nodes"] <= room["with_step"]["nodes"]
    for alike in report["local"]["as_large"]:
        assert alike["k"] > 4 and alike["beyond_m2"] > 0
    # Global pruning loses the step, and with it what lies beyond.
    coverage = report["global"]["coverage"]
    assert 0 < report["global"]["step_lost_at"] < report["global"]["segments"]
    assert coverage == sorted(coverage, reverse=True) and coverage[-1] < 0.75 * coverage[0]
    areas = report["times"]["areas_m2"]
    assert areas == sorted(areas) and 0 < areas[0] < areas[-1]
    assert report["halls"]["parts"] == 3 and report["tile"]["walk_m"] > 6
    assert report["crowds"]["step_room"]["closest_m"] >= 0.6 - 1e-6


def test_figures_show_scenes_and_walks(quick, tmp_path):
    from bl_ext.user_default.wayfarer.core.maps.colors import OBSTACLE, STEP, UNREACHED, WALK

    out, _ = quick
    drawings = {name: (out / f"{name}.svg").read_text() for name in FIGURES}
    pictures = {name: pixels(drawing, tmp_path) for name, drawing in drawings.items()}
    for name, drawing in drawings.items():
        assert drawing.startswith("<svg")
        assert drawing.count("<polyline") > 2 if pictures[name] is None else pictures[name][..., :3].std() > 0.02, name
    room = pictures["figure_1"]
    assert has_color(room, OBSTACLE) and has_color(room, STEP)
    assert f'stroke="#{bytes(round(255 * value) for value in WALK).hex()}"' in drawings["figure_1"]
    # Beyond the step, all is out of reach once the motion that steps over is gone.
    red = [(np.abs(pictures[n][..., :3] - UNREACHED).max(axis=2) < 0.02).mean() for n in ("figure_1", "figure_6_8")]
    assert red[1] > 2 * red[0] and red[1] > 0.05


def test_the_page_holds_everything(quick):
    out, report = quick
    page = (out / "report.html").read_text()
    assert page.count("<svg") >= len(FIGURES) and "<script" not in page and "198 k / 1.47 M" in page
    assert "What is missing?" in page and "What matters?" in page and "Numbers to compare by" in page
    for name in ("step_room", "tile"):
        assert (out / name / "report.html").exists() and (out / name / "capture.csv").exists()
        assert report["scenes"][name]["metrics"]["path_efficiency_mean"] > 0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [(("--clips", "{folder}/absent"), "There is no folder"), (("--clips", "{folder}"), "holds no files of motion")],
)
def test_failures_are_one_sentence(tmp_path, arguments, sentence):
    result = run(*(word.format(folder=tmp_path) for word in arguments), "--quick", "--out", tmp_path / "out")
    assert result.returncode == 1
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr and len(result.stderr.strip().splitlines()) == 1
