"""Export for engines: a folder that the reader walks in, clips as glTF, and a scene that stays as it was."""

import json
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.export_gltf import export_clips
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import FRAME_RATE_PROPERTY
from bl_ext.user_default.wayfarer.addon.cli import command
from bl_ext.user_default.wayfarer.addon.exports.engine import CLIPS_FILE, engine_folder_steps, write_engine_folder
from bl_ext.user_default.wayfarer.addon.jobs import LongOperator
from bl_ext.user_default.wayfarer.addon.results import store
from bl_ext.user_default.wayfarer.core.errors import ExportError, StorageError
from bl_ext.user_default.wayfarer.core.export.engine_format import engine_files_steps
from bl_ext.user_default.wayfarer.core.progress import finish
from bl_ext.user_default.wayfarer.core.tuning.budget import table_bytes


def glb_content(path: Path) -> dict:
    """The JSON of a .glb file."""
    raw = path.read_bytes()
    magic, version, length, json_length, kind = struct.unpack_from("<4sIII4s", raw)
    assert (magic, version, length, kind) == (b"glTF", 2, len(raw), b"JSON")
    return json.loads(raw[20 : 20 + json_length])


def seconds_of(content: dict, animation: dict) -> tuple[float, float]:
    """First and last time of an animation."""
    inputs = {sampler["input"] for sampler in animation["samplers"]}
    return (
        min(content["accessors"][i]["min"][0] for i in inputs),
        max(content["accessors"][i]["max"][0] for i in inputs),
    )


def few_clips(settings):
    for clip in settings.clips:
        clip.use = clip.action.name in ("walk_slow", "turn_left_90", "turn_right_90", "arc_left")


def hide_character(settings):
    """No collection that the view layer shows has it."""
    for collection in settings.character.users_collection:
        children = bpy.context.view_layer.layer_collection.children
        next(child for child in children if child.collection == collection).exclude = True
    bpy.context.view_layer.update()


def embedded():
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    assert bpy.ops.wayfarer.embed() == {"FINISHED"}
    return store.results(bpy.context.scene).embedding


def scene_state():
    """Everything that an export might leave behind."""
    layer, character = bpy.context.view_layer, bpy.context.scene.wayfarer.character
    animation = character.animation_data
    return (
        sorted(action.name for action in bpy.data.actions),
        [obj.name for obj in layer.objects if obj.select_get()],
        layer.objects.active and layer.objects.active.name,
        [obj.name for obj in layer.objects if obj.hide_get()],
        animation and (animation.action and animation.action.name, [track.name for track in animation.nla_tracks]),
        sorted(bpy.data.objects.keys()),
        bpy.context.scene.frame_current_final,
    )


def test_a_folder_for_engines(sample_settings, tmp_path):
    sample_settings.graph.mirror_clips = True
    few_clips(sample_settings)
    # An action of its own rate plays as fast as it was meant to.
    slow = next(clip.action for clip in sample_settings.clips if clip.use)
    slow[FRAME_RATE_PROPERTY] = 60.0
    embedding = embedded()
    character = sample_settings.character
    character.hide_set(True)
    bpy.context.scene.frame_set(7, subframe=0.25)
    before = scene_state()
    assert bpy.ops.wayfarer.export_engine(directory=str(tmp_path)) == {"FINISHED"}
    assert scene_state() == before

    assert {path.name for path in tmp_path.iterdir()} == {
        ".wayfarer.json",
        "embedding.json",
        "embedding.npz",
        "embedding.table",
        "clips.glb",
        "README.md",
        "wayfarer_reader.py",
    }
    header = json.loads((tmp_path / "embedding.json").read_text())
    # What pruning to a budget of bytes counts is what lies on the disk.
    size = table_bytes(embedding.n_nodes, embedding.n_links)
    assert (tmp_path / "embedding.table").stat().st_size == size == header["table"]["bytes"]
    content = glb_content(tmp_path / "clips.glb")
    animations = {animation["name"]: animation for animation in content["animations"]}
    played = {segment["clip"] for segment in header["segments"]}
    assert played == set(animations) and len(played) > 3
    assert any("mirrored" in name for name in played)
    seconds = {clip["name"]: clip["seconds"] for clip in header["clips"]}
    for name, animation in animations.items():
        first, last = seconds_of(content, animation)
        # Blender samples whole frames.
        assert first == pytest.approx(0, abs=1e-4) and last == pytest.approx(seconds[name], abs=1 / 30 + 1e-3), name
    bones = {node["name"] for node in content["nodes"]}
    assert {bone.name for bone in character.data.bones} <= bones

    # The reader is run as an engine's developer would: with NumPy and nothing of ours.
    alone = {"PATH": os.environ["PATH"], "PYTHONPATH": str(Path(np.__file__).parents[1])}
    told = subprocess.run(
        [sys.executable, "-S", "wayfarer_reader.py", "."], cwd=tmp_path, env=alone, capture_output=True, text=True
    )
    assert told.returncode == 0, told.stderr
    assert told.stdout.startswith(f"{embedding.n_nodes:,} nodes")


