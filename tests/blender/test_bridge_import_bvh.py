"""Motion capture files as actions of one armature."""

import os
import shutil
from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.import_bvh import import_bvh_files_steps, import_bvh_folder
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip, read_clips
from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.addon.bridge.write_action import write_clip
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion.bvh.character import understand_bvh_steps
from bl_ext.user_default.wayfarer.core.motion.bvh.reader import load_bvh_steps
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_repertoire
from bl_ext.user_default.wayfarer.core.progress import finish
from tests.core.bvh import read_bvh
from tests.core.bvh_writer import bvh_text

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("WAYFARER_DATA", ROOT.parent / "shared" / "data")) / "cmu16"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no motion data at {DATA} (see WAYFARER_DATA)")

JOINTS = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftUpLeg
  {
    OFFSET 10 -10 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -80 5
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -10 -10 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -80 5
    }
  }
  JOINT Head
  {
    OFFSET 0 60 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 20 0
    }
  }
}
"""


def bvh(n_frames=10, frame_time=0.05, seed=0, joints=JOINTS, announced=None):
    values = np.random.default_rng(seed).uniform(-60, 60, (n_frames, 15))
    lines = "\n".join(" ".join(f"{value:.4f}" for value in row) for row in values)
    return f"{joints}MOTION\nFrames: {announced or n_frames}\nFrame Time: {frame_time}\n{lines}\n"


def found_unit(path):
    [character] = finish(understand_bvh_steps([finish(load_bvh_steps(path))]))
    return character.unit


def datablocks():
    return {name: len(getattr(bpy.data, name)) for name in ("objects", "armatures", "actions", "meshes")}


@pytest.fixture
def cmu(tmp_path):
    def copied(*names):
        for name in names:
            shutil.copy(DATA / f"{name}.bvh", tmp_path)
        return tmp_path

    return copied


@needs_data
def test_same_motion_as_an_independent_reader(cmu):
    names = ["16_10", "16_16", "16_19"]
    bpy.context.scene.render.fps = 24
    armature, actions, problems = import_bvh_folder(cmu(*names))
    assert problems == [] and [action.name for action in actions] == names
    clips, problems = read_clips(armature, actions)
    assert problems == []
    for clip in clips:
        expected = read_bvh(DATA / f"{clip.name}.bvh")
        assert clip.n_frames == expected.n_frames and clip.frame_rate == expected.frame_rate == 120
        joints = [clip.skeleton.index(name) for name in expected.skeleton.names]
        assert joints[0] == 0 and sorted(joints) == list(range(31))
        np.testing.assert_allclose(clip.world[1][:, joints], expected.world[1], atol=1e-4)
        np.testing.assert_allclose(clip.ground_path, expected.ground_path, atol=1e-4)


@needs_data
def test_one_armature_for_all_files(cmu):
    scene = bpy.context.scene
    scene.render.fps, scene.frame_end = 24, 77
    armature, actions, _ = import_bvh_folder(cmu("16_16", "16_21", "16_22"))
    assert datablocks() == {"objects": 1, "armatures": 1, "actions": 3, "meshes": 0}
    assert scene.render.fps == 24 and scene.frame_end == 77
    assert armature.name in scene.collection.objects
    assert armature.animation_data.action == actions[0]
    for action in actions:
        assert action["wayfarer_frame_rate"] == 120 and action.use_fake_user
        armature.animation_data.action = action  # Blender finds the slot by itself
        assert armature.animation_data.action_slot is not None


@needs_data
def test_a_recorded_walk_survives_the_round_trip(cmu):
    armature, actions, _ = import_bvh_folder(cmu("16_16"))
    armature.location, armature.rotation_euler.z = (1, -2, 0), 0.7
    bpy.context.scene.render.fps = 120
    clip = read_clip(armature, actions[0])
    again = read_clip(armature, write_clip(armature, clip, "again"))
    np.testing.assert_allclose(again.world[1], clip.world[1], atol=1e-5)
    np.testing.assert_allclose(again.ground_path, clip.ground_path, atol=1e-5)


@needs_data
def test_scale_of_the_recordings():
    for name in ("16_16", "16_09"):
        assert found_unit(DATA / f"{name}.bvh") == 0.056444


@pytest.mark.parametrize(
    ("unit", "scale"), [(1, 0.01), (0.01, 1.0), (10, 0.001), (1 / 2.54, 0.0254), (0.01 / 0.056444, 0.056444)]
)
def test_guessed_scale(tmp_path, unit, scale):
    """The same figure of 1.7 m, written in several units."""
    joints = "\n".join(
        "OFFSET " + " ".join(str(float(word) * unit) for word in line.split()[1:]) if "OFFSET" in line else line
        for line in JOINTS.splitlines()
    )
    path = tmp_path / "figure.bvh"
    path.write_text(bvh(joints=joints + "\n"))
    assert found_unit(path) == scale


def test_scale_of_strange_units(tmp_path):
    path = tmp_path / "figure.bvh"
    path.write_text(bvh(joints=JOINTS.replace("-80 5", "-200080 5")))
    assert found_unit(path) == pytest.approx(1.7 / (200090 + 80), rel=1e-6)


def test_files_of_different_rates(tmp_path):
    (tmp_path / "a.bvh").write_text(bvh(20, 0.0083333))
    (tmp_path / "B.BVH").write_text(bvh(30, 0.0333333, seed=1))
    armature, actions, problems = import_bvh_folder(tmp_path)
    assert problems == []
    clips = {clip.name: clip for clip in read_clips(armature, actions)[0]}
    assert clips["a"].frame_rate == 120 and clips["a"].n_frames == 20
    assert clips["B"].frame_rate == 30 and clips["B"].n_frames == 30
    assert clips["a"].first_frame == 1


DAMAGED = {
    "empty": "",
    "text": "Not a BVH file at all\n",
    "cut in a line": bvh(6)[:-40],
    "cut in the skeleton": bvh(6)[:300],
    "no motion": JOINTS,
    "no frames": JOINTS + "MOTION\nFrames: 0\nFrame Time: 0.05\n",
    "one frame": bvh(1),
    "no frame time": bvh(6).replace("Frame Time: 0.05\n", ""),
    "frame time of zero": bvh(6, 0),
    "frame time in milliseconds": bvh(6, 33.3333),
    "frame time of hours": bvh(6, 1000),
    "frame time of nothing": bvh(6, 1e-9),
    "words for numbers": bvh(6).replace("OFFSET 0 60 0", "OFFSET 0 high 0"),
    "word in the motion": bvh(6)[:-5] + "nan\n",
    "not a number": bvh(6)[:-9] + " nan nan\n",
    "beyond single precision": bvh(6).replace("Frame Time: 0.05\n", "Frame Time: 0.05\n1e45" + 14 * " 0" + "\n"),
    "offset not a number": bvh(6).replace("OFFSET 0 60 0", "OFFSET 0 nan 0"),
    "unknown rotation order": bvh(6).replace("Zrotation Xrotation Yrotation", "Zrotation Zrotation Yrotation"),
    "binary": "\x00\x01\x02 HIERARCHY \x00",
}


@pytest.mark.parametrize("damage", DAMAGED)
@pytest.mark.parametrize("first", [True, False], ids=["first", "last"])
def test_damaged_files_are_reported_and_leave_nothing_behind(tmp_path, damage, first):
    (tmp_path / "good.bvh").write_text(bvh())
    bad = tmp_path / ("a bad.bvh" if first else "z bad.bvh")
    bad.write_text(DAMAGED[damage])
    armature, actions, problems = import_bvh_folder(tmp_path)
    assert armature.name == "good" and [action.name for action in actions] == ["good"]
    [(name, reason)] = problems
    assert name == bad.name and "bad" in reason and reason.endswith(".") and "Traceback" not in reason
    assert datablocks() == {"objects": 1, "armatures": 1, "actions": 1, "meshes": 0}
    assert armature.mode == "OBJECT"


@pytest.mark.parametrize(
    ("frame_time", "rate"), [("10", 0.1), ("0.00001", 100_000.0), ("10.6", None), ("0.0000099", None)]
)
def test_frame_times_at_the_limits_of_a_clip(tmp_path, frame_time, rate):
    path = tmp_path / "a.bvh"
    path.write_text(bvh(6, frame_time))
    if rate is None:
        with pytest.raises(ClipError, match=f"'a.bvh' last {frame_time} seconds each.* between 0.00001 and 10 seconds"):
            import_bvh_folder(tmp_path)
    else:
        armature, actions, problems = import_bvh_folder(tmp_path)
        assert problems == [] and read_clip(armature, actions[0]).frame_rate == rate


def test_a_byte_order_mark_is_read_over(tmp_path):
    """Of a file that is otherwise the same: the same bones and keys, the file itself untouched."""
    plain, marked = tmp_path / "plain.bvh", tmp_path / "marked.bvh"
    plain.write_text(bvh())
    marked.write_bytes(b"\xef\xbb\xbf" + plain.read_bytes())
    content = marked.read_bytes()
    armature, actions, problems = import_bvh_folder(tmp_path)
    assert problems == [] and armature.name == "marked"
    assert [action.name for action in actions] == ["marked", "plain"]
    first, second = (read_clip(armature, action) for action in actions)
    np.testing.assert_array_equal(first.rotations, second.rotations)
    np.testing.assert_array_equal(first.translations, second.translations)
    assert first.frame_rate == second.frame_rate == 20
    assert marked.read_bytes() == content and sorted(tmp_path.iterdir()) == [marked, plain]


def test_another_skeleton_is_reported(tmp_path):
    (tmp_path / "a.bvh").write_text(bvh())
    (tmp_path / "b.bvh").write_text(bvh(joints=JOINTS.replace("Head", "Skull")))
    (tmp_path / "c.bvh").write_text(bvh(seed=1))
    armature, actions, problems = import_bvh_folder(tmp_path)
    assert [action.name for action in actions] == ["a", "c"]
    [(name, reason)] = problems
    assert name == "b.bvh" and "Its skeleton is not that of 'a'" in reason and reason.endswith("by itself.")
    assert datablocks() == {"objects": 1, "armatures": 1, "actions": 2, "meshes": 0}
    assert len(read_clips(armature, actions)[0]) == 2


def test_nothing_usable(tmp_path):
    with pytest.raises(ClipError, match="no BVH files"):
        import_bvh_folder(tmp_path)
    (tmp_path / "bad.bvh").write_text("no")
    with pytest.raises(ClipError, match=r"None of the BVH files.*bad\.bvh"):
        import_bvh_folder(tmp_path)
    assert sum(datablocks().values()) == 0


def test_other_things_in_the_scene_are_left_alone(tmp_path):
    (tmp_path / "a.bvh").write_text(bvh())
    (tmp_path / "b.bvh").write_text("no")
    mesh = bpy.data.objects.new("Mesh", bpy.data.meshes.new("Mesh"))
    bpy.context.scene.collection.objects.link(mesh)
    mesh.rotation_euler.x = 1.0
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = mesh
    mesh.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    import_bvh_folder(tmp_path)
    assert mesh.mode == "OBJECT" and mesh.rotation_euler.x == 1.0
    assert datablocks() == {"objects": 2, "armatures": 1, "actions": 1, "meshes": 1}


def test_axes_and_forward(tmp_path):
    (tmp_path / "a.bvh").write_text(bvh())
    armature, _, _ = import_bvh_folder(tmp_path)
    binding = bind_rig(armature)
    assert binding.skeleton.names[0] == "Hips"
    heads = {bone.name: np.array(armature.matrix_world @ bone.head_local) for bone in armature.data.bones}
    np.testing.assert_allclose(heads["Head"] - heads["Hips"], [0, 0, 0.6], atol=1e-6)
    np.testing.assert_allclose(heads["LeftUpLeg"] - heads["Hips"], [0.1, 0, -0.1], atol=1e-6)


def by_blenders_importer(path, scale):
    """What Blender's own importer makes of a file."""
    addon_utils.enable("io_anim_bvh")
    bpy.ops.import_anim.bvh(filepath=str(path), axis_forward="-Z", axis_up="Y", global_scale=scale)
    armature = bpy.context.view_layer.objects.active
    return armature, armature.animation_data.action


