"""Studies from Blender: .blend files become arrays once, and the arrays give what the scene itself gives."""

import csv
import json
import os
from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.cli import command
from bl_ext.user_default.wayfarer.addon.cli.large_ground import evaluate_in_parcels
from bl_ext.user_default.wayfarer.addon.cli.study import read_sources
from bl_ext.user_default.wayfarer.addon.results import store
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.embedding.settings import EmbeddingSettings
from bl_ext.user_default.wayfarer.core.errors import EmbeddingError, StudyError
from bl_ext.user_default.wayfarer.core.evaluation.variability import coverage_share
from bl_ext.user_default.wayfarer.core.files import write_files
from bl_ext.user_default.wayfarer.core.study.clip_set import load_clip_set
from bl_ext.user_default.wayfarer.core.study.geometry import SceneGeometry, environment_of, load_scene
from bl_ext.user_default.wayfarer.core.study.lock import only_one
from bl_ext.user_default.wayfarer.core.study.plan import read_plan
from bl_ext.user_default.wayfarer.core.study.sources import CLIPS, SCENES, read_file


@pytest.fixture
def saved(sample_settings, tmp_path) -> Path:
    """The sample on a coarse grid, in a file of its own."""
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return file


def written(folder: Path, text: str) -> Path:
    file = folder / "study.toml"
    file.write_text(text)
    return file


def test_the_command_measures_what_the_scene_gives(saved, capfd):
    bpy.ops.wayfarer.build_motion_graph()
    bpy.ops.wayfarer.embed()
    embedding = store.results(bpy.context.scene).embedding
    share = coverage_share(embedding)
    file = written(
        saved.parent,
        """
        measures = ["nodes", "links", "coverage"]
        [scenes]
        room = "room.blend"
        ghost = "nothing.blend"
        [clips]
        hero = "room.blend"
        [settings]
        k = ["all", 2]
        """,
    )
    code = command.run(["study", str(file), "--scheduler", "processes", "--workers", "1"])
    out, err = capfd.readouterr()
    assert code == 3, err
    assert "4 cases: 2 with results" in out and "There is no file" in err and "Reading room from room.blend" in err
    rows = list(csv.DictReader((saved.parent / "study-study" / "results.csv").open()))
    whole = next(row for row in rows if row["scene"] == "room" and row["k"] == "all")
    assert (int(whole["nodes"]), int(whole["links"])) == (embedding.n_nodes, embedding.n_links)
    assert float(whole["coverage"]) == pytest.approx(share)
    assert all("There is no file" in row["problem"] for row in rows if row["scene"] == "ghost")


def test_files_are_read_once_and_again_when_they_change(saved):
    plan = read_plan(written(saved.parent, '[scenes]\nroom = "room.blend"\n[clips]\nhero = "room.blend"'))
    told = []
    read_sources(plan, saved.parent / "out", told.append)
    assert len(told) == 2
    read_sources(plan, saved.parent / "out", told.append)
    assert len(told) == 2
    status = os.stat(saved)
    os.utime(saved, ns=(status.st_atime_ns, status.st_mtime_ns + 10**9))
    read_sources(plan, saved.parent / "out", told.append)
    assert len(told) == 4
    # Neither time nor size tells of the last change.
    status, raw = os.stat(saved), saved.read_bytes()
    saved.write_bytes(raw[:-1] + bytes([raw[-1] ^ 1]))
    os.utime(saved, ns=(status.st_atime_ns, status.st_mtime_ns))
    read_sources(plan, saved.parent / "out", told.append)
    assert len(told) == 6
    saved.write_bytes(raw)
    read_sources(plan, saved.parent / "out", told.append)
    del told[4:]
    (saved.parent / "other.blend").write_bytes(saved.read_bytes())
    plan = read_plan(written(saved.parent, '[scenes]\nroom = "other.blend"\n[clips]\nhero = "room.blend"'))
    read_sources(plan, saved.parent / "out", told.append)
    assert told[4:] == ["Reading room from other.blend"]


