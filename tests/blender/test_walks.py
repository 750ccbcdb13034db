"""Walks in every style, into every output: they go where they are told to, and nothing else changes."""

import math
import shutil
from itertools import pairwise

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.owned import WALK_PROPERTY
from bl_ext.user_default.wayfarer.addon.results import shown, store
from bl_ext.user_default.wayfarer.addon.scene.motion_fingerprint import action_fingerprint
from bl_ext.user_default.wayfarer.addon.walks.baking import COPY_COLLECTION
from bl_ext.user_default.wayfarer.addon.walks.curve_points import curve_points
from bl_ext.user_default.wayfarer.addon.walks.request import read_request
from bl_ext.user_default.wayfarer.core.errors import WalkError
from bl_ext.user_default.wayfarer.core.evaluation.goals import goal_at
from bl_ext.user_default.wayfarer.core.playback.directed import walk_through_steps
from bl_ext.user_default.wayfarer.core.playback.quality import walk_quality
from bl_ext.user_default.wayfarer.core.playback.synthesis import synthesize
from bl_ext.user_default.wayfarer.core.progress import finish

operators = bpy.ops.wayfarer
COLLECTIONS = ("objects", "meshes", "armatures", "actions", "collections", "curves", "materials")


@pytest.fixture(scope="module")
def embedded_file(sample_file, tmp_path_factory) -> str:
    """The sample on a coarse grid with walks, turns and the step, embedded."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    settings.environment.cell_size, settings.environment.n_headings = 0.25, 12
    settings.graph.min_segment_duration, settings.graph.max_cost = 0.5, 0.5  # more links than by default
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc", "step_over"))
    assert operators.build_motion_graph() == operators.embed() == {"FINISHED"}
    path = str(tmp_path_factory.mktemp("walks") / "embedded.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


@pytest.fixture
def settings(embedded_file, empty_scene):
    """``scene.wayfarer.walk`` of a scene that is ready for walks."""
    bpy.ops.wm.open_mainfile(filepath=embedded_file)
    found = bpy.context.scene.wayfarer.walk
    found.duration = 5.0
    return found


def scene_results():
    return store.results(bpy.context.scene)


def character():
    return bpy.context.scene.wayfarer.character


def walked(settings, **given):
    """The walk, after choosing settings."""
    for name, value in given.items():
        setattr(settings, name, value)
    bpy.context.view_layer.update()
    assert operators.random_walk() == {"FINISHED"}
    return scene_results().walk


def refused(settings, **given) -> str:
    """What is said about a walk that cannot be, which leaves all as it was."""
    for name, value in given.items():
        setattr(settings, name, value)
    bpy.context.view_layer.update()
    before = contents()
    with pytest.raises(RuntimeError) as error:
        operators.random_walk()
    assert contents() == before
    return str(error.value)


def empty(name, x, y, turned=0.0, collection=None):
    obj = bpy.data.objects.new(name, None)
    obj.location, obj.rotation_euler.z = (x, y, 0.0), turned
    (collection or bpy.context.scene.collection).objects.link(obj)
    return obj


def contents() -> dict:
    """Everything in the file that a walk could leave behind."""
    scene, animation = bpy.context.scene, character().animation_data
    found = {name: sorted(block.name for block in getattr(bpy.data, name)) for name in COLLECTIONS}
    found["timeline"] = (scene.frame_start, scene.frame_end, [marker.name for marker in scene.timeline_markers])
    found["action"] = animation.action.name if animation.action else None
    found["tracks"] = [(track.name, len(track.strips), track.mute) for track in animation.nla_tracks]
    found["worst"] = len(scene.wayfarer.walk.report.worst)
    found["place"] = [round(x, 5) for row in character().matrix_basis for x in row]
    return found


def own_actions() -> dict:
    """The artist's actions, and what is in them."""
    scene = bpy.context.scene
    return {a.name: action_fingerprint(scene, a) for a in bpy.data.actions if WALK_PROPERTY not in a}


def heads(obj, frame) -> np.ndarray:
    """(J, 3) world positions of the bones of an armature on a frame."""
    bpy.context.scene.frame_set(frame)
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([shown.matrix_world @ bone.head for bone in shown.pose.bones])


def root(walk, sample) -> np.ndarray:
    return walk.root_path[sample, :2]


# ------------------------------------------------------------------------------------------------ styles


