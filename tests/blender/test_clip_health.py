"""The clip doctor by its operators: what it finds, and that its remedies leave the artist's keys alone."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.bridge.write_action import write_clip
from bl_ext.user_default.wayfarer.addon.results import clips
from bl_ext.user_default.wayfarer.core.motion import quat
from bl_ext.user_default.wayfarer.core.motion.contacts import foot_contacts
from bl_ext.user_default.wayfarer.core.motion.in_place import missing_speed

operators = bpy.ops.wayfarer


def health(action):
    return clips.health_of(bpy.context.scene, action)


def titles(action) -> list[str]:
    return [title for title, _, _ in health(action).treatments]


def keys_of(action) -> dict:
    """Every key of an action, to the bit."""
    found = {}
    for curve in action.layers[0].strips[0].channelbag(action.slots[0]).fcurves:
        values = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
        curve.keyframe_points.foreach_get("co", values)
        found[curve.data_path, curve.array_index] = values.tobytes()
    return found


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def add_damaged(settings, name, change):
    """An action like ``name``, but with what ``change`` does to its clip; the only one that is ticked."""
    clip = change(read_clip(settings.character, bpy.data.actions[name]))
    action = write_clip(settings.character, clip, f"{name} damaged")
    settings.refresh_clips()
    for place, item in enumerate(settings.clips):
        item.use = item.action == action
        if item.use:
            settings.active_clip = place
    return action


def t_pose_first(clip):
    rotations, translations = clip.rotations.copy(), clip.translations.copy()
    rotations[0], translations[0] = clip.skeleton.rest_rotations, clip.skeleton.rest_translations
    return replace(clip, rotations=rotations, translations=translations)


def pop_inside(clip):
    rotations = clip.rotations.copy()
    joint, frame = clip.skeleton.index("LeftUpLeg"), clip.n_frames // 2
    rotations[frame, joint] = quat.multiply(rotations[frame, joint], quat.from_rotvec([0.9, 0, 0]))
    return replace(clip, rotations=rotations)


def on_the_spot(clip):
    translations = clip.translations.copy()
    translations[:, 0, :2] = translations[0, 0, :2]
    return replace(clip, translations=translations)


def too_short(clip):
    return replace(clip, rotations=clip.rotations[:12], translations=clip.translations[:12], tags={})


def contents() -> dict:
    scene = bpy.context.scene
    return {
        "actions": sorted(action.name for action in bpy.data.actions),
        "ranges": {a.name: (a.use_frame_range, tuple(a.frame_range)) for a in bpy.data.actions},
        "clips": [(clip.action.name, clip.use) for clip in scene.wayfarer.clips],
    }


# -------------------------------------------------------------------------------------------- examination


def test_the_sample_is_healthy(settings):
    for clip in settings.clips:
        clip.use = True
        assert health(clip.action) is None
    before = contents()
    assert operators.examine_clips() == {"FINISHED"}
    assert contents() == before
    for clip in settings.clips:
        assert health(clip.action).is_healthy, health(clip.action).sentences


def test_a_finding_is_told_in_words(settings):
    action = add_damaged(settings, "walk", t_pose_first)
    operators.examine_clips()
    assert titles(action) == ["Rest Pose"]
    assert f"'{action.name}'" in health(action).sentences[0]
    last = int(action.frame_range[1])
    assert health(action).treatments[0][2] == f"Trim to Frames 2-{last}"
    unticked = next(clip.action for clip in settings.clips if not clip.use)
    assert health(unticked) is None


def test_an_action_that_cannot_be_read_says_why(settings):
    action = add_damaged(settings, "walk", lambda clip: clip)
    action.use_frame_range, action.frame_start, action.frame_end = True, 5, 5
    other = next(clip for clip in settings.clips if clip.action.name == "walk_slow")
    other.use = True
    operators.examine_clips()
    assert "shorter than two frames" in health(action).problem
    assert not health(action).is_healthy
    assert health(other.action).is_healthy


def test_findings_are_for_the_keys_that_were_examined(settings):
    action = add_damaged(settings, "walk", t_pose_first)
    operators.examine_clips()
    key = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves[0].keyframe_points[5]
    value = key.co.y
    key.co.y += 0.1
    assert health(action) is None
    with pytest.raises(RuntimeError, match="examine it again"):
        operators.apply_remedy(action=action.name, finding=0)
    key.co.y = value
    assert titles(action) == ["Rest Pose"]
    settings.graph.min_segment_duration *= 2
    assert health(action) is None


# ---------------------------------------------------------------------------------------------- remedies


def test_trimming_sets_the_frame_range_only(settings):
    action = add_damaged(settings, "walk", t_pose_first)
    keys, last = keys_of(action), action.frame_range[1]
    operators.examine_clips()
    assert not action.use_frame_range
    assert operators.apply_remedy(action=action.name, finding=0) == {"FINISHED"}
    assert (action.use_frame_range, action.frame_start, action.frame_end) == (True, 2, last)
    assert keys_of(action) == keys
    assert health(action).is_healthy
    assert read_clip(settings.character, action).first_frame == 2


def test_trimming_counts_from_the_range_that_was_examined(settings):
    """A second remedy of the same action: its samples do not count from the first key any more."""
    action = add_damaged(settings, "walk", t_pose_first)
    action.use_frame_range, action.frame_start, action.frame_end = True, 1, 60
    operators.examine_clips()
    operators.apply_remedy(action=action.name, finding=0)
    assert (action.frame_start, action.frame_end) == (2, 60)


def test_splitting_leaves_out_the_pop(settings):
    action = add_damaged(settings, "walk_slower", pop_inside)
    clip = read_clip(settings.character, action)
    popped = 1 + clip.n_frames // 2
    keys = keys_of(action)
    operators.examine_clips()
    assert titles(action) == ["Pop"]
    assert operators.apply_remedy(action=action.name, finding=0) == {"FINISHED"}
    assert keys_of(action) == keys and not action.use_frame_range
    names = [clip.action.name for clip in settings.clips if clip.use]
    assert names == [f"{action.name} (part 1)", f"{action.name} (part 2)"]
    parts = [bpy.data.actions[name] for name in names]
    assert parts[0].frame_end < popped < parts[1].frame_start
    assert parts[0].frame_start == 1 and parts[1].frame_end == clip.n_frames
    for part in parts:
        assert health(part).is_healthy, health(part).sentences
        assert keys_of(part) == keys


def test_root_motion_is_baked_beside_the_action(settings):
    action = add_damaged(settings, "walk_brisk", on_the_spot)
    keys = keys_of(action)
    operators.examine_clips()
    assert titles(action) == ["No Root Motion"]
    assert operators.apply_remedy(action=action.name, finding=0) == {"FINISHED"}
    assert keys_of(action) == keys
    (moving,) = [clip.action for clip in settings.clips if clip.use]
    assert moving != action and health(moving).is_healthy
    new, original = (read_clip(settings.character, a) for a in (moving, bpy.data.actions["walk_brisk"]))
    assert missing_speed(new) < 0.1
    travelled = [np.linalg.norm(np.ptp(clip.ground_path[:, :2], axis=0)) for clip in (new, original)]
    assert travelled[0] == pytest.approx(travelled[1], rel=0.1)
    assert (foot_contacts(new).mean(axis=0) > 0.3).all()


def test_dropping_unticks(settings):
    action = add_damaged(settings, "walk", too_short)
    operators.examine_clips()
    assert titles(action) == ["Too Short"]
    assert operators.apply_remedy(action=action.name, finding=0) == {"FINISHED"}
    assert action.name in bpy.data.actions
    assert not any(clip.use for clip in settings.clips)
    assert titles(action) == ["Too Short"]


@pytest.mark.parametrize(
    ("name", "change"),
    [("walk", t_pose_first), ("walk_slower", pop_inside), ("walk_brisk", on_the_spot), ("walk", too_short)],
)
def test_a_remedy_is_undone_in_one_step(settings, name, change):
    action = add_damaged(settings, name, change)
    operators.examine_clips()
    found, name = titles(action), action.name
    bpy.ops.ed.undo_push(message="before")
    before = contents()
    operators.apply_remedy("EXEC_DEFAULT", True, action=name, finding=0)
    assert contents() != before
    bpy.ops.ed.undo()
    assert contents() == before
    # What was known before it is known again.
    assert titles(bpy.data.actions[name]) == found


def test_nothing_to_apply(settings):
    action = add_damaged(settings, "walk", t_pose_first)
    before = contents()
    with pytest.raises(RuntimeError, match="examine it again"):
        operators.apply_remedy(action=action.name, finding=0)
    operators.examine_clips()
    for missing in ({"action": action.name, "finding": 3}, {"action": "Absent", "finding": 0}):
        with pytest.raises(RuntimeError, match="examine it again"):
            operators.apply_remedy(**missing)
    assert contents() == before


# ----------------------------------------------------------------------------------------------- fix all


def t_pose_and_pop(clip):
    return t_pose_first(pop_inside(clip))


def on_the_spot_and_popping(clip):
    return on_the_spot(pop_inside(clip))


@pytest.fixture
def ill(settings):
    """Five clips with all that can be wrong with one, and a sound one, under a character that stands too high."""
    for name, change in (
        ("walk", t_pose_first),
        ("walk_slower", t_pose_and_pop),
        ("walk_brisk", on_the_spot_and_popping),
        ("arc_left", too_short),
    ):
        add_damaged(settings, name, change)
    for item in settings.clips:
        item.use = item.action.name.endswith("damaged") or item.action.name == "walk_slow"
    settings.character.location.z += 2.0
    bpy.context.view_layer.update()
    operators.examine_clips()
    return settings


def test_all_is_fixed_at_once(ill, capfd):
    keys = {clip.action.name: keys_of(clip.action) for clip in ill.clips}
    heights = [read_clip(ill.character, bpy.data.actions["walk_slow"]).world[1][..., 2].min()]
    assert operators.fix_all() == {"FINISHED"}
    used = ill.used_actions()
    assert len(used) >= 6
    for action in used:
        assert health(action).is_healthy, health(action).sentences
    heights.append(read_clip(ill.character, bpy.data.actions["walk_slow"]).world[1][..., 2].min())
    assert heights[0] - heights[1] == pytest.approx(2.0, abs=0.1)
    assert {name: keys_of(bpy.data.actions[name]) for name in keys} == keys
    said = capfd.readouterr().out
    assert "stands on the floor" in said and "1 clip dropped, 2 clips trimmed" in said
    assert "2 clips split" in said and "given root motion" in said
    assert not operators.fix_all.poll()


def test_all_that_was_fixed_is_undone_in_one_step(ill):
    bpy.ops.ed.undo_push(message="before")
    before = contents(), tuple(ill.character.location)
    operators.fix_all("EXEC_DEFAULT", True)
    assert contents() != before[0]
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert (contents(), tuple(scene.wayfarer.character.location)) == before


def test_what_would_spoil_other_clips_is_left(settings, capfd):
    """One clip that lies says nothing about the character where four others stand."""

    def lying(clip):
        turn = quat.about("x", np.pi / 2)
        rotations, translations = clip.rotations.copy(), clip.translations.copy()
        rotations[:, 0], translations[:, 0] = (
            quat.multiply(turn, rotations[:, 0]),
            quat.rotate(turn, translations[:, 0]),
        )
        return replace(clip, rotations=rotations, translations=translations)

    del settings.character["wayfarer_forward"]
    action = add_damaged(settings, "walk", lying)
    for item in settings.clips:
        item.use |= item.action.name in ("walk", "walk_slow", "arc_left", "turn_left_90")
    operators.examine_clips()
    assert titles(action) == ["Lying"]
    before = settings.character.matrix_world.copy()
    assert operators.fix_all() == {"FINISHED"}
    assert settings.character.matrix_world == before and titles(action) == ["Lying"]
    said = capfd.readouterr().out
    assert "would spoil other clips" in said and "Nothing was changed" in said


def test_a_remedy_that_fails_changes_nothing(settings):
    """Turned upright, the character would face up or down by its own property."""
    settings.character.matrix_world = Matrix.Rotation(np.pi / 2, 4, "X") @ settings.character.matrix_world
    settings.character["wayfarer_forward"] = (0.0, 0.0, 1.0)
    bpy.context.view_layer.update()
    for item in settings.clips:
        item.use = item.action.name == "walk"
    operators.examine_clips()
    assert titles(bpy.data.actions["walk"]) == ["Lying"]
    before = settings.character.matrix_world.copy()
    with pytest.raises(RuntimeError, match="no horizontal direction"):
        operators.apply_remedy(action="walk", finding=0)
    assert settings.character.matrix_world == before and titles(bpy.data.actions["walk"]) == ["Lying"]


def test_nothing_to_fix(settings):
    add_damaged(settings, "walk", t_pose_first)
    with pytest.raises(RuntimeError, match="poll"):
        operators.fix_all()
    operators.examine_clips()
    assert operators.fix_all.poll()


def test_the_icon_chooses_its_clip(settings):
    place = len(settings.clips) - 1
    assert operators.choose_clip(clip=place) == {"FINISHED"}
    assert settings.active_clip == place
    assert operators.choose_clip(clip=place + 1) == {"CANCELLED"}
    assert settings.active_clip == place