@pytest.mark.parametrize("reached", ["", "Counting links", "Listing links", "Exporting clips", "Writing files"])
def test_cancelled_it_leaves_nothing(sample_settings, tmp_path, reached):
    """Whoever presses Esc closes the generator."""
    few_clips(sample_settings)
    sample_settings.graph.mirror_clips = reached == "Writing files"
    embedding = embedded()
    folder = tmp_path / "engine"
    before, temporary = scene_state(), set(Path(tempfile.gettempdir()).iterdir())
    steps = engine_folder_steps(bpy.context.scene, embedding, folder)
    fractions = []
    while reached:
        progress = next(steps)
        fractions.append(progress.fraction)
        assert scene_state() == before
        if progress.message == reached:
            break
    steps.close()
    assert fractions == sorted(fractions) and all(0 <= fraction <= 1 for fraction in fractions)
    assert scene_state() == before and not folder.exists()
    assert not [path for path in set(Path(tempfile.gettempdir()).iterdir()) - temporary if (path / CLIPS_FILE).exists()]


def test_the_steps_make_what_is_exported(sample_settings, tmp_path):
    """Stepped by a timer, as in a window, or at once."""
    few_clips(sample_settings)
    embedding = embedded()
    operator = bpy.types.WAYFARER_OT_export_engine
    assert issubclass(operator, LongOperator) and operator.bl_options == {"REGISTER", "UNDO"}
    told = []
    files = finish(engine_folder_steps(bpy.context.scene, embedding, tmp_path / "steps"), told.append)
    assert len(told) > 100 and told[-1].message == "Writing files"
    assert not (tmp_path / "steps").exists()
    write_engine_folder(tmp_path / "steps", files)
    assert bpy.ops.wayfarer.export_engine(directory=str(tmp_path / "operator")) == {"FINISHED"}
    written = [
        {path.name: path.read_bytes() for path in folder.iterdir()}
        for folder in (tmp_path / "steps", tmp_path / "operator")
    ]
    assert written[0] == written[1] and set(written[0]) == {*files, ".wayfarer.json"}
    # The same as ever for the embedding itself.
    made = finish(engine_files_steps(embedding))
    assert {name: written[0][name] for name in made} == made


def test_what_is_refused_is_refused_before_the_work(sample_settings, tmp_path):
    few_clips(sample_settings)
    embedding = embedded()
    scene = bpy.context.scene
    for name in (CLIPS_FILE, "embedding.table", "README.md"):
        (tmp_path / name).write_text("mine")
        with pytest.raises(StorageError, match=f"'{name}' that Wayfarer did not write"):
            next(engine_folder_steps(scene, embedding, tmp_path))
        (tmp_path / name).unlink()
    # What is left out does not matter.
    (tmp_path / CLIPS_FILE).write_text("mine")
    assert next(engine_folder_steps(scene, embedding, tmp_path, with_clips=False)).fraction == 0
    (tmp_path / CLIPS_FILE).unlink()
    hide_character(sample_settings)
    with pytest.raises(ExportError, match="include its collection"):
        next(engine_folder_steps(scene, embedding, tmp_path))
    assert not list(tmp_path.iterdir())


