"""Motion of FBX, glTF and BVH files on one character, with files that Blender's own exporters wrote."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.bridge.import_motion import import_motion_steps
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_repertoire
from tests.core.bvh_writer import bvh_text

operators = bpy.ops.wayfarer
NAMES = ("walk", "turn_left_90", "arc_left")


def sample(name):
    return next(clip for clip in sample_repertoire(30) if clip.name == name)


def contents() -> dict:
    kinds = [prop.identifier for prop in bpy.data.bl_rna.properties if prop.type == "COLLECTION"]
    return {kind: sorted(block.name for block in getattr(bpy.data, kind)) for kind in kinds if kind != "all_ids"}


def export(path: Path, name: str, fps: int = 30, change=None, **options) -> Path:
    """Write one action of the sample character, with its mesh, a camera and a light, by Blender's exporter."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = 30
    operators.add_sample_character()
    armature, action = scene.wayfarer.character, bpy.data.actions[name]
    bpy.data.batch_remove([other for other in bpy.data.actions if other != action])
    armature.animation_data.action = action
    scene.render.fps = fps
    scene.frame_start, scene.frame_end = map(int, action.frame_range)
    for kind, data in (("Light", bpy.data.lights.new("Lamp", "POINT")), ("Camera", bpy.data.cameras.new("Camera"))):
        scene.collection.objects.link(bpy.data.objects.new(kind, data))
    if change is not None:
        change(armature)
    bpy.context.view_layer.update()
    if path.suffix == ".fbx":
        defaults = {
            "bake_anim_use_nla_strips": False,
            "bake_anim_use_all_actions": False,
            "add_leaf_bones": False,
            "bake_anim_simplify_factor": 0.0,
        }
        bpy.ops.export_scene.fbx(filepath=str(path), **defaults | options)
    else:
        export_format = "GLB" if path.suffix == ".glb" else "GLTF_SEPARATE"
        defaults = {"export_cameras": True, "export_lights": True, "export_animation_mode": "ACTIVE_ACTIONS"}
        bpy.ops.export_scene.gltf(filepath=str(path), export_format=export_format, **defaults | options)
    return path


def empty_file(fps: int = 24):
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end, scene.frame_current = fps, 3, 77, 5
    return scene


def assert_motion(character, action, name, atol=3e-3, size=1.0):
    clip, expected = read_clip(character, action), sample(name)
    shared = [joint for joint in expected.skeleton.names if joint in clip.skeleton.names]
    assert len(shared) >= expected.skeleton.n_joints - 4
    here = clip.world[1][:, [clip.skeleton.index(joint) for joint in shared]]
    there = size * expected.world[1][:, [expected.skeleton.index(joint) for joint in shared]]
    assert here.shape == there.shape
    np.testing.assert_allclose(here, there, atol=atol * max(size, 1.0))


@pytest.fixture
def files(tmp_path):
    """A folder with one file of each kind; the scene is empty again."""
    export(tmp_path / "walk.fbx", "walk")
    export(tmp_path / "turn_left_90.glb", "turn_left_90")
    (tmp_path / "arc_left.bvh").write_text(bvh_text(sample("arc_left")))
    return tmp_path


def test_all_kinds_on_one_new_character(files, capfd):
    scene = empty_file()
    assert operators.import_motion(directory=str(files)) == {"FINISHED"}
    character = scene.wayfarer.character
    assert sorted(clip.action.name for clip in scene.wayfarer.clips) == sorted(NAMES)
    for name in NAMES:
        action = bpy.data.actions[name]
        assert action["wayfarer_frame_rate"] == pytest.approx(30, abs=1e-3) and action.use_fake_user
        assert_motion(character, action, name)
    now = contents()
    assert now["objects"] == sorted(["Wayfarer Character", "Wayfarer Character Body"])
    assert now["armatures"] == [character.data.name] and len(now["meshes"]) == 1
    assert now["cameras"] == now["lights"] == [] and now["collections"] == ["Wayfarer Character"]
    assert len(now["actions"]) == 3
    assert (scene.render.fps, scene.frame_start, scene.frame_end, scene.frame_current) == (24, 3, 77, 5)
    assert character.animation_data.action is not None and not character.animation_data.nla_tracks
    assert "3 clips imported" in capfd.readouterr().out


