"""Remedies of the character: what its walks show to be wrong is found, and mended with one button for all clips."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.addon.results import clips
from bl_ext.user_default.wayfarer.core.errors import ClipError

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    """Three clips of the sample are ticked."""
    for item in sample_settings.clips:
        item.use = item.action.name in ("walk", "turn_left_90", "arc_right")
    return sample_settings


def examined():
    operators.examine_clips()
    return {item.action.name: clips.health_of(bpy.context.scene, item.action) for item in used()}


def used():
    return [item for item in bpy.context.scene.wayfarer.clips if item.use]


def cosine(character, action):
    clip = read_clip(character, action)
    steps, heading = np.diff(clip.ground_path[:, :2], axis=0), clip.root_heading[:-1]
    ahead = np.sum(steps * np.column_stack([np.cos(heading), np.sin(heading)]))
    return ahead / np.linalg.norm(steps, axis=1).sum()


def turn(character):
    del character["wayfarer_forward"]
    character.matrix_world = Matrix.Rotation(np.pi / 2, 4, "X") @ character.matrix_world


def enlarge(character):
    character.scale = (100, 100, 100)


def sink(character):
    character.location.z = -0.5


def look_away(character):
    character["wayfarer_forward"] = (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("spoil", "title", "button"),
    [
        (turn, "Lying", "Stand Character Upright"),
        (enlarge, "Unusual Size", "Scale Character by 0.01"),
        (sink, "Not On The Floor", "Move Character to the Floor"),
        (look_away, "Wrong Facing", "Face Where the Body Does"),
    ],
)
def test_what_all_clips_show_is_mended_once(settings, spoil, title, button):
    character = settings.character
    spoil(character)
    bpy.context.view_layer.update()
    for health in examined().values():
        assert [treatment[0] for treatment in health.treatments] == [title]
        assert health.treatments[0][2] == button
    assert operators.apply_remedy(action="walk", finding=0) == {"FINISHED"}
    for item in used():
        health = clips.health_of(bpy.context.scene, item.action)
        assert health.is_healthy, health.sentences
        assert cosine(character, item.action) > 0.9
    assert all(health.is_healthy for health in examined().values())


def test_a_root_that_stays_gives_way_to_the_hips(settings):
    character = settings.character
    bpy.context.view_layer.objects.active = character
    bpy.ops.object.mode_set(mode="EDIT")
    ground = character.data.edit_bones.new("ground")
    ground.tail = (0, 0.2, 0)
    character.data.edit_bones["Hips"].parent = ground
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bind_rig(character).skeleton.names[0] == "Hips"
    character["wayfarer_root"] = "ground"
    (title, sentence, button) = examined()["walk"].treatments[0]
    assert title == "Root Stays" and "'ground'" in sentence and button == "Choose 'Hips' as Root"
    operators.apply_remedy(action="walk", finding=0)
    assert character["wayfarer_root"] == "Hips" and bind_rig(character).skeleton.names[0] == "Hips"
    assert all(health.is_healthy for health in examined().values())


@pytest.mark.parametrize("value", [5, [1.0, 2.0]])
def test_a_root_that_is_no_bone_is_named(settings, value):
    settings.character["wayfarer_root"] = value
    with pytest.raises(ClipError, match="no name of a bone; correct or remove it"):
        bind_rig(settings.character)
    settings.character["wayfarer_root"] = "tail"
    with pytest.raises(ClipError, match="'tail'"):
        bind_rig(settings.character)


def test_a_character_that_others_move_is_left_where_it_is(settings):
    character = settings.character
    sink(character)
    character.constraints.new("LIMIT_SCALE")
    examined()
    with pytest.raises(RuntimeError, match="cannot be moved: the object has constraints"):
        operators.apply_remedy(action="walk", finding=0)
