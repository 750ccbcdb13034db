"""A new walk takes the place of the one before it, unless the artist has use for that."""

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.owned import WALK_PROPERTY

operators = bpy.ops.wayfarer


@pytest.fixture
def walked(sample_file):
    """The character of a scene in which a walk has been baked."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    settings.environment.cell_size, settings.environment.n_headings = 0.25, 12
    settings.walk.duration = 5.0
    for step in ("build_motion_graph", "embed", "random_walk"):
        assert getattr(operators, step)() == {"FINISHED"}
    return settings.character


def walks():
    return [action for action in bpy.data.actions if WALK_PROPERTY in action]


def keep_by_name(action, character):
    action.name = "Keep"


def keep_by_longer_name(action, character):
    action.name += " to the door"


def keep_by_fake_user(action, character):
    action.use_fake_user = True


def keep_by_strip(action, character):
    character.animation_data.nla_tracks.new().strips.new("Walk", 1, action)


def test_a_walk_replaces_the_one_before(walked):
    assert operators.random_walk() == {"FINISHED"}
    assert len(walks()) == 1
    assert walked.animation_data.action in walks()


@pytest.mark.parametrize("keep", [keep_by_name, keep_by_longer_name, keep_by_fake_user, keep_by_strip])
def test_a_walk_that_is_kept_survives(walked, keep):
    kept = walked.animation_data.action
    keep(kept, walked)
    name = kept.name
    assert operators.random_walk() == {"FINISHED"}
    assert name in bpy.data.actions
    assert len(walks()) == 2
    assert walked.animation_data.action != bpy.data.actions[name]


def test_a_walk_replaces_that_of_a_copied_scene(walked):
    """The copied character has a name of its own, and plays a copy of the walk that names the other one."""
    bpy.ops.scene.new(type="FULL_COPY")
    character = bpy.context.scene.wayfarer.character
    assert character != walked and len(walks()) == 2
    for step in ("build_motion_graph", "embed", "random_walk"):
        assert getattr(operators, step)() == {"FINISHED"}
    assert {action[WALK_PROPERTY] for action in walks()} == {walked.name, character.name}
    assert len(walks()) == 2 and walked.animation_data.action != character.animation_data.action


@pytest.mark.parametrize("output", ["ACTION", "STRIPS", "COPY"])
def test_a_walk_leaves_no_trace_in_the_next(walked, output):
    """A bone that only the earlier walk keyed starts from rest; what no walk ever keyed is the artist's."""
    action = walked.animation_data.action
    curve = action.fcurve_ensure_for_datablock(walked, 'pose.bones["Head"].location', index=2)
    curve.keyframe_points.insert(1.0, 0.1)
    bpy.context.scene.frame_set(2)
    posed = walked.pose.bones["Neck"]
    posed.location = 0.0, 0.0, 0.02
    assert walked.pose.bones["Head"].location.z == pytest.approx(0.1)
    bpy.context.scene.wayfarer.walk.output = output
    assert operators.random_walk() == {"FINISHED"}
    walker = walked
    if output == "COPY":
        walker = next(obj for obj in bpy.data.collections["Wayfarer Copy"].objects if obj.type == "ARMATURE")
        assert walked.pose.bones["Head"].location.z == pytest.approx(0.1)  # the character itself stays as it is
    assert walker.pose.bones["Head"].location.length == 0
    assert walker.pose.bones["Neck"].location.z == pytest.approx(0.02)