@pytest.mark.parametrize(("facing", "expected"), [("X", 180.0), ("NEGATIVE_Y", 90.0)])
def test_the_quickest_way_to_an_object_facing_as_it_does(settings, facing, expected):
    start, goal = empty("Start", -1.0, -2.5), empty("Goal", 1.5, 0.0, math.pi)
    walk = walked(
        settings,
        style="PLACE",
        start="OBJECT",
        start_object=start,
        target="OBJECT",
        target_object=goal,
        nearness=0.4,
        facing=facing,
        facing_tolerance=0.3,
        smoothness=0.0,
    )
    assert np.linalg.norm(root(walk, 0) - (-1.0, -2.5)) < 0.25
    assert np.linalg.norm(root(walk, -1) - (1.5, 0.0)) <= 0.4
    off = math.degrees(walk.root_path[-1, 2]) - expected
    assert abs((off + 180) % 360 - 180) <= math.degrees(0.3) + 1e-6
    # Any facing is quicker, and as quick as the core says from the best node of the same place.
    free = walked(settings, facing="ANY")
    x, y = free.states[0, :2]
    place = free.embedding.environment.grid.positions(np.array([x, y]))
    best = finish(
        walk_through_steps(free.embedding, goal_at(free.embedding, place), [goal_at(free.embedding, (1.5, 0.0), 0.4)])
    )
    assert free.duration == best.duration <= walk.duration
    smooth = walked(settings, smoothness=1.0)
    assert best.duration <= smooth.duration <= 2 * best.duration
    assert np.linalg.norm(root(smooth, -1) - (1.5, 0.0)) <= 0.4


def test_waypoints_are_passed_in_the_order_of_their_numbers(settings):
    collection = bpy.data.collections.new("Way")
    bpy.context.scene.collection.children.link(collection)
    places = {"Point 10": (0.5, 0.5), "Point 2": (-0.5, -2.5), "Point 9": (1.5, -1.0)}
    for name, place in places.items():
        empty(name, *place, collection=collection)
    walk = walked(settings, style="WAYPOINTS", waypoints=collection, nearness=0.3)
    at_seams = walk.root_path[walk.node_frames, :2]
    passed = 0
    for name in ("Point 2", "Point 9", "Point 10"):
        near = np.flatnonzero(np.linalg.norm(at_seams[passed:] - places[name], axis=1) <= 0.3)
        assert len(near), name
        passed += near[0]
    assert passed == len(at_seams) - 1


def drawn_curve(kind="BEZIER", points=((-1.0, -2.5), (0.3, -2.3), (0.6, -1.4), (0.2, -0.2)), cyclic=False):
    curve = bpy.data.curves.new("Path", "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new(kind)
    own = spline.bezier_points if kind == "BEZIER" else spline.points
    own.add(len(points) - 1)
    for point, (x, y) in zip(own, points, strict=True):
        point.co = (x, y, 1.0) if kind == "BEZIER" else (x, y, 1.0, 1.0)
        if kind == "BEZIER":
            point.handle_left_type = point.handle_right_type = "AUTO"
    spline.use_cyclic_u = cyclic
    obj = bpy.data.objects.new("Path", curve)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def test_a_curve_is_followed_from_its_first_point_to_its_last(settings):
    curve = drawn_curve()
    walk = walked(settings, style="CURVE", path_curve=curve, path_width=0.6)
    line = curve_points(curve)
    dense = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(line)])
    away = np.linalg.norm(walk.root_path[:, None, :2] - dense, axis=2)
    assert away.min(axis=1).max() <= 0.6 + 0.05
    assert away[0].argmin() < 0.2 * len(dense) and away[-1].argmin() > 0.95 * len(dense)