def test_scenes_and_clips_are_chosen_by_name(saved):
    settings = bpy.context.scene.wayfarer
    settings.environment.radius, settings.embedding.position_rate = 0.33, 0.11
    settings.graph.max_cost, settings.graph.mirror_clips = 0.21, True
    region = settings.environment.regions[0]
    bpy.ops.wm.save_as_mainfile(filepath=str(saved))
    name = bpy.context.scene.name
    plan = read_plan(
        written(
            saved.parent,
            f"""
            [scenes]
            named = {{file = "room.blend", scene = "{name}"}}
            lost = {{file = "room.blend", scene = "Elsewhere"}}
            [clips]
            turns = {{file = "room.blend", actions = ["turn_*"]}}
            walks = {{file = "room.blend", actions = ["walk*"]}}
            none = {{file = "room.blend", actions = ["fly*"]}}
            other = {{file = "room.blend", character = "Nobody"}}
            """,
        )
    )
    out = saved.parent / "out"
    read_sources(plan, out, lambda text: None)
    named = plan.scenes[0]
    geometry = load_scene(read_file(out, SCENES, named))
    assert geometry.body.radius == pytest.approx(0.33) and geometry.footprint.position_rate == pytest.approx(0.11)
    assert geometry.cell_size == 0.25 and geometry.n_headings == 12 and len(geometry.obstacles) > 50
    assert geometry.regions[0].tag == region.tag and len(geometry.regions[0].triangles) > 0
    assert "no scene 'Elsewhere'" in (out / "read" / SCENES / "lost.txt").read_text()
    turns, walks, none, other = plan.clip_sets
    found = load_clip_set(read_file(out, CLIPS, turns))
    names = {clip.name for clip in found.clips}
    assert names and all(name.startswith("turn_") for name in names)
    assert any(name.endswith("(mirrored)") for name in names)
    assert found.settings.max_cost == pytest.approx(0.21)
    # What one source chose does not show in the next.
    names = {clip.name for clip in load_clip_set(read_file(out, CLIPS, walks)).clips}
    assert names and all(name.startswith("walk") for name in names)
    assert not read_file(out, CLIPS, none).exists() and not read_file(out, CLIPS, other).exists()
    assert "in use" in (out / "read" / CLIPS / "none.txt").read_text()
    assert "no armature 'Nobody'" in (out / "read" / CLIPS / "other.txt").read_text()
    assert np.isfinite(geometry.obstacles).all()


def test_mistakes_are_said(saved, capfd):
    assert command.run(["study", str(saved.parent / "nothing.toml")]) == 1
    assert "cannot be read" in capfd.readouterr().err
    file = written(saved.parent, '[scenes]\nroom = "room.blend"\n[clips]\nhero = "room.blend"\n[settings]\nradios = 1')
    assert command.run(["study", str(file)]) == 1
    assert "There is no setting 'radios'" in capfd.readouterr().err
    good = written(saved.parent, '[scenes]\nroom = "room.blend"\n[clips]\nhero = "room.blend"')
    assert command.run(["study", str(good), "--workers", "0"]) == 1
    assert "0 workers" in capfd.readouterr().err


def test_what_could_not_be_read_is_tried_again(saved):
    plan = read_plan(written(saved.parent, '[scenes]\nroom = "room.blend"\n[clips]\nhero = "room.blend"'))
    raw = saved.read_bytes()
    status = os.stat(saved)
    # Damaged for a moment, but of the same size and age: as a share that was away.
    saved.write_bytes(bytes(len(raw)))
    os.utime(saved, ns=(status.st_atime_ns, status.st_mtime_ns))
    told, out = [], saved.parent / "out"
    read_sources(plan, out, told.append)
    assert "cannot be opened" in (out / "read" / SCENES / "room.txt").read_text()
    saved.write_bytes(raw)
    os.utime(saved, ns=(status.st_atime_ns, status.st_mtime_ns))
    read_sources(plan, out, told.append)
    assert len(told) == 4 and not (out / "read" / SCENES / "room.txt").exists()
    assert len(load_scene(read_file(out, SCENES, plan.scenes[0])).obstacles) > 50
    read_sources(plan, out, told.append)
    assert len(told) == 4


def test_scenes_are_read_again_by_another_version(saved):
    plan = read_plan(written(saved.parent, '[scenes]\nroom = "room.blend"\n[clips]\nhero = "room.blend"'))
    told, out = [], saved.parent / "out"
    read_sources(plan, out, told.append)
    states = out / "read" / "states.json"
    known = json.loads(states.read_text())
    known["scenes/room"]["asked"][-1] = "another"
    write_files(out, {"read/states.json": json.dumps(known).encode()})
    read_sources(plan, out, told.append)
    assert told[2:] == ["Reading room from room.blend"]


