"""What was understood of a character is shown, can be chosen otherwise, and is found again."""

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def found(settings):
    body = settings.body
    return body.found_root, body.found_left, body.found_right, body.facing_words()


def test_what_was_found_is_what_the_rig_is_bound_by(settings):
    settings.refresh_clips()
    assert found(settings) == ("Hips", "LeftFoot", "RightFoot", "-Y")
    # The sample says itself where it faces.
    assert (settings.body.root, settings.body.facing) == ("", "NEGATIVE_Y")
    settings.body.facing = "GUESSED"
    assert found(settings)[3] == "-Y"
    assert settings.body.height == pytest.approx(bind_rig(settings.character).skeleton.stature)


def test_a_choice_is_kept_with_the_character_and_given_up_again(settings):
    body, character = settings.body, settings.character
    body.root, body.facing = "Spine", "X"
    assert character["wayfarer_root"] == "Spine" and tuple(character["wayfarer_forward"]) == pytest.approx((1, 0, 0))
    assert found(settings)[0] == "Spine" and found(settings)[3] == "X"
    assert bind_rig(character).skeleton.names[0] == "Spine"
    # The direction is the world's, however the object is turned.
    character.rotation_euler.z = 1.5707963
    bpy.context.view_layer.update()
    body.facing = "NEGATIVE_Y"
    assert tuple(character["wayfarer_forward"]) == pytest.approx((-1, 0, 0), abs=1e-6)
    body.root, body.facing = "", "GUESSED"
    assert "wayfarer_root" not in character and "wayfarer_forward" not in character
    assert found(settings)[0] == "Hips" and found(settings)[3] == "X"


def test_what_cannot_be_understood_is_said(settings):
    settings.character["wayfarer_root"] = "Tail"
    settings.refresh_clips()
    assert settings.body.problem.startswith("The armature") and "'Tail'" in settings.body.problem
    settings.body.root = ""
    assert settings.body.problem == "" and settings.body.found_root == "Hips"


def test_another_character_is_another_body(settings):
    other = settings.character.copy()
    other.data = settings.character.data.copy()
    bpy.context.collection.objects.link(other)
    other["wayfarer_root"] = "Spine"
    settings.character = other
    assert found(settings)[0] == "Spine"
    settings.character = None
    assert found(settings)[0] == ""