def assert_same_as_blenders(path, scale):
    armature, [action], problems = import_bvh_folder(path.parent)
    assert problems == []
    clip, modes = read_clip(armature, action), [bone.rotation_mode for bone in armature.pose.bones]
    other, other_action = by_blenders_importer(path, scale)
    expected = read_clip(other, other_action, frame_rate=clip.frame_rate)
    assert clip.skeleton.is_like(expected.skeleton) and clip.n_frames == expected.n_frames
    assert clip.first_frame == expected.first_frame == 1
    assert modes == [bone.rotation_mode for bone in other.pose.bones]
    np.testing.assert_allclose(clip.world[1], expected.world[1], atol=1e-4)
    np.testing.assert_allclose(clip.ground_path, expected.ground_path, atol=1e-4)


@needs_data
@pytest.mark.parametrize("name", ["16_09", "16_16", "16_19"])
def test_recordings_as_blenders_importer_has_them(cmu, name):
    assert_same_as_blenders(cmu(name) / f"{name}.bvh", 0.056444)


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YXZ"])
def test_the_sample_as_blenders_importer_has_it(tmp_path, order):
    path = tmp_path / "walk.bvh"
    path.write_text(bvh_text(sample("walk"), order=order))
    assert_same_as_blenders(path, 0.01)


