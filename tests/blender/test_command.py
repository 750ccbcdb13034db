"""The command line: numbers on standard output, sentences on standard error, exit codes, nothing saved unasked."""

import hashlib
import json
import shutil
import subprocess
import sys
import uuid
import zipfile
from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.cli import command
from bl_ext.user_default.wayfarer.addon.cli.scene import apply_override
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.core.evaluation.floor import floor_cells
from bl_ext.user_default.wayfarer.core.evaluation.variability import floor_variability
from dev import copy_shipped
from tests.window.blender_window import blender_root, why_not_here

ROOT = Path(__file__).resolve().parents[2]


def scene_results():
    return store.results(bpy.context.scene)


@pytest.fixture
def run(capfd):
    def run(*words):
        capfd.readouterr()
        code = command.run([str(word) for word in words])
        out, err = capfd.readouterr()
        return code, out, err

    return run


def test_evaluate_tells_the_embeddings_numbers(sample_settings, run):
    code, out, err = run("evaluate", "--json", "-")
    assert code == 0, err
    numbers = json.loads(out)
    found, scene = scene_results(), bpy.context.scene
    ways = floor_variability(found.embedding)
    floor = floor_cells(found.embedding)
    covered = found.embedding.covered().any(axis=2)
    assert numbers["embedding"]["nodes"] == found.embedding.n_nodes > 0
    assert numbers["embedding"]["links"] == found.embedding.n_links
    assert numbers["embedding"]["cells"] == list(ways.shape) and numbers["embedding"]["headings"] == 12
    assert numbers["graph"]["segments"] == len(found.graph.segments)
    assert numbers["graph"]["links"] == len(found.graph.links)
    assert numbers["graph"]["clips"] == sum(clip.use for clip in scene.wayfarer.clips)
    assert numbers["coverage"]["share"] == pytest.approx(covered.sum() / floor.sum())
    assert not (covered & ~floor).any() and floor.sum() < found.embedding.environment.free_cells().sum()
    assert numbers["coverage"]["square_metres"] == pytest.approx(covered.sum() * 0.25**2)
    assert numbers["variability"]["total"] == ways.sum() and numbers["variability"]["highest"] == ways.max()
    assert numbers["variability"]["mean"] == pytest.approx(ways[ways > 0].mean())
    # No walk of the ticked ones steps over anything.
    assert len(numbers["warnings"]) == 1 and "no ticked clip carries that tag" in numbers["warnings"][0]
    assert "Comparing frames" in err and numbers["warnings"][0] in err
    # What is there and fits is not computed again.
    embedding = found.embedding
    code, out, err = run("evaluate", "--quiet")
    assert code == 0 and scene_results().embedding is embedding
    assert f"{embedding.n_nodes:,} nodes" in out and "Reading" not in err


def test_shares_of_a_pruned_embedding_are_of_the_whole_floor(sample_settings, run):
    assert run("evaluate", "--quiet")[0] == 0
    sample_settings.tuning.k = 5
    assert bpy.ops.wayfarer.prune() == {"FINISHED"}
    code, out, _ = run("evaluate", "--json", "-")
    coverage = json.loads(out)["coverage"]
    assert code == 0 and coverage["share"] == pytest.approx(
        coverage["square_metres"] / coverage["free_square_metres"], rel=1e-3
    )


def test_settings_are_overridden(sample_settings, run, tmp_path):
    target = tmp_path / "numbers.json"
    code, out, err = run("evaluate", "--set", "cell_size=0.5", "--set", "n_headings=8", "--json", target)
    assert code == 0, err
    assert "Coverage" in out
    numbers = json.loads(target.read_text())
    assert numbers["embedding"]["cell_size"] == 0.5 and numbers["embedding"]["headings"] == 8
    assert sample_settings.environment.cell_size == 0.5