@pytest.mark.parametrize("cyclic", [False, True])
def test_points_of_a_curve_are_those_that_blender_draws(cyclic):
    curve = drawn_curve(cyclic=cyclic)
    curve.location, curve.rotation_euler.z, curve.scale = (2.0, 1.0, 0.0), 0.5, (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    mesh = curve.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    drawn = np.array([curve.matrix_world @ vertex.co for vertex in mesh.vertices])[:, :2]
    curve.data.bevel_depth, curve.data.extrude = 0.1, 0.2
    n_curves, n_objects = len(bpy.data.curves), len(bpy.data.objects)
    found = curve_points(curve)
    np.testing.assert_allclose(found[: len(drawn)], drawn, atol=1e-5)
    assert len(found) == len(drawn) + cyclic
    if cyclic:
        np.testing.assert_array_equal(found[-1], found[0])
    assert (len(bpy.data.curves), len(bpy.data.objects)) == (n_curves, n_objects)
    curve.data.splines.new("POLY")
    with pytest.raises(WalkError, match="has 2 splines"):
        curve_points(curve)


def test_a_loop_can_be_repeated(settings):
    walk = walked(settings, style="LOOP", duration=4.0)
    assert np.array_equal(walk.states[0], walk.states[-1])
    scene, action = bpy.context.scene, character().animation_data.action
    assert scene.frame_end == walk.node_frames[-1]  # the frame after it is the first
    assert action.use_cyclic and tuple(action.frame_range) == (1, scene.frame_end + 1)
    first, last, after = (heads(character(), frame) for frame in (1, scene.frame_end, scene.frame_end + 1))
    np.testing.assert_allclose(first, after, atol=1e-4)
    assert 1e-4 < np.abs(last - after).max() < 0.2


def test_a_motion_is_performed_at_a_place(settings):
    bpy.context.scene.cursor.location = (0.0, 1.45, 0.0)
    given = {"style": "PERFORM", "action_kind": "TAG", "action_tag": "step", "target": "CURSOR", "nearness": 0.5}
    walk = walked(settings, **given)
    segment = walk.embedding.graph.segments[walk.segments[-1]]
    assert "step" in segment.tags
    assert np.linalg.norm(walk.root_path[walk.node_frames[-2] :, :2] - (0.0, 1.45), axis=1).min() <= 0.5
    clip = next(c.name for c in walk.embedding.graph.clips if c.name.startswith("turn_left"))
    bpy.context.scene.cursor.location = (0.5, -1.0, 0.0)
    walk = walked(settings, action_kind="CLIP", action_clip=clip, nearness=1.5)
    assert walk.embedding.graph.clips[walk.embedding.graph.segments[walk.segments[-1]].clip].name == clip
    longer = walked(settings, walk_on=True, duration=walk.duration + 4.0)
    assert longer.duration >= walk.duration + 4.0
    assert np.array_equal(longer.states[: len(walk) + 1], walk.states)


def test_clips_are_played_as_they_are_weighted(settings):
    def share(name):
        graph = scene_results().embedding.graph
        played = [graph.clips[graph.segments[s].clip].name for s in scene_results().walk.segments]
        return sum(clip == name for clip in played) / len(played)

    given = {"style": "RANDOM", "weighting": "CLIPS", "duration": 60.0, "hold_feet": False}
    walked(settings, **given)
    clips = {clip.action.name: clip for clip in bpy.context.scene.wayfarer.clips if clip.use}
    name = max(clips, key=share)
    usual = share(name)
    clips[name].weight = 0.0
    operators.refresh_clips()
    assert next(c.weight for c in bpy.context.scene.wayfarer.clips if c.action.name == name) == 0.0
    walked(settings)
    # Where nothing else can follow, it is played all the same.
    assert share(name) < 0.75 * usual


def test_each_weighting_makes_another_walk(settings):
    walks = [
        walked(settings, style="RANDOM", weighting=kind, duration=60.0, hold_feet=False).states.tolist()
        for kind in ("LINKS", "GOODNESS", "VARIABILITY", "PLACES")
    ]
    assert all(a != b for i, a in enumerate(walks) for b in walks[:i])


# -------------------------------------------------------------------------------------------- impossible


def test_what_is_missing_is_said(settings):
    assert "Choose the object to start from" in refused(settings, start="OBJECT")
    settings.start = "RANDOM"
    assert "Choose the object to go to" in refused(settings, style="PLACE", target="OBJECT")
    assert "Choose a collection of waypoints" in refused(settings, style="WAYPOINTS")
    assert "has no objects to pass" in refused(settings, waypoints=bpy.data.collections.new("Nothing"))
    assert "Choose a curve" in refused(settings, style="CURVE")
    assert "Choose the clip" in refused(settings, style="PERFORM", target="CURSOR")
    assert "no segment" in refused(settings, action_clip="yawn").lower()


def test_what_is_impossible_is_said(settings):
    goal = empty("Far Away", 50.0, 0.0)
    given = {"style": "PLACE", "target": "OBJECT", "target_object": goal}
    assert "'Far Away': The goal at (50.0, 0.0) m lies off the ground" in refused(settings, **given)
    pillar = bpy.data.objects["Pillar A"]
    assert "something stands there" in refused(settings, target_object=pillar, nearness=0.0)
    goal.location, goal.rotation_euler.y = (1.5, 0.0, 0.0), math.pi / 2
    assert "straight up or down" in refused(settings, target_object=goal, facing="X", nearness=0.3)
    curve = drawn_curve("POLY", [(-1.5, -2.5), (-1.5, 30.0)])
    assert "No walk follows the curve" in refused(settings, style="CURVE", path_curve=curve)


def test_a_request_holds_plain_values_only(settings):
    settings.style = "CURVE"
    settings.path_curve = drawn_curve()
    request = read_request(bpy.context)
    assert not any(isinstance(value, bpy.types.bpy_struct) for value in vars(request).values())


# ------------------------------------------------------------------------------------------------ output


def test_strips_show_what_the_action_shows(settings):
    before, n_clips = own_actions(), len(bpy.context.scene.wayfarer.clips)
    walk = walked(settings)
    frames = (1, 20, 41, bpy.context.scene.frame_end)
    wanted = [heads(character(), frame) for frame in frames]
    place = character().matrix_basis.copy()
    walked(settings, output="STRIPS")
    tracks = character().animation_data.nla_tracks
    assert [len(track.strips) for track in tracks if track.name == "Wayfarer Walk"] == [len(walk)]
    assert character().animation_data.action is None
    for frame, expected in zip(frames, wanted, strict=True):
        np.testing.assert_allclose(heads(character(), frame), expected, atol=1e-4)
    assert shown.find_walk(bpy.context.scene) is not None
    operators.refresh_clips()
    assert len(bpy.context.scene.wayfarer.clips) == n_clips
    # Again, and back to an action: neither strips nor their actions are left.
    walked(settings, seed=1)
    assert sum(track.name.startswith("Wayfarer Walk") for track in tracks) == 1
    walked(settings, seed=0, output="ACTION")
    assert not [track for track in tracks if track.name.startswith("Wayfarer Walk")]
    assert [a.name for a in bpy.data.actions if WALK_PROPERTY in a] == ["Wayfarer Walk"]
    np.testing.assert_allclose(np.array(character().matrix_basis), np.array(place), atol=1e-6)
    for frame, expected in zip(frames, wanted, strict=True):
        np.testing.assert_allclose(heads(character(), frame), expected, atol=1e-4)
    assert own_actions() == before


def test_a_copy_walks_and_the_character_stays_as_it_is(settings):
    walked(settings)
    frame = bpy.context.scene.frame_end // 2
    wanted = heads(character(), frame)
    kept = bpy.data.actions["step_over_left"] if "step_over_left" in bpy.data.actions else bpy.data.actions[0]
    character().animation_data.action = kept
    walked(settings, output="COPY")
    assert character().animation_data.action == kept
    copies = bpy.data.collections[COPY_COLLECTION].objects
    copy = next(obj for obj in copies if obj.type == "ARMATURE")
    assert copy.data == character().data and copy != character()
    np.testing.assert_allclose(heads(copy, frame), wanted, atol=1e-4)
    assert shown.find_walk(bpy.context.scene) == copy.animation_data.action
    # The next one takes its place, but for what was put there, or elsewhere, by the artist.
    mine, n_objects = empty("Mine", 0, 0, collection=bpy.data.collections[COPY_COLLECTION]).name, len(copies)
    walked(settings, seed=3)
    assert len(copies) == n_objects and mine in bpy.data.objects
    walked(settings, seed=5)
    assert len(copies) == n_objects and mine in bpy.data.objects
    moved = next(obj for obj in copies if obj.type == "ARMATURE")
    copies.unlink(moved)
    bpy.context.scene.collection.objects.link(moved)
    action = moved.animation_data.action
    walked(settings, seed=4)
    assert moved.animation_data.action == action
    assert sum(obj.type == "ARMATURE" for obj in copies) == 1


@pytest.mark.parametrize("output", ["ACTION", "STRIPS"])
def test_a_walk_of_the_character_takes_the_place_of_an_earlier_copy(settings, output):
    walked(settings, output="COPY")
    objects, actions = bpy.data.objects, bpy.data.actions
    copies = [obj.name for obj in bpy.data.collections[COPY_COLLECTION].objects]
    mine = empty("Mine", 0, 0, collection=bpy.data.collections[COPY_COLLECTION]).name
    walked(settings, output=output)
    assert not any(name in objects for name in copies)
    # What the artist has put there stays, and with it the collection.
    assert mine in objects and COPY_COLLECTION in bpy.data.collections
    assert not [action.name for action in actions if action.users == 0]
    bpy.data.objects.remove(objects[mine])
    walked(settings, output="COPY")
    walked(settings, output=output)
    assert COPY_COLLECTION not in bpy.data.collections


@pytest.mark.parametrize("output", ["ACTION", "STRIPS", "COPY"])
def test_undone_in_one_step(settings, output):
    settings.output = output
    bpy.ops.ed.undo_push(message="before")
    before, artists = contents(), own_actions()
    assert operators.random_walk("EXEC_DEFAULT", True) == {"FINISHED"}
    assert own_actions() == artists
    after = contents()
    assert after != before and after["worst"] > 0
    bpy.ops.ed.undo()
    assert contents() == before
    bpy.ops.ed.redo()
    assert contents() == after


def test_strips_for_another_rig_change_nothing(settings):
    walked(settings, output="STRIPS")
    character().data.bones["Hips"].name = "Pelvis"
    assert "no bone called 'Hips'" in refused(settings, seed=9)


def test_the_path_is_drawn_if_wanted(settings):
    walked(settings)
    assert "Wayfarer Walk" in bpy.data.objects
    walked(settings, draw_path=False)
    assert "Wayfarer Walk" not in bpy.data.objects and "Wayfarer Walk" not in bpy.data.curves
    assert "Wayfarer Walk" not in bpy.data.materials


def test_each_scene_has_one_path(settings):
    """A second scene's objects cannot have the names that the first one's have."""

    def paths() -> dict:
        return {scene.name: [o.name for o in scene.objects if o.type == "CURVE"] for scene in bpy.data.scenes}

    walked(settings)
    bpy.ops.scene.new(type="FULL_COPY")
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    copied = bpy.context.scene.wayfarer.walk
    before = paths()
    assert [len(names) for names in before.values()] == [1, 1]
    for seed in (1, 2):
        walked(copied, seed=seed)
        assert paths() == before
    materials = len(bpy.data.materials)
    walked(copied, draw_path=False)
    assert [len(names) for names in paths().values()] == [1, 0] and len(bpy.data.curves) == 1
    # The copied scene's curve had the first one's material, or a copy of it.
    assert all(m.users for m in bpy.data.materials) and len(bpy.data.materials) <= materials


# ----------------------------------------------------------------------------------------------- quality


@pytest.mark.parametrize("fps", [30, 24])
def test_the_panel_tells_what_the_core_measures(settings, fps):
    scene = bpy.context.scene
    scene.render.fps = fps
    walk = walked(settings, style="WANDER", duration=10.0)
    report, rough = settings.report, walk_quality(walk, synthesize(walk))
    assert report.slide_before == pytest.approx(rough.mean_slide, rel=1e-5)
    assert report.slide_after < rough.mean_slide / 2
    assert report.gap == pytest.approx(rough.largest_gap.angle, rel=1e-5)
    assert report.gap_frame == 1 + round(rough.largest_gap.frame * fps / 30)
    assert report.edit == pytest.approx(rough.position_edit, rel=1e-5)
    severities = [entry.severity for entry in report.worst]
    assert severities == sorted(severities, reverse=True) and len(severities) > 3
    assert "plants held" in report.feet
    # A click jumps there.
    assert operators.jump_to_frame(worst=2) == {"FINISHED"}
    assert (report.active_worst, scene.frame_current) == (2, report.worst[2].frame)
    report.active_worst = 0
    assert scene.frame_current == report.worst[0].frame
    assert operators.jump_to_frame(worst=1000) == {"CANCELLED"}
    # As they are, if that is wanted.
    walked(settings, hold_feet=False)
    assert report.slide_after == report.slide_before == pytest.approx(rough.mean_slide, rel=1e-5)
    assert report.feet == "Feet are not held." and report.active_worst == -1


def test_feet_are_held_in_what_is_baked(settings):
    walked(settings, style="WANDER", duration=10.0, hold_feet=False)
    frame = next(e.frame for e in settings.report.worst if "slides" in e.what)
    before = heads(character(), frame + 1) - heads(character(), frame)
    walked(settings, hold_feet=True)
    after = heads(character(), frame + 1) - heads(character(), frame)
    names = [bone.name for bone in character().pose.bones]
    feet = [i for i, name in enumerate(names) if "Foot" in name or "Toe" in name]
    assert np.abs(after - before)[feet].max() > 1e-3
    hips = names.index("Hips")
    np.testing.assert_allclose(after[hips, :2], before[hips, :2], atol=1e-5)


# --------------------------------------------------------------------------------------- nothing is lost


def reopened(tmp_path):
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)


