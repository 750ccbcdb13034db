"""Crowds: copies of the character that walk at the same time, kept apart, and gone without a trace if not wanted."""

from itertools import combinations

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.owned import WALK_PROPERTY
from bl_ext.user_default.wayfarer.addon.results import shown
from bl_ext.user_default.wayfarer.addon.walks.crowd import CROWD_COLLECTION, crowd_walk_steps

operators = bpy.ops.wayfarer


@pytest.fixture(scope="module")
def embedded_file(sample_file, tmp_path_factory) -> str:
    """The sample in an empty hall of 8 x 8 m, embedded on a coarse grid."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    environment = settings.environment
    environment.obstacles, environment.ground_source = None, "TYPED"
    environment.ground_low, environment.ground_high = (-4.0, -4.0), (4.0, 4.0)
    environment.regions.clear()
    environment.cell_size, environment.n_headings = 0.25, 12
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc"))
    assert operators.build_motion_graph() == operators.embed() == {"FINISHED"}
    path = str(tmp_path_factory.mktemp("crowd") / "hall.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


@pytest.fixture
def settings(embedded_file, empty_scene):
    """``scene.wayfarer.walk.crowd`` of a scene that is ready for a crowd of four."""
    bpy.ops.wm.open_mainfile(filepath=embedded_file)
    found = bpy.context.scene.wayfarer.walk.crowd
    found.n_walkers, found.duration, found.spacing = 4, 4.0, 0.7
    return found


def walkers():
    collection = bpy.data.collections.get(CROWD_COLLECTION)
    return [obj for obj in collection.objects if obj.type == "ARMATURE"] if collection else []


def contents():
    scene = bpy.context.scene
    found = {
        name: sorted(block.name for block in getattr(bpy.data, name))
        for name in ("objects", "meshes", "armatures", "actions", "collections", "materials")
    }
    found["timeline"] = (scene.frame_start, scene.frame_end)
    crowd = scene.wayfarer.walk.crowd
    found["crowd"] = (crowd.n_walking, crowd.n_wanted, crowd.unserved)
    return found


def roots(frame) -> np.ndarray:
    """(N, 2) world x, y of the hips of all walkers."""
    bpy.context.scene.frame_set(frame)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    shown = [obj.evaluated_get(depsgraph) for obj in walkers()]
    return np.array([(obj.matrix_world @ obj.pose.bones["Hips"].head)[:2] for obj in shown])


def test_walkers_keep_apart_on_every_frame(settings):
    scene, character = bpy.context.scene, bpy.context.scene.wayfarer.character
    before = character.animation_data.action
    assert operators.crowd() == {"FINISHED"}
    assert (settings.n_walking, settings.n_wanted, settings.unserved) == (4, 4, "")
    assert len(walkers()) == 4
    assert character.animation_data.action == before and character.name not in {obj.name for obj in walkers()}
    # Each has an action of its own; everything else is shared.
    assert len({obj.animation_data.action.name for obj in walkers()}) == 4
    assert {obj.data for obj in walkers()} == {character.data}
    bodies = [obj for obj in bpy.data.collections[CROWD_COLLECTION].objects if obj.type == "MESH"]
    assert {obj.parent for obj in bodies} == set(walkers())
    assert len({obj.data for obj in bodies}) == 1
    assert (scene.frame_start, scene.frame_end) == (1, 1 + 4 * 30)
    closest, travelled, last = np.inf, 0.0, roots(1)
    for frame in range(1, scene.frame_end + 1, 2):
        places = roots(frame)
        closest = min(closest, min(np.linalg.norm(a - b) for a, b in combinations(places, 2)))
        travelled, last = travelled + np.linalg.norm(places - last, axis=1), places
    # Roots may leave their planned paths by a centimetre each, where two segments meet.
    assert closest >= 0.7 - 0.02
    assert settings.closest >= 0.7
    assert closest == pytest.approx(settings.closest, abs=0.1)
    assert travelled.max() > 1.0


def test_the_next_crowd_takes_the_place_of_the_last(settings):
    assert operators.crowd() == {"FINISHED"}
    first, seen = contents(), roots(30)
    settings.seed = 1
    assert operators.crowd() == {"FINISHED"}
    assert contents() == first
    assert np.abs(roots(30) - seen).max() > 0.1
    # What was moved elsewhere is the artist's, and so is an action with a fake user.
    taken, kept = walkers()[0], walkers()[1].animation_data.action
    bpy.data.collections[CROWD_COLLECTION].objects.unlink(taken)
    bpy.context.scene.collection.objects.link(taken)
    kept.use_fake_user = True
    name, action = taken.name, taken.animation_data.action.name
    settings.n_walkers = 2
    assert operators.crowd() == {"FINISHED"}
    assert len(walkers()) == 2 and kept.name in bpy.data.actions
    assert bpy.data.objects[name].animation_data.action.name == action


def test_a_crowd_can_be_removed(settings):
    with pytest.raises(RuntimeError, match="There is no crowd"):
        operators.remove_crowd()
    before = contents()
    assert operators.crowd() == {"FINISHED"}
    assert operators.remove_crowd() == {"FINISHED"}
    after = contents()
    assert {name: after[name] for name in after if name != "timeline"} == {
        name: before[name] for name in before if name != "timeline"
    }
    operators.refresh_clips()
    assert not any(WALK_PROPERTY in clip.action for clip in bpy.context.scene.wayfarer.clips)


def test_what_the_artist_lets_a_walker_play_is_not_lost(settings):
    assert operators.crowd() == {"FINISHED"}
    action = bpy.data.actions["walk"].copy()
    action.use_fake_user, action.name = False, "My Take"
    data = walkers()[0].animation_data
    data.action = action
    data.action_slot = action.slots[0]
    assert operators.remove_crowd() == {"FINISHED"}
    assert bpy.data.actions["My Take"].use_fake_user and not walkers()


def test_a_walker_that_was_chosen_as_the_character_stays(settings):
    assert operators.crowd() == {"FINISHED"}
    scene, chosen = bpy.context.scene, walkers()[0]
    name = chosen.name
    scene.wayfarer.use_others, scene.wayfarer.character = True, chosen
    for clip in scene.wayfarer.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc"))
    assert operators.build_motion_graph() == operators.embed() == operators.crowd() == {"FINISHED"}
    assert scene.wayfarer.character == bpy.data.objects[name] and chosen.children
    assert operators.remove_crowd() == {"FINISHED"}
    assert walkers() == [bpy.data.objects[name]]


def test_a_crowd_is_undone_in_one_step(settings):
    bpy.ops.ed.undo_push(message="before")
    before = contents()
    assert operators.crowd("EXEC_DEFAULT", True) == {"FINISHED"}
    assert contents() != before
    bpy.ops.ed.undo()
    assert contents() == before


@pytest.mark.parametrize("share", [0.0, 0.1, 0.6, 0.8])
def test_cancelled_it_leaves_nothing(settings, share):
    before = contents()
    steps = crowd_walk_steps(bpy.context.scene)
    reached = 0.0
    for progress in steps:
        reached = progress.fraction
        if reached >= share and (share < 0.2 or "Baking" in progress.message):
            break
    assert reached >= share
    if share > 0.5:
        assert contents() != before
    steps.close()
    assert contents() == before


def test_too_many_are_refused_or_named(settings):
    settings.n_walkers = 900
    before = contents()
    with pytest.raises(RuntimeError, match=r"Only \d+ walkers found room"):
        operators.crowd()
    assert contents() == before
    # Crammed in, some cannot take a step; who is served and who is not adds up.
    settings.n_walkers, settings.spacing, settings.duration = 36, 1.0, 2.0
    assert operators.crowd() == {"FINISHED"}
    reasons = settings.unserved.splitlines()
    assert reasons and settings.n_walking + len(reasons) == settings.n_wanted == 36
    assert all(reason.startswith("Walker ") for reason in reasons)
    assert len(walkers()) == settings.n_walking


def test_the_walk_of_the_character_stays(settings, capfd):
    walk = bpy.context.scene.wayfarer.walk
    walk.duration = 3.0
    assert operators.random_walk() == {"FINISHED"}
    action = bpy.context.scene.wayfarer.character.animation_data.action
    assert operators.crowd() == {"FINISHED"}
    assert shown.find_walk(bpy.context.scene) == action
    # It is no walker of the crowd, and may walk into one.
    assert "keeps no distance from the crowd" in capfd.readouterr().out
    assert operators.random_walk() == {"FINISHED"}
    assert len(walkers()) == 4