def sample(name):
    return next(clip for clip in sample_repertoire(30) if clip.name == name)


MANNERS = {
    "Z up": {"up": "Z"},
    "Y down": {"up": "-Y"},
    "inches": {"unit": 0.0254},
    "metres, Z up, folded": {"up": "Z", "unit": 1.0, "folded": "up"},
    "folded": {"folded": "left", "order": "ZYX"},
    "places on all joints": {"all_positions": True},
    "a root that stays": {"extra_root": "root"},
}


@pytest.mark.parametrize("manner", MANNERS)
def test_manners_of_programs(tmp_path, manner):
    """The motion is in its place, whatever the axes, the unit and the rest pose; and so is the body."""
    expected = sample("walk")
    (tmp_path / "walk.bvh").write_text(bvh_text(expected, **MANNERS[manner]))
    assert bpy.ops.wayfarer.import_bvh(directory=str(tmp_path)) == {"FINISHED"}
    armature = bpy.context.scene.wayfarer.character
    clip = read_clip(armature, bpy.data.actions["walk"])
    joints = [clip.skeleton.index(name) for name in expected.skeleton.names]
    np.testing.assert_allclose(clip.world[1][:, joints], expected.world[1], atol=2e-4)
    heads = {bone.name: np.array(bone.head_local) for bone in armature.data.bones}
    assert heads["Head"][2] > 1.3 and abs(heads["Hips"][0]) + abs(heads["Hips"][1]) < 1e-5
    [body] = armature.children
    points = np.array([vertex.co[:] for vertex in body.data.vertices])
    assert np.isfinite(points).all() and points[:, 2].max() > 1.5 and points[:, 2].min() > -0.15