def test_what_else_the_character_plays_is_not_exported(sample_settings, tmp_path):
    """Tracks and actions of the rig, of its meshes and of their shape keys, muted or not."""
    few_clips(sample_settings)
    embedding = embedded()
    character = sample_settings.character
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH" and obj.find_armature() == character)
    mesh.shape_key_add(name="Basis")
    mesh.shape_key_add(name="Smile").value = 0.25
    unused = next(clip.action for clip in sample_settings.clips if not clip.use)
    playing = next(clip.action for clip in sample_settings.clips if clip.use)

    def moved(animated, path):
        """An action of its own for whatever is animated, on a track and playing."""
        animated.keyframe_insert(path, frame=1)
        animated.keyframe_insert(path, frame=20)
        action = animated.animation_data.action
        track = animated.animation_data.nla_tracks.new()
        track.strips.new("own", 1, action)

    moved(mesh, "location")
    moved(mesh.data.shape_keys.key_blocks["Smile"].id_data, 'key_blocks["Smile"].value')
    animation = character.animation_data or character.animation_data_create()
    animation.action = playing
    for name, mute in (("Idle", False), ("Muted", True), (playing.name, False)):
        track = animation.nla_tracks.new()
        track.name, track.mute = name, mute
        track.strips.new(name, 1, unused)
    before = scene_state()
    data = [sorted(collection.keys()) for collection in (bpy.data.meshes, bpy.data.armatures, bpy.data.shape_keys)]
    assert bpy.ops.wayfarer.export_engine(directory=str(tmp_path)) == {"FINISHED"}
    assert scene_state() == before
    assert data == [sorted(c.keys()) for c in (bpy.data.meshes, bpy.data.armatures, bpy.data.shape_keys)]
    assert len(mesh.animation_data.nla_tracks) == len(mesh.data.shape_keys.animation_data.nla_tracks) == 1
    content = glb_content(tmp_path / "clips.glb")
    graph = embedding.graph
    played = {graph.clips[segment.clip].name for segment in graph.segments}
    assert sorted(animation["name"] for animation in content["animations"]) == sorted(played)
    # No animation moves anything but the rig's bones and the rig.
    names = [node.get("name") for node in content["nodes"]]
    targets = {names[c["target"]["node"]] for a in content["animations"] for c in a["channels"]}
    assert targets <= {bone.name for bone in character.data.bones} | {character.name}
    # Everything has the name that it has in the scene, and hangs together as there.
    meshes = {obj.name for obj in bpy.data.objects if obj.type == "MESH" and obj.find_armature() == character}
    assert {character.name} | meshes <= set(names)
    assert not [name for name in names if name and name.endswith(".001")]
    skinned = {node["name"] for node in content["nodes"] if "skin" in node}
    assert skinned == meshes and len(content["skins"]) == 1


def test_poses_and_moves_that_are_not_keyed_stay(sample_settings, tmp_path):
    """The exporter plays frames of the scene, and whatever is animated would go where its keys are."""
    scene, character = bpy.context.scene, sample_settings.character
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    for frame in (1, 20):
        camera.location = (frame, 0.0, 0.0)
        camera.keyframe_insert("location", frame=frame)
    scene.frame_set(10)
    camera.location.x, hips = 0.1, character.pose.bones["Hips"]
    hips.location.z += 0.3
    bpy.context.view_layer.update()
    before = tuple(camera.location), tuple(hips.location), tuple(hips.rotation_quaternion)
    export_clips(
        character, [(clip.action.name, clip.action) for clip in list(sample_settings.clips)[:1]], tmp_path / "a.glb"
    )
    assert (tuple(camera.location), tuple(hips.location), tuple(hips.rotation_quaternion)) == before
    assert scene.frame_current == 10


def test_bones_keep_their_names(tmp_path):
    """Whatever the character and its meshes are called: also as a copy of them would be."""
    armature = bpy.data.armatures.new("Bone")
    character = bpy.data.objects.new("Bone", armature)
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    body = bpy.data.objects.new("Body", mesh)
    for obj in (character, body):
        bpy.context.scene.collection.objects.link(obj)
    body.parent = character
    body.shape_key_add(name="Basis")
    body.shape_key_add(name="Smile").keyframe_insert("value", frame=1)
    bpy.context.view_layer.objects.active = character
    bpy.ops.object.mode_set(mode="EDIT")
    for name in ("Bone", "Bone.001", "Body.001"):
        bone = armature.edit_bones.new(name)
        bone.tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    for frame in (1, 20):
        character.pose.bones["Bone"].keyframe_insert("location", frame=frame)
    export_clips(character, [("Wave", character.animation_data.action)], tmp_path / "clips.glb")
    content = glb_content(tmp_path / "clips.glb")
    assert sorted(node["name"] for node in content["nodes"]) == ["Body", "Body.001", "Bone", "Bone", "Bone.001"]
    assert [mesh["name"] for mesh in content["meshes"]] == ["Body"]