@pytest.mark.parametrize("fps", [24, 25, 60])
@pytest.mark.parametrize("suffix", [".fbx", ".glb", ".gltf"])
def test_the_rate_of_the_file_is_kept(tmp_path, suffix, fps):
    export(tmp_path / f"walk{suffix}", "walk", fps)
    scene = empty_file(50)
    operators.import_motion(directory=str(tmp_path))
    action = bpy.data.actions["walk"]
    assert action["wayfarer_frame_rate"] == pytest.approx(fps, abs=1e-3)
    assert scene.render.fps == 50
    assert_motion(scene.wayfarer.character, action, "walk")


def large(armature):
    armature.matrix_world = Matrix.Scale(0.01, 4) @ armature.matrix_world


MANNERS = {
    "centimetres": {"global_scale": 0.01},
    "Z up": {"axis_forward": "Y", "axis_up": "Z"},
    "X up": {"axis_forward": "Z", "axis_up": "X"},
    "units in the scale": {"apply_scale_options": "FBX_SCALE_ALL"},
    "axes of bones": {"primary_bone_axis": "X", "secondary_bone_axis": "Y"},
    "with leaf bones": {"add_leaf_bones": True},
}


@pytest.mark.parametrize("manner", MANNERS)
@pytest.mark.parametrize("onto", [False, True], ids=["new", "onto the sample"])
def test_fbx_in_the_manner_of_programs(tmp_path, manner, onto):
    export(tmp_path / "walk.fbx", "walk", **MANNERS[manner])
    scene = empty_file()
    if onto:
        operators.add_sample_character()
        bpy.data.batch_remove(list(bpy.data.actions))
        before = contents()
    assert operators.import_motion(directory=str(tmp_path)) == {"FINISHED"}
    assert_motion(scene.wayfarer.character, bpy.data.actions["walk"], "walk", size=1.0 if onto else size_of(manner))
    if onto:
        assert contents() == {**before, "actions": ["walk"]}


def size_of(manner) -> float:
    return 0.01 if manner == "centimetres" else 1.0


def test_onto_a_character_that_stands_elsewhere_and_is_larger(tmp_path):
    export(tmp_path / "walk.glb", "walk")
    scene = empty_file()
    operators.add_sample_character()
    bpy.data.batch_remove(list(bpy.data.actions))
    character = scene.wayfarer.character
    character.matrix_world = Matrix.Translation((4.0, -3.0, 0.0)) @ Matrix.Scale(2.0, 4)
    operators.import_motion(directory=str(tmp_path))
    clip, expected = read_clip(character, bpy.data.actions["walk"]), sample("walk")
    joints = [clip.skeleton.index(name) for name in expected.skeleton.names]
    np.testing.assert_allclose(clip.world[1][:, joints], 2 * expected.world[1] + [4.0, -3.0, 0.0], atol=6e-3)


def test_nothing_of_the_artists_is_touched(files):
    scene = empty_file()
    operators.add_sample_character()
    character, kept = scene.wayfarer.character, bpy.data.actions["walk"]
    material, camera = bpy.data.materials.new("Mat"), bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    material.use_fake_user = True
    scene.collection.objects.link(camera)
    for obj in scene.objects:
        obj.select_set(obj == camera)
    bpy.context.view_layer.objects.active = camera
    playing, before = character.animation_data.action, contents()
    operators.import_motion(directory=str(files))
    now = contents()
    assert {kind: names for kind, names in now.items() if kind != "actions"} == {
        kind: names for kind, names in before.items() if kind != "actions"
    }
    assert set(now["actions"]) - set(before["actions"]) == {f"{name}.001" for name in NAMES}
    assert set(before["actions"]) <= set(now["actions"]) and bpy.data.actions["walk"] == kept
    assert character.animation_data.action == playing and scene.wayfarer.character == character
    assert bpy.context.view_layer.objects.active == camera and bpy.context.selected_objects == [camera]
    for name in NAMES:
        assert_motion(character, bpy.data.actions[f"{name}.001"], name)