@pytest.mark.parametrize("output", ["ACTION", "STRIPS", "COPY"])
def test_an_action_that_was_just_keyed_is_there_after_a_walk_and_reopening(settings, tmp_path, output):
    rig = character()
    animation = rig.animation_data_create()
    animation.action = None
    bone = rig.pose.bones["Head"]
    bone.keyframe_insert("rotation_quaternion", frame=1)
    mine = animation.action
    mine.name = "just keyed"
    assert mine.users == 1 and not mine.use_fake_user
    walked(settings, output=output)
    # A second walk finds nothing more to put away.
    n_tracks = len(rig.animation_data.nla_tracks)
    walked(settings, seed=3)
    assert len(rig.animation_data.nla_tracks) == n_tracks
    reopened(tmp_path)
    assert bpy.data.actions["just keyed"].users >= 1
    assert not bpy.data.actions["just keyed"].use_fake_user


@pytest.mark.parametrize("output", ["ACTION", "STRIPS"])
def test_tracks_and_markers_of_the_artist_stay_whatever_they_are_called(settings, output):
    rig, scene = character(), bpy.context.scene
    animation = rig.animation_data_create()
    mine = next(action for action in bpy.data.actions if WALK_PROPERTY not in action)
    track = animation.nla_tracks.new()
    track.name, track.mute = "Wayfarer Walk", True
    track.strips.new("hero", 1, mine)
    scene.timeline_markers.new("Walk: hero enters", frame=7)
    settings.use_markers = True
    walked(settings, output=output)
    n_markers = len(scene.timeline_markers)
    assert n_markers == len(scene_results().walk) + 1
    moved = next(marker for marker in scene.timeline_markers if marker.name != "Walk: hero enters")
    moved.frame += 1000
    walked(settings, seed=3, use_markers=False)
    # What was moved is the artist's now.
    left = sorted((marker.name, marker.frame) for marker in scene.timeline_markers)
    assert left == sorted([("Walk: hero enters", 7), (moved.name, moved.frame)])
    names = [(t.name, [strip.action.name for strip in t.strips]) for t in animation.nla_tracks]
    assert ("Wayfarer Walk", [mine.name]) in names
    assert len([name for name, _ in names if name.startswith("Wayfarer Walk")]) == 1 + (output == "STRIPS")


