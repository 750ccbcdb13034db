"""The demo as it is run: a process of its own that writes pictures, a file and a report."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

RUN = Path(__file__).resolve().parents[2] / "tools" / "run.py"
KEYS = {"clips", "segments", "graph_links", "nodes", "links", "coverage", "walk_seconds", "seconds"}


def run(*arguments) -> subprocess.CompletedProcess:
    command = [sys.executable, str(RUN), "demo", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=900)


def pixels(path) -> np.ndarray:
    """(height, width, 4) of a picture."""
    image = bpy.data.images.load(str(path))
    values = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def share_like(picture, srgb, tolerance=0.06) -> float:
    """Part of a picture whose pixels have nearly this colour."""
    return float((np.abs(picture[..., :3] - srgb).max(axis=2) < tolerance).mean())


def test_the_sample(tmp_path):
    out = tmp_path / "new" / "folder"
    result = run("--out", out)
    assert result.returncode == 0, result.stderr
    assert "Walking" in result.stdout and str(out / "map.png") in result.stdout

    report = json.loads((out / "report.json").read_text())
    assert set(report) >= KEYS
    assert report["nodes"] > 1000 and report["links"] > report["nodes"] and report["graph_links"] > report["segments"]
    assert 0.8 < report["coverage"] <= 1 and report["walk_seconds"] >= 60
    assert {"graph", "embed", "map", "walk"} <= set(report["seconds"])
    assert report["not_covered"] == []
    # The walk that is shown was chosen, and the report tells from which.
    defects = {tried["seed"]: tried["defects_per_minute"] for tried in report["walks_tried"]}
    assert len(defects) == 4 and defects[report["walk_seed"]] == min(defects.values()) < max(defects.values())

    from bl_ext.user_default.wayfarer.core.maps.colors import OBSTACLE, STEP, WALK

    plan = pixels(out / "map.png")
    assert share_like(plan, OBSTACLE) > 0.02 and share_like(plan, STEP) > 0.005 and share_like(plan, WALK) > 0.002
    grey = np.ptp(plan[..., :3], axis=2) < 0.03
    assert len(np.unique(plan[grey][:, 0].round(2))) > 30
    view = pixels(out / "view.png")
    orange = (view[..., 0] > 0.3) & (view[..., 1] < 0.65 * view[..., 0]) & (view[..., 2] < 0.65 * view[..., 1])
    assert orange.mean() > 0.01

    bpy.ops.wm.open_mainfile(filepath=str(out / "demo.blend"))
    scene = bpy.context.scene
    assert scene.frame_end == pytest.approx(1 + report["walk_seconds"] * 30, abs=1)
    assert len(bpy.data.scenes) == 1 and scene.camera is not None
    assert scene.wayfarer.character.animation_data.action.name == "Wayfarer Walk"
    assert not [obj.name for obj in bpy.data.objects if obj.name.startswith(("Moment", "Legend"))]
    viewports = [a.spaces.active for s in bpy.data.screens for a in s.areas if a.type == "VIEW_3D"]
    assert viewports and all(space.shading.color_type == "VERTEX" for space in viewports)


def test_a_scene_of_ones_own(tmp_path):
    bpy.ops.wayfarer.add_sample_character()
    bpy.ops.mesh.primitive_plane_add(size=6)
    settings = bpy.context.scene.wayfarer
    settings.environment.ground = bpy.context.object
    settings.environment.cell_size, settings.environment.n_headings = 0.25, 12
    settings.walk.duration = 8
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "arc"))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "own.blend"))
    n_clips = sum(clip.use for clip in settings.clips)
    result = run("--blend", tmp_path / "own.blend", "--out", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["clips"] == n_clips and 8 <= report["walk_seconds"] < 12


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--clips", "{folder}/absent"), "There is no folder"),
        (("--clips", "{folder}"), "holds no BVH files"),
        (("--blend", "{folder}/absent.blend"), "There is no file"),
        (("--blend", "{folder}/empty.blend"), "armatures is the character"),
    ],
)
def test_failures_are_one_sentence(tmp_path, arguments, sentence):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "empty.blend"))
    result = run(*(word.format(folder=tmp_path) for word in arguments), "--out", tmp_path / "out")
    assert result.returncode == 1
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr and len(result.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out" / "report.json").exists()