def test_the_root_moves_as_the_embedding_says(sample_settings, tmp_path):
    """A segment's path is that of the root bone in clips.glb, between its times."""
    few_clips(sample_settings)
    embedding = embedded()
    assert bpy.ops.wayfarer.export_engine(directory=str(tmp_path)) == {"FINISHED"}
    graph = embedding.graph
    segment = max(graph.segments, key=lambda s: np.linalg.norm(s.path[-1, :2]))
    clip = graph.clips[segment.clip]
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.context.scene.render.fps = 30
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "clips.glb"))
    rig = next(obj for obj in bpy.data.objects if obj.type == "ARMATURE")
    action = next(action for action in bpy.data.actions if action.name.startswith(clip.name))
    for track in list(rig.animation_data.nla_tracks):
        rig.animation_data.nla_tracks.remove(track)
    rig.animation_data.action = action
    rig.animation_data.action_slot = action.slots[0]
    places = []
    for second in (segment.first / graph.frame_rate, segment.last / graph.frame_rate):
        bpy.context.scene.frame_set(round(second * 30 + action.frame_range[0]))
        root = rig.pose.bones[clip.skeleton.names[0]]
        places.append(np.array((rig.matrix_world @ root.matrix).translation)[:2])
    assert np.linalg.norm(places[1] - places[0]) == pytest.approx(np.linalg.norm(segment.path[-1, :2]), abs=0.02)


def test_what_cannot_be_exported_is_said(sample_settings, tmp_path):
    few_clips(sample_settings)
    assert not bpy.ops.wayfarer.export_engine.poll()
    embedded()
    with pytest.raises(RuntimeError, match="Choose a folder"):
        bpy.ops.wayfarer.export_engine()
    in_the_way = tmp_path / "file"
    in_the_way.write_text("")
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.wayfarer.export_engine(directory=str(in_the_way / "folder"))
    hide_character(sample_settings)
    with pytest.raises(RuntimeError, match="include its collection"):
        bpy.ops.wayfarer.export_engine(directory=str(tmp_path / "out"))


def test_only_what_was_exported_before_is_replaced(sample_settings, tmp_path):
    """Engine folders and results alike."""
    embedded()
    bpy.ops.wayfarer.find_weak_spots()

    def engine():
        return bpy.ops.wayfarer.export_engine(directory=str(tmp_path), use_clips=False)

    def results():
        return bpy.ops.wayfarer.export_results(directory=str(tmp_path))

    for export, name in ((engine, "README.md"), (results, "results.json")):
        (tmp_path / name).write_text("mine")
        before = sorted(path.name for path in tmp_path.iterdir())
        with pytest.raises(RuntimeError, match=f"holds a '{name}' that Wayfarer did not write"):
            export()
        assert sorted(path.name for path in tmp_path.iterdir()) == before
        assert (tmp_path / name).read_text() == "mine"
        (tmp_path / name).unlink()
        # Twice: the second time over the first.
        assert export() == export() == {"FINISHED"}
        with open(tmp_path / name, "a") as file:
            file.write("a note of mine")
        with pytest.raises(RuntimeError, match="or that was changed since"):
            export()
        assert (tmp_path / name).read_text().endswith("a note of mine")
        (tmp_path / name).unlink()
        assert export() == {"FINISHED"}


def test_what_is_not_wanted_any_more_is_removed(sample_settings, tmp_path):
    """But only if Wayfarer wrote it, and nobody changed it."""
    few_clips(sample_settings)
    embedded()
    optional = [tmp_path / "embedding.table", tmp_path / "clips.glb"]

    def export(wanted: bool):
        return bpy.ops.wayfarer.export_engine(directory=str(tmp_path), use_clips=wanted, use_table=wanted)

    assert export(True) == {"FINISHED"} and all(path.exists() for path in optional)
    assert export(False) == {"FINISHED"} and not any(path.exists() for path in optional)
    assert json.loads((tmp_path / "embedding.json").read_text())["table"] is None
    assert export(True) == {"FINISHED"}
    for path in optional:
        path.write_text("mine")
    assert export(False) == {"FINISHED"} and all(path.read_text() == "mine" for path in optional)


def test_the_command_line_exports(sample_settings, tmp_path, capfd):
    code = command.run(["export", str(tmp_path / "engine"), "--no-clips", "--no-table", "--json", "-"])
    out, err = capfd.readouterr()
    assert code == 0, err
    numbers = json.loads(out)
    assert "embedding.npz" in numbers["export"]["files"] and "clips.glb" not in numbers["export"]["files"]
    assert (
        "embedding.table" not in numbers["export"]["files"] and not (tmp_path / "engine" / "embedding.table").exists()
    )
    assert json.loads((tmp_path / "engine" / "embedding.json").read_text())["nodes"] == numbers["embedding"]["nodes"]