def test_report_is_written(sample_file, run, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    bpy.ops.wayfarer.refresh_clips()
    folder = tmp_path / "ein Bericht"
    coarse = ("--set", "cell_size=0.5", "--set", "n_headings=8")
    code, out, err = run("report", folder, "--json", "-", *coarse)
    assert code == 0, err
    files = json.loads(out)["report"]["files"]
    assert {"report.html", "report.json"} <= set(files) == {path.name for path in folder.iterdir()} - {".wayfarer.json"}
    assert bpy.context.scene.wayfarer.character.name in (folder / "report.html").read_text("utf-8")
    # Its own files are replaced, and no others.
    code, out, err = run("report", folder, *coarse)
    assert code == 0 and f"Report written to {folder}" in out
    (folder / "report.html").write_text("mine")
    code, out, err = run("report", folder, *coarse)
    assert code == 1 and "a 'report.html' that Wayfarer did not write" in err
    assert (folder / "report.html").read_text() == "mine"


def test_walk_is_baked_and_saved_only_where_told(sample_file, run, tmp_path):
    before = hashlib.sha256(Path(sample_file).read_bytes()).hexdigest()
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    bpy.ops.wayfarer.refresh_clips()
    out_file = tmp_path / "walk.blend"
    coarse = ("--set", "cell_size=0.25", "--set", "n_headings=12")
    code, out, err = run(
        "walk", "--seed", 7, "--duration", 4, "--from", -2, 1, "--out", out_file, "--json", "-", *coarse
    )
    assert code == 0, err
    numbers = json.loads(out)
    assert numbers["walk"]["seconds"] >= 4 and numbers["saved"] == str(out_file)
    assert np.hypot(*np.subtract(numbers["walk"]["from"], (-2, 1))) < 0.5
    assert bpy.data.filepath == sample_file
    assert hashlib.sha256(Path(sample_file).read_bytes()).hexdigest() == before
    bpy.ops.wm.open_mainfile(filepath=str(out_file))
    found, scene = scene_results(), bpy.context.scene
    assert found.walk.duration == pytest.approx(numbers["walk"]["seconds"])
    assert (scene.frame_start, scene.frame_end) == tuple(numbers["walk"]["frames"])
    assert scene.wayfarer.character.animation_data.action.name == numbers["walk"]["action"]
    assert not staleness.walk_is_stale(scene)
    # The styles of the panel: a loop ends where it began.
    code, out, err = run("walk", "--duration", 5, "--set", "style=LOOP", "--json", "-")
    assert code == 0, err
    loop = json.loads(out)["walk"]
    assert np.allclose(loop["from"], loop["to"], atol=1e-6) and loop["metres"] > 0.5
    # Over the step and to a place, from the embedding in the file.
    code, out, err = run("walk", "--from", -2, -2, "--to", 2, 3, "--json", "-")
    assert code == 0 and "Choosing cuts" not in err
    assert np.hypot(*np.subtract(json.loads(out)["walk"]["to"], (2, 3))) < 0.5
    code, out, err = run("walk", "--from", 50, 50)
    assert code == 0 and "from the place that was asked for, the nearest that can be reached" in err


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ((), "usage: wayfarer"),
        (("dance",), "invalid choice: 'dance'"),
        (("walk", "--duration", "-1"), "not more than 0"),
        (("walk", "--seed", "one"), "no whole number"),
        (("walk", "--to", "1"), "expected 2 arguments"),
        (("walk", "--to", "1", "nan"), "no number"),
        (("evaluate", "--unknown"), "unrecognized arguments"),
    ],
)
def test_a_wrong_command_line(words, complaint, run):
    code, out, err = run(*words)
    assert (code, out) == (2, "") and complaint in err


def test_help_is_what_was_asked_for(run):
    for words in (("--help",), ("evaluate", "--help"), ("walk", "--help")):
        code, out, err = run(*words)
        assert (code, err) == (0, "") and out.startswith("usage: wayfarer")


def test_what_is_wrong_with_the_scene_is_one_sentence(run, sample_file, tmp_path):
    def complaint(*words):
        code, out, err = run("evaluate", "--quiet", *words)
        assert (code, out) == (1, "")
        lines = [line for line in err.splitlines() if line.startswith("wayfarer: ")]
        assert len(lines) == 1 and lines[0].endswith("."), err
        return lines[0]

    assert "it has none" in complaint()
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    assert "no scene 'Nowhere'; the file has 'Scene'" in complaint("--scene", "Nowhere")
    assert "no armature 'Ground'" in complaint("--character", "Ground")
    assert "no setting 'size'" in complaint("--set", "size=3")
    assert "--out a name that ends in .blend" in complaint("--set", "cell_size=1", "--out", tmp_path / "walk.txt")
    assert "no folder" in complaint("--out", tmp_path / "absent" / "walk.blend")
    assert "no such folder" in complaint("--json", tmp_path / "absent" / "numbers.json")
    assert "Only a ground in parcels has workers" in complaint("--scheduler", "tcp://nowhere:8786")
    assert "'/proc/none/x.json' cannot be written" in complaint("--json", "/proc/none/x.json")
    settings.graph.max_cost = 0.001
    assert "Raise Max Cost" in complaint()
    settings.environment.ground = settings.environment.obstacles = None
    assert "no ground" in complaint()


@pytest.mark.parametrize(
    ("text", "group", "name", "value"),
    [
        ("cell_size=0.1", "environment", "cell_size", 0.1),
        (" environment.radius = 0.3 ", "environment", "radius", 0.3),
        ("tiled=yes", "environment", "tiled", True),
        ("tiled=off", "environment", "tiled", False),
        ("ground_source=typed", "environment", "ground_source", "TYPED"),
        ("ground_low=-1,-2.5", "environment", "ground_low", (-1.0, -2.5)),
        ("heading_rate=10", "embedding", "heading_rate", np.radians(10)),
        ("footprint_rule=conservative", "embedding", "footprint_rule", "CONSERVATIVE"),
        ("max_links=17", "graph", "max_links", 17),
        ("left_foot=Foot.L", "contacts", "left_foot", "Foot.L"),
    ],
)
def test_settings_by_name(text, group, name, value):
    settings = bpy.context.scene.wayfarer
    assert apply_override(settings, text) == ""
    found = getattr(getattr(settings, group), name)
    assert tuple(found) == value if isinstance(value, tuple) else found == pytest.approx(value)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("cell_size", "write NAME=VALUE"),
        ("cell_size=0", "from 0.02 to"),
        ("cell_size=inf", "finite"),
        ("max_links=1.5", "whole number"),
        ("tiled=maybe", "yes or no"),
        ("ground_low=1", "2 numbers"),
        ("ground=Nothing", "no object of that name"),
        ("threshold_mode=warm", "COST, LINKS, COVERAGE"),
        ("rna_type=1", "no setting 'rna_type'"),
        ("cel_size=1", "There is no setting 'cel_size'; say cell_size"),
        ("what=1", "There is no setting 'what'; there are ground"),
        ("house.radius=1", "no settings 'house'"),
        ("environment.height=1", "no setting 'environment.height'"),
    ],
)
def test_settings_that_make_no_sense(text, complaint):
    settings = bpy.context.scene.wayfarer
    assert complaint in apply_override(settings, text)