def test_strips_that_the_artist_lays_into_our_track_stay(settings):
    rig = character()
    walked(settings, output="STRIPS")
    track = rig.animation_data.nla_tracks[-1]
    mine = next(action for action in bpy.data.actions if WALK_PROPERTY not in action)
    track.strips.new("mine", 5000, mine)
    walked(settings, output="ACTION")
    assert [[strip.name for strip in t.strips] for t in rig.animation_data.nla_tracks if not t.mute] == [["mine"]]


def test_a_walk_onto_a_linked_character_is_refused_with_the_remedy(settings, embedded_file, tmp_path):
    library = shutil.copy(embedded_file, str(tmp_path / "library.blend"))
    scene = bpy.context.scene
    with bpy.data.libraries.load(library, link=True) as (_, here):
        here.objects = [character().name]
    linked = here.objects[0]
    scene.collection.objects.link(linked)
    scene.wayfarer.character = linked
    operators.refresh_clips()
    assert operators.build_motion_graph() == operators.embed() == {"FINISHED"}
    with pytest.raises(RuntimeError, match=r"linked from another file.*Library Override"):
        operators.random_walk()
    assert walked(settings, output="COPY") is not None
    walked_copies = [obj for obj in bpy.data.collections[COPY_COLLECTION].objects if obj.type == "ARMATURE"]
    assert len(walked_copies) == 1 and walked_copies[0].library is None