def test_another_skeleton(tmp_path, capfd):
    """Names, size, facing and axes differ."""
    names = {"Hips": "pelvis", "Spine": "spine_01", "LeftUpLeg": "thigh_l", "RightUpLeg": "thigh_r"}
    names |= {"LeftLeg": "calf_l", "RightLeg": "calf_r", "LeftFoot": "foot_l", "RightFoot": "foot_r"}
    names |= {"LeftArm": "upperarm_l", "RightArm": "upperarm_r", "LeftForeArm": "lowerarm_l"}
    names |= {"RightForeArm": "lowerarm_r", "LeftToeBase": "ball_l", "RightToeBase": "ball_r", "Head": "skull"}

    def rename(armature):
        for old, new in names.items():
            armature.data.bones[old].name = new
        armature.matrix_world = Matrix.Rotation(np.pi / 2, 4, "Z") @ Matrix.Scale(0.5, 4)

    export(tmp_path / "walk.fbx", "walk", change=rename)
    scene = empty_file()
    operators.add_sample_character()
    bpy.data.batch_remove(list(bpy.data.actions))
    operators.import_motion(directory=str(tmp_path))
    said = capfd.readouterr().out
    assert "'walk.fbx' has another skeleton: carried over to 'Wayfarer Character'" in said and "'Head'" in said
    clip, expected = read_clip(scene.wayfarer.character, bpy.data.actions["walk"]), sample("walk")
    turned = expected.world[1] @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    joints = [name for name in expected.skeleton.names if "Head" not in name]
    np.testing.assert_allclose(
        clip.world[1][:, [clip.skeleton.index(name) for name in joints]],
        turned[:, [expected.skeleton.index(name) for name in joints]],
        atol=5e-3,
    )


