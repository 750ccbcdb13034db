"""A walk as NLA strips shows on every frame what it does as one action; copies of a character stand by themselves."""

import bpy
import numpy as np
import pytest
from mathutils import Vector

from bl_ext.user_default.wayfarer.addon.bridge.copies import duplicate_character
from bl_ext.user_default.wayfarer.addon.bridge.create_armature import create_armature
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.addon.bridge.write_action import assign_action, write_clip
from bl_ext.user_default.wayfarer.addon.bridge.write_strips import remove_strips, write_strips
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.environment.environment import build_environment
from bl_ext.user_default.wayfarer.core.environment.grid import Grid
from bl_ext.user_default.wayfarer.core.errors import WalkError
from bl_ext.user_default.wayfarer.core.motion.graph import MotionGraphSettings, build_motion_graph
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_repertoire, sample_skeleton
from bl_ext.user_default.wayfarer.core.playback.cleanup import clean_feet
from bl_ext.user_default.wayfarer.core.playback.synthesis import synthesize
from bl_ext.user_default.wayfarer.core.playback.walk import WalkSettings, random_walk_steps
from bl_ext.user_default.wayfarer.core.progress import finish

MODES = ("QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


@pytest.fixture(scope="module")
def walk():
    clips = [clip for clip in sample_repertoire() if clip.name.startswith(("walk", "turn_left", "arc"))]
    graph = build_motion_graph(clips, MotionGraphSettings())
    grid = Grid.over_rectangle((0, 0), (6, 6), 0.25, 12)
    embedding = embed(graph, build_environment(grid, np.empty((0, 3, 3))))
    return finish(random_walk_steps(embedding, np.random.default_rng(1), WalkSettings(8.0)))


@pytest.fixture(scope="module")
def motion(walk):
    return clean_feet(walk, synthesize(walk)).clip


def names_of(walk):
    return [walk.embedding.graph.segments[s].name for s in walk.segments]


def sample_armature():
    armature = create_armature(sample_skeleton(), {}, "Character", bpy.context.scene.collection)
    bpy.context.view_layer.update()
    bpy.context.scene.render.fps = 30
    return armature


def shown(armature, frame, names):
    """(J, 3) world positions of the bones' heads when Blender shows a frame."""
    whole = int(np.floor(frame))
    bpy.context.scene.frame_set(whole, subframe=frame - whole)
    evaluated = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([evaluated.matrix_world @ evaluated.pose.bones[name].head for name in names])


def assert_shows(armature, clip, first_frame, frames, atol=1e-4):
    for frame in frames:
        found = shown(armature, first_frame + frame, clip.skeleton.names)
        np.testing.assert_allclose(found, clip.world[1][frame], atol=atol)


@pytest.mark.parametrize("mode", MODES)
def test_a_walk_is_read_back_as_it_was_synthesised(motion, mode):
    armature = sample_armature()
    for bone in armature.pose.bones:
        bone.rotation_mode = mode
    armature.location, armature.rotation_euler = (1.0, 2.0, 0.0), (0.0, 0.0, 0.7)
    again = read_clip(armature, write_clip(armature, motion, "baked"))
    order = [again.skeleton.index(name) for name in motion.skeleton.names]
    np.testing.assert_allclose(again.world[1][:, order], motion.world[1], atol=1e-4)


@pytest.mark.parametrize("mode", ["QUATERNION", "ZXY"])
def test_strips_show_the_walk_on_every_frame(walk, motion, mode):
    armature = sample_armature()
    for bone in armature.pose.bones:
        bone.rotation_mode = mode
    armature.location, armature.rotation_euler = (0.3, -0.2, 0.0), (0.0, 0.0, 0.4)
    track = write_strips(armature, motion, walk.node_frames, names_of(walk), first_frame=11)
    assert [strip.name.split(" ", 1)[1] for strip in track.strips] == names_of(walk)
    assert [round(strip.frame_start) for strip in track.strips] == list(11 + walk.node_frames[:-1])
    assert round(track.strips[-1].frame_end) == 11 + walk.node_frames[-1]
    assert_shows(armature, motion, 11, range(motion.n_frames))


def test_a_strip_is_placed_by_one_key(walk, motion):
    """Moving the key of one strip moves what that strip shows as a whole, and nothing else."""
    armature = sample_armature()
    track = write_strips(armature, motion, walk.node_frames, names_of(walk), first_frame=1)
    strip = track.strips[1]
    curves = {
        (curve.data_path, curve.array_index): curve
        for curve in strip.action.layers[0].strips[0].channelbag(strip.action_slot).fcurves
    }
    placed = [curves["location", i] for i in range(3)]
    assert all(len(curve.keyframe_points) == 1 for curve in placed)
    assert all(len(curves["rotation_euler", i].keyframe_points) == 1 for i in range(3))
    # It stands where the segment starts, and the hips start above it.
    offset = [curve.keyframe_points[0].co[1] for curve in placed]
    np.testing.assert_allclose(offset[:2], motion.translations[walk.node_frames[1], 0, :2], atol=1e-4)
    placed[0].keyframe_points[0].co[1] += 2.0
    placed[0].update()
    moved = motion.world[1] + [2.0, 0, 0]
    for frame in (walk.node_frames[1] + 1, walk.node_frames[2] - 1):
        np.testing.assert_allclose(shown(armature, 1 + frame, motion.skeleton.names), moved[frame], atol=1e-4)
    assert_shows(armature, motion, 1, (walk.node_frames[1] - 1, walk.node_frames[2] + 1))


def test_strips_at_another_frame_rate(walk, motion):
    armature = sample_armature()
    bpy.context.scene.render.fps = 24
    write_strips(armature, motion, walk.node_frames, names_of(walk), first_frame=1)
    clip = motion.resampled(24.0)
    assert_shows(armature, clip, 1, range(0, clip.n_frames, 5))


def test_a_character_that_its_object_carries(walk, motion):
    """Where actions move the object, so do the strips, frame by frame."""
    armature = sample_armature()
    source = write_clip(armature, motion.resampled(30.0), "source")
    bag = source.layers[0].strips[0].channelbag(source.slots[0])
    for index in (0, 1):
        curve = bag.fcurves.new("location", index=index)
        curve.keyframe_points.add(2)
        curve.keyframe_points.foreach_set("co", [1.0, 0.0, 20.0, 1.0])
    track = write_strips(armature, motion, walk.node_frames, names_of(walk))
    bag = track.strips[0].action.layers[0].strips[0].channelbag(track.strips[0].action_slot)
    assert len(bag.fcurves.find("location", index=0).keyframe_points) == walk.node_frames[1] + 1
    assert_shows(armature, motion, 1, range(0, motion.n_frames, 9))


def test_a_character_below_an_animated_parent(walk, motion):
    armature = sample_armature()
    stage = bpy.data.objects.new("Stage", None)
    bpy.context.scene.collection.objects.link(stage)
    stage.location = (0.5, 0.0, 0.0)
    stage.keyframe_insert("location", frame=1)
    armature.parent = stage
    track = write_strips(armature, motion, walk.node_frames, names_of(walk))
    bag = track.strips[0].action.layers[0].strips[0].channelbag(track.strips[0].action_slot)
    assert bag.fcurves.find("location", index=0) is None
    assert_shows(armature, motion, 1, range(0, motion.n_frames, 9))


def test_the_artists_action_is_kept(walk, motion):
    armature = sample_armature()
    action = write_clip(armature, motion, "mine")
    assign_action(armature, action)
    armature.location = before = Vector((0.5, 0.25, 0.0))
    keys = np.empty(2 * motion.n_frames, dtype=np.float32)
    action.layers[0].strips[0].channelbag(action.slots[0]).fcurves[0].keyframe_points.foreach_get("co", keys)
    track = write_strips(armature, motion, walk.node_frames, names_of(walk), first_frame=200)
    animation = armature.animation_data
    assert animation.action is None and action.users == 1
    stash = next(t for t in animation.nla_tracks if t != track)
    assert stash.mute and stash.strips[0].action == action
    after = np.empty_like(keys)
    action.layers[0].strips[0].channelbag(action.slots[0]).fcurves[0].keyframe_points.foreach_get("co", after)
    np.testing.assert_array_equal(keys, after)
    assert_shows(armature, motion, 200, (0, 40))
    assert (armature.matrix_world.translation - before).length > 1
    n_actions = len(bpy.data.actions)
    track.strips[0].action.use_fake_user = True
    assert remove_strips(armature) == len(walk)
    assert len(bpy.data.actions) == n_actions - len(walk) + 1
    assert [t.name for t in animation.nla_tracks] == ["[Action Stash]"] and action.name == "mine"
    assert (armature.location - before).length < 1e-6 and "wayfarer_placement" not in armature


def test_seams_of_another_walk_are_refused(walk, motion):
    armature = sample_armature()
    with pytest.raises(WalkError, match="seams"):
        write_strips(armature, motion, walk.node_frames[:-1], names_of(walk)[:-1])
    assert len(bpy.data.actions) == 0


def dressed_armature():
    """A character with a skinned mesh, a hat on its head, a prop that hangs from the hat, and another's lamp."""
    armature = sample_armature()
    scene = bpy.context.scene.collection
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    objects = {name: bpy.data.objects.new(name, mesh if name in ("Body", "Cloak") else None) for name in
               ("Body", "Cloak", "Hat", "Feather", "Lamp")}  # fmt: skip
    for obj in objects.values():
        scene.objects.link(obj)
    objects["Body"].parent = armature
    for name in ("Body", "Cloak"):  # the cloak is deformed, but not a child
        objects[name].modifiers.new("Armature", "ARMATURE").object = armature
    objects["Hat"].parent, objects["Hat"].parent_type, objects["Hat"].parent_bone = armature, "BONE", "Head"
    objects["Feather"].parent = objects["Hat"]
    objects["Feather"].matrix_parent_inverse.translation = (0, 0, 0.5)
    track = objects["Body"].constraints.new("COPY_LOCATION")
    track.target = objects["Lamp"]
    look = armature.pose.bones["Head"].constraints.new("COPY_ROTATION")
    look.target, look.subtarget, look.influence = armature, "Spine", 0.0
    several = armature.pose.bones["LeftHand"].constraints.new("ARMATURE")
    several.targets.new().target = armature
    several.influence = 0.0
    driver = objects["Hat"].driver_add("location", 2).driver
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    variable.targets[0].id, variable.targets[0].bone_target = armature, "Head"
    driver.expression = "var * 0"
    return armature, objects


def test_a_copy_stands_by_itself(motion):
    armature, objects = dressed_armature()
    action = write_clip(armature, motion, "walk")
    assign_action(armature, action)
    collection = bpy.data.collections.new("Crowd")
    bpy.context.scene.collection.children.link(collection)
    copy = duplicate_character(armature, collection)
    assert copy != armature and copy.data == armature.data and len(collection.objects) == 5
    of = {obj.name.split(".")[0]: obj for obj in collection.objects}
    assert of["Body"].data == objects["Body"].data and "Lamp" not in of
    assert of["Body"].parent == copy and of["Feather"].parent == of["Hat"]
    assert of["Hat"].parent == copy and of["Hat"].parent_bone == "Head"
    assert of["Feather"].matrix_parent_inverse == objects["Feather"].matrix_parent_inverse
    assert of["Body"].modifiers[0].object == copy and of["Cloak"].modifiers[0].object == copy
    assert of["Body"].constraints[0].target == objects["Lamp"]  # not the character's own
    assert copy.pose.bones["Head"].constraints[0].target == copy
    assert copy.pose.bones["LeftHand"].constraints[0].targets[0].target == copy
    assert of["Hat"].animation_data.drivers[0].driver.variables[0].targets[0].id == copy
    # The originals are what they were, and the copy has an action of its own.
    assert objects["Body"].modifiers[0].object == armature and armature.animation_data.action == action
    assert armature.pose.bones["Head"].constraints[0].target == armature
    assert objects["Hat"].animation_data.drivers[0].driver.variables[0].targets[0].id == armature
    assert copy.animation_data.action is None
    still = write_clip(copy, motion, "other", first_frame=-39, only_bones=motion.skeleton.names)
    assign_action(copy, still)
    names = motion.skeleton.names
    np.testing.assert_allclose(shown(armature, 11, names), motion.world[1][10], atol=1e-4)
    np.testing.assert_allclose(shown(copy, 11, names), motion.world[1][50], atol=1e-4)
    assert bind_rig(copy).skeleton.names == bind_rig(armature).skeleton.names
