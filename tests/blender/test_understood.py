"""What was understood of a character is shown, can be chosen otherwise, and is found again."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.addon.results import clips
from bl_ext.user_default.wayfarer.core.motion import quat
from bl_ext.user_default.wayfarer.core.motion.clip import MotionClip
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_repertoire
from bl_ext.user_default.wayfarer.core.motion.skeleton import Skeleton
from tests.core.bvh_writer import bvh_text

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
    assert settings.body.height == pytest.approx(1.75, abs=0.05) and settings.body.found_up == "Z"


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


def test_a_height_is_set(settings):
    character = settings.character
    assert operators.set_height(height=0.9) == {"FINISHED"}
    assert settings.body.height == pytest.approx(0.9, abs=1e-4)
    assert character.scale.x == pytest.approx(0.9 / 1.75, abs=0.02) and character.scale.x == character.scale.z
    character.constraints.new("LIMIT_SCALE")
    with pytest.raises(RuntimeError, match="cannot be moved: the object has constraints"):
        operators.set_height(height=1.8)


@pytest.mark.parametrize(("axis", "degrees", "words"), [("X", 90, "-Y"), ("X", 180, "-Z"), ("Y", 90, "X")])
def test_a_rest_pose_that_lies_says_so(settings, axis, degrees, words):
    del settings.character["wayfarer_forward"]
    settings.character.matrix_world = Matrix.Rotation(np.radians(degrees), 4, axis)
    bpy.context.view_layer.update()
    settings.refresh_clips()
    assert settings.body.found_up.removesuffix(" (lies at rest)") == words
    assert settings.body.found_up.endswith("(lies at rest)")


def nameless_and_turned(clip):
    """A clip whose bones have no names and whose feet have no toes, turned by 180 degrees with its rest pose."""
    skeleton, about = clip.skeleton, quat.about("z", np.pi)
    keep = [joint for joint, name in enumerate(skeleton.names) if not name.endswith("ToeBase")]
    rotations, translations = clip.rotations[:, keep].copy(), clip.translations[:, keep].copy()
    rests, places = skeleton.rest_rotations[keep].copy(), skeleton.rest_translations[keep].copy()
    for turns, spots in ((rotations[:, 0], translations[:, 0]), (rests[0], places[0])):
        turns[...], spots[...] = quat.multiply(about, turns), quat.rotate(about, spots)
    parents = np.array([-1, *(keep.index(above) for above in skeleton.parents[keep][1:])])
    names = tuple(f"b{(7 * place) % 101}" for place in range(len(keep)))
    body = Skeleton(names, parents, rests, places, skeleton.forward)
    return MotionClip(clip.name, body, clip.frame_rate, rotations, translations)


def test_an_import_says_what_its_motion_shows_to_be_wrong(tmp_path, capfd):
    """Nameless and without toes, a body that walks towards +Y is taken to face -Y: told at import, with its remedy."""
    clip = next(clip for clip in sample_repertoire(30.0) if clip.name == "walk")
    (tmp_path / "walk.bvh").write_text(bvh_text(nameless_and_turned(clip)))
    operators.import_bvh(directory=str(tmp_path))
    scene = bpy.context.scene
    action = scene.wayfarer.clips[0].action
    assert "goes at 1" in capfd.readouterr().out
    health = clips.health_of(scene, action)
    assert [treatment[0] for treatment in health.treatments] == ["Wrong Facing"]
    operators.apply_remedy(action=action.name, finding=0)
    assert clips.health_of(scene, action).is_healthy
    walked = read_clip(scene.wayfarer.character, action)
    steps, heading = np.diff(walked.ground_path[:, :2], axis=0), walked.root_heading[:-1]
    ahead = np.sum(steps * np.column_stack([np.cos(heading), np.sin(heading)]))
    assert ahead > 0.9 * np.linalg.norm(steps, axis=1).sum()