def test_bad_files_spoil_nothing(files, capfd):
    fbx, glb = (files / "walk.fbx").read_bytes(), (files / "turn_left_90.glb").read_bytes()
    bad = {"empty.fbx": b"", "text.fbx": b"no FBX\n", "cut.fbx": fbx[: len(fbx) // 3], "cut.glb": glb[: len(glb) // 2]}
    bad |= {"empty.glb": b"", "text.gltf": b"{", "pointer.gltf": b'{"asset": {"version": "2.0"}, "scenes": [{}]}'}
    for name, data in bad.items():
        (files / name).write_bytes(data)
    export(files / "nobody.fbx", "walk", object_types={"CAMERA"})
    scene = empty_file()
    assert operators.import_motion(directory=str(files)) == {"FINISHED"}
    said = capfd.readouterr().out
    for name in (*bad, "nobody.fbx"):
        assert f"Left out '{name}': '{name}' " in said, name
    # What Blender itself prints is not ours.
    ours = "\n".join(line for line in said.splitlines() if line.startswith(("Warning", "Error", "Info: ")))
    assert "Traceback" not in ours and "Error:" not in ours
    assert contents()["objects"] == ["Wayfarer Character", "Wayfarer Character Body"]
    for name in NAMES:
        assert_motion(scene.wayfarer.character, bpy.data.actions[name], name)


@pytest.mark.parametrize("name", ["a.fbx", "a.glb", "a.gltf", "a.bvh"])
def test_one_bad_file_alone(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00\x01 nothing")
    empty_file()
    before = contents()
    with pytest.raises(RuntimeError, match=f"'{name}' ") as caught:
        operators.import_motion(directory=str(tmp_path), files=[{"name": name}])
    assert "Traceback" not in str(caught.value)
    assert contents() == before


def test_stopping_between_files_leaves_nothing(files):
    empty_file()
    before, paths = contents(), sorted(files.iterdir())
    n_steps = sum(1 for _ in import_motion_steps(paths))
    for stop in range(1, n_steps, max(n_steps // 6, 1)):
        scene = empty_file()
        work = import_motion_steps(paths)
        fractions = [next(work).fraction for _ in range(stop)]
        assert fractions == sorted(fractions)
        work.close()
        assert contents() == before
        assert (scene.render.fps, scene.frame_start, scene.frame_end, scene.frame_current) == (24, 3, 77, 5)


def test_the_character_is_the_file_that_has_a_body(tmp_path):
    export(tmp_path / "a.fbx", "walk", object_types={"ARMATURE"})
    export(tmp_path / "z.fbx", "arc_left")
    scene = empty_file()
    operators.import_motion(directory=str(tmp_path))
    assert contents()["objects"] == ["Wayfarer Character", "Wayfarer Character Body"]
    for name, motion in (("a", "walk"), ("z", "arc_left")):
        # Bones keep their lengths, so that small moves of joints are lost where a rest pose is another.
        assert_motion(scene.wayfarer.character, bpy.data.actions[name], motion, atol=5e-3)


def test_bones_are_no_larger_than_the_body(tmp_path):
    """Of a glTF file whose armature is scaled, as those that were made of Mixamo's FBX files."""

    def to_centimetres(armature):
        armature.data.transform(Matrix.Scale(100.0, 4))
        armature.scale = (0.01, 0.01, 0.01)

    export(tmp_path / "walk.glb", "walk", change=to_centimetres)
    scene = empty_file()
    operators.import_motion(directory=str(tmp_path))
    bpy.context.view_layer.update()
    assert 1.0 < max(scene.wayfarer.character.dimensions) < 2.5


def test_several_actions_of_one_file(tmp_path):
    bpy.context.scene.render.fps = 30
    operators.add_sample_character()
    bpy.data.batch_remove([action for action in bpy.data.actions if action.name not in NAMES])
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "all.glb"), export_animation_mode="ACTIONS")
    bpy.ops.export_scene.fbx(filepath=str(tmp_path / "all.fbx"), bake_anim_use_all_actions=True)
    for suffix in (".glb", ".fbx"):
        scene = empty_file()
        operators.import_motion(directory=str(tmp_path), files=[{"name": f"all{suffix}"}])
        assert sorted(action.name for action in bpy.data.actions) == sorted(NAMES)
        for name in NAMES:
            clip = read_clip(scene.wayfarer.character, bpy.data.actions[name])
            assert np.ptp(clip.world[1][..., 2]) > 1.0


def test_a_rig_of_constraints_is_refused(tmp_path):
    (tmp_path / "walk.bvh").write_text(bvh_text(sample("walk")))
    scene = empty_file()
    operators.add_sample_character()
    scene.wayfarer.character.pose.bones["LeftLeg"].constraints.new("IK")
    before = contents()
    with pytest.raises(RuntimeError, match="bone 'LeftLeg' is moved by constraints"):
        operators.import_motion(directory=str(tmp_path))
    assert contents() == before


def test_files_can_be_dropped_onto_the_viewport():
    handler = bpy.types.FileHandler.bl_rna_get_subclass_py("WAYFARER_FH_motion")
    assert set(handler.bl_file_extensions.split(";")) == {".bvh", ".fbx", ".glb", ".gltf"}
    assert handler.bl_import_operator == "wayfarer.import_motion"
    assert not handler.poll_drop(bpy.context)  # without a window there is no viewport
    assert {"directory", "files"} <= set(operators.import_motion.get_rna_type().properties.keys())