# ------------------------------------------------------------------------------------ in other processes


def test_through_the_bpy_module(sample_file, tmp_path):
    words = [sample_file, "--", "evaluate", "--json", "-", "--set", "cell_size=0.5", "--set", "n_headings=8"]
    script = [sys.executable, str(ROOT / "tools" / "run.py"), "command"]
    result = subprocess.run([*script, *words], capture_output=True, text=True, timeout=900)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["embedding"]["nodes"] > 0
    result = subprocess.run([*script, str(tmp_path / "no.blend"), "--", "evaluate"], capture_output=True, text=True)
    assert (result.returncode, result.stdout) == (1, "") and "There is no file" in result.stderr


def test_outputs_that_are_closed_or_full_are_one_sentence():
    script = [sys.executable, str(ROOT / "tools" / "run.py"), "command", "--", "--help"]
    for place, sentence in (
        (">&-", "Standard output is closed"),
        (">/dev/full", "cannot be written: the disk is full"),
    ):
        command = ["sh", "-c", f'exec "$@" {place}', "sh", *script]
        result = subprocess.run(command, capture_output=True, text=True, timeout=300)
        assert result.returncode == 1 and sentence in result.stderr and "Traceback" not in result.stderr


@pytest.fixture(scope="module")
def blender():
    """Runs the Blender of a whole system in a folder, with this checkout as an extension; returns a function."""
    folder = blender_root()
    if why_not_here(folder):
        pytest.skip(why_not_here(folder))
    python = next(folder.glob("usr/lib/python3.*/os.py")).parent.name
    wheel = next((ROOT / "wheels").glob(f"scipy-*-cp{python[6:].replace('.', '')}-*linux*x86_64.whl"), None)
    if wheel is None:
        pytest.skip(f"no SciPy for {python} in the folder wheels; python3 dev.py build downloads it")
    inside = Path("/tmp") / f"wayfarer-{uuid.uuid4().hex}"
    job = folder / inside.relative_to("/")
    copy_shipped(job / "extensions" / "user_default" / "wayfarer")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(job / "packages")
    enable = (
        f"import sys, addon_utils; sys.path.append('{inside}/packages'); "
        "addon_utils.enable('bl_ext.user_default.wayfarer', default_set=True)"
    )

    def run(blend, *words):
        shutil.copy(blend, job / "scene.blend")
        return subprocess.run(
            ["chroot", folder, "env", f"BLENDER_USER_RESOURCES={inside}", "HOME=/tmp", "blender", "--quiet"]
            + ["--factory-startup", f"{inside}/scene.blend", "--background", "--python-expr", enable]
            + ["--command", "wayfarer", *words],
            capture_output=True,
            text=True,
            timeout=900,
        )

    yield run
    shutil.rmtree(job)


def test_in_blender_itself(blender, sample_file):
    result = blender(sample_file, "evaluate", "--json", "-", "--set", "cell_size=0.5", "--set", "n_headings=8")
    assert result.returncode == 0, result.stdout + result.stderr
    numbers = json.loads(result.stdout.strip().splitlines()[-1])
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    assert command.run(["evaluate", "--quiet", "--set", "cell_size=0.5", "--set", "n_headings=8"]) == 0
    embedding = scene_results().embedding
    assert (numbers["embedding"]["nodes"], numbers["embedding"]["links"]) == (embedding.n_nodes, embedding.n_links)
    result = blender(sample_file, "evaluate", "--set", "size=1")
    assert result.returncode == 1 and "no setting 'size'" in result.stderr
    assert blender(sample_file, "dance").returncode == 2


def test_clips_are_exported_in_blender_itself(blender, sample_file):
    """Its commands have no window at hand, which the exporter wants."""
    out = f"/tmp/wayfarer-{uuid.uuid4().hex}"
    folder = blender_root() / out.removeprefix("/")
    words = ("export", out, "--no-table", "--set", "cell_size=0.5", "--set", "n_headings=8")
    try:
        result = blender(sample_file, *words)
        assert result.returncode == 0, result.stdout + result.stderr
        assert (folder / "clips.glb").read_bytes().startswith(b"glTF") and (folder / "embedding.npz").is_file()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