def test_blenders_own_export(tmp_path):
    bpy.ops.wayfarer.add_sample_character()
    armature = bpy.context.scene.wayfarer.character
    expected = read_clip(armature, bpy.data.actions["walk"])
    armature.animation_data.action = bpy.data.actions["walk"]
    addon_utils.enable("io_anim_bvh")
    bpy.context.view_layer.objects.active = armature
    bpy.ops.export_anim.bvh(filepath=str(tmp_path / "walk.bvh"), frame_start=1, frame_end=expected.n_frames)
    bpy.data.batch_remove(list(bpy.data.actions))
    armature, [action], _ = import_bvh_folder(tmp_path)
    clip = read_clip(armature, action)
    joints = [clip.skeleton.index(name) for name in expected.skeleton.names]
    np.testing.assert_allclose(clip.world[1][:, joints], expected.world[1], atol=1e-3)


def test_several_rest_poses_in_a_folder_and_what_is_said(tmp_path, capfd):
    for name, manner in (("walk", {}), ("turn_left_90", {"folded": "up"}), ("arc_left", {"up": "Z", "unit": 1.0})):
        (tmp_path / f"{'b' if manner else 'a'}_{name}.bvh").write_text(bvh_text(sample(name), **manner))
    assert bpy.ops.wayfarer.import_bvh(directory=str(tmp_path)) == {"FINISHED"}
    said = capfd.readouterr().out
    assert "Y is up, lengths are in centimetres, and the character is 1.55 m tall" in said
    assert "'b_arc_left.bvh', 'b_turn_left_90.bvh' have another rest pose" in said
    assert "carried over to the skeleton of 'a_walk.bvh'" in said
    for action in bpy.data.actions:
        clip, expected = read_clip(bpy.context.scene.wayfarer.character, action), sample(action.name[2:])
        joints = [clip.skeleton.index(name) for name in expected.skeleton.names]
        np.testing.assert_allclose(clip.world[1][:, joints], expected.world[1], atol=2e-3)


def test_axis_and_scale_that_are_set(tmp_path):
    (tmp_path / "walk.bvh").write_text(bvh_text(sample("walk")))
    assert bpy.ops.wayfarer.import_bvh(directory=str(tmp_path), scale=0.02, up_axis="Z") == {"FINISHED"}
    clip = read_clip(bpy.context.scene.wayfarer.character, bpy.data.actions["walk"])
    ahead = clip.world[1][0, clip.skeleton.index("Head")] - clip.world[1][0, 0]
    assert ahead[1] == pytest.approx(2 * 0.62, abs=0.1)


def test_an_import_is_cancelled_at_any_step(tmp_path):
    for name in ("walk", "turn_left_90"):
        (tmp_path / f"{name}.bvh").write_text(bvh_text(sample(name)))
    n_steps = sum(1 for _ in import_bvh_files_steps(sorted(tmp_path.iterdir())))
    bpy.data.batch_remove([*bpy.data.objects, *bpy.data.armatures, *bpy.data.actions])
    bpy.context.view_layer.update()
    assert n_steps > 40
    for stop in range(1, n_steps, 7):
        work = import_bvh_files_steps(sorted(tmp_path.iterdir()))
        fractions = [next(work).fraction for _ in range(stop)]
        assert fractions == sorted(fractions)
        work.close()
        assert sum(datablocks().values()) == 0