# ------------------------------------------------------------------------------------------------ large grounds


def evaluated(*words, capfd) -> dict:
    code = command.run(["evaluate", "--json", "-", *map(str, words)])
    out, err = capfd.readouterr()
    assert code == 0, err
    return json.loads(out)


def test_a_ground_in_parcels_is_what_one_process_finds(saved, capfd):
    """Two workers, through the command line's front door."""
    settings = bpy.context.scene.wayfarer
    settings.environment.n_headings = 8
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left_90", "turn_right_90"))
    whole = evaluated("--quiet", capfd=capfd)
    folder = saved.parent / "parcels"
    words = ["--parcels", "3.5", "--scheduler", "processes", "--workers", "2", "--out", folder]
    found = evaluated(*words, capfd=capfd)
    for part in ("scene", "character", "graph", "embedding", "coverage", "variability"):
        assert found[part] == whole[part], part
    assert found["embedding"]["nodes"] > 0 and "saved" not in found
    assert found["parcels"]["folder"] == str(folder)
    pictures = [folder / name for name in found["parcels"]["maps"]]
    assert sorted(picture.name for picture in pictures) == ["coverage.png", "variability.png"]
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    with np.load(pictures[0].with_name("maps.npz")) as maps:
        assert int(maps["variability"].sum()) == whole["variability"]["total"]
    assert (folder / "results.csv").exists() and (folder / "results.html").exists()
    tiles = list(folder.glob("large/*/maps/*.npz"))
    assert len(tiles) > 1
    # Again, nothing is left to do: not even the tiles are needed.
    for tile in tiles:
        tile.unlink()
    assert evaluated(*words, capfd=capfd)["embedding"] == whole["embedding"]


def test_mistakes_with_parcels_are_said(saved, capfd, tmp_path):
    # In Unicode beyond its first 65,536 characters, too.
    bpy.context.scene.name = "\U0001d4d0 \U00020bb7"
    for words, sentence in [
        (["--parcels", "2.5"], "say --out FOLDER"),
        (["--parcels", "2.5", "--out", str(tmp_path / "a.blend")], "is no folder"),
        (["--workers", "2"], "say --parcels METRES"),
        (["--parcels", "2.5", "--workers", "0", "--out", str(tmp_path / "p")], "0 workers"),
        (["--parcels", "2.5", "--out", str(saved.parent)], "holds something else"),
        (["--parcels", "0.3", "--out", str(tmp_path / "small"), "--quiet"], "longest step"),
    ]:
        assert command.run(["evaluate", *words]) == 1
        # Its last line, not only that of a program that it started.
        told = capfd.readouterr().err.splitlines()[-1]
        assert told.startswith("wayfarer: ") and sentence in told, words
    assert not list(saved.parent.glob(".*lock"))
    graph = store.results(bpy.context.scene).graph
    with pytest.raises(StudyError, match="longest step"):
        evaluate_in_parcels(
            bpy.context.scene, graph, 0.3, tmp_path / "small", "--scheduler", "processes", "--workers", "1"
        )
    with pytest.raises(EmbeddingError, match=r"evaluate --parcels METRES --out FOLDER"):
        embed(
            store.results(bpy.context.scene).graph, environment_of(small_scene(), {}), EmbeddingSettings(memory_limit=1)
        )


def test_a_second_evaluation_in_parcels_changes_nothing_under_the_first(saved, tmp_path):
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    scene, graph = bpy.context.scene, store.results(bpy.context.scene).graph
    # Another one's Blender, before and after its program works, and that program without it.
    for lock in (".evaluate.lock", ".lock"):
        folder = tmp_path / lock.strip(".")
        folder.mkdir()
        (folder / "parcels.toml").write_text("the first's")
        with only_one(folder, lock), pytest.raises(StudyError, match="Another study works in"):
            evaluate_in_parcels(scene, graph, 4.0, folder)
        assert (folder / "parcels.toml").read_text() == "the first's"
        assert not list(folder.glob("*.npz"))


def small_scene() -> SceneGeometry:
    return SceneGeometry(np.empty((0, 3, 3)), (0.0, 0.0), (4.0, 4.0))
