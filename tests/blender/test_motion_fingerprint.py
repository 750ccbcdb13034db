"""Whatever changes what a character does, or how it is read, makes the motion graph stale; nothing else does."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.addon.scene.inputs import read_character, read_character_steps
from bl_ext.user_default.wayfarer.addon.scene.motion_fingerprint import action_fingerprint, actions_fingerprint
from bl_ext.user_default.wayfarer.addon.session import SESSION
from bl_ext.user_default.wayfarer.core.progress import finish


def curve(action):
    curves = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    return next(each for each in curves if len(each.keyframe_points) > 5 and "rotation" in each.data_path)


def interpolate(action, how: str):
    for point in curve(action).keyframe_points:
        point.interpolation = how


def pull_handle(action):
    point = curve(action).keyframe_points[3]
    point.handle_right_type = "FREE"
    point.handle_right.y += 1


def ease(action):
    point = curve(action).keyframe_points[3]
    point.interpolation, point.easing = "ELASTIC", "EASE_IN"
    before = actions_fingerprint(bpy.context.scene)
    point.period = 7.0
    assert actions_fingerprint(bpy.context.scene) != before


def shake(action):
    modifier = curve(action).modifiers.new("NOISE")
    before = actions_fingerprint(bpy.context.scene)
    modifier.strength = 3.0
    assert actions_fingerprint(bpy.context.scene) != before


def restrict(rig):
    constraint = rig.pose.bones["Spine"].constraints.new("LIMIT_ROTATION")
    before = actions_fingerprint(bpy.context.scene)
    constraint.use_limit_x, constraint.max_x = True, 0.1
    assert actions_fingerprint(bpy.context.scene) != before


def drive(rig):
    """By what a driver reads and how, and by its curve."""
    rig["switch"] = 0.25
    driver = rig.pose.bones["Spine"].constraints.new("LIMIT_SCALE").driver_add("influence")
    # Blender 4.5 begins a driver with a modifier instead.
    for value in (0.0, 1.0):
        driver.keyframe_points.insert(value, value)
    variable = driver.driver.variables.new()
    (target,) = variable.targets
    target.id, target.data_path, driver.driver.expression = rig, '["switch"]', variable.name
    known = {now()}

    def swap_type():
        variable.type = "TRANSFORMS"

    changes = {
        "switch": lambda: rig.__setitem__("switch", 0.75),
        "kind": swap_type,
        "transform": lambda: setattr(target, "transform_type", "ROT_Z"),
        "space": lambda: setattr(target, "transform_space", "LOCAL_SPACE"),
        "order": lambda: setattr(target, "rotation_mode", "SWING_TWIST_Y"),
        "key": lambda: setattr(driver.keyframe_points[1].co, "y", 2.0),
        "modifier": lambda: driver.modifiers.new("STEPPED"),
    }
    for name, change in changes.items():
        change()
        assert now() not in known, name
        known.add(now())


OF_ACTION = {
    "a key": lambda action: setattr(curve(action).keyframe_points[2].co, "y", 1.5),
    "steps": lambda action: interpolate(action, "CONSTANT"),
    "bends": lambda action: interpolate(action, "BEZIER"),
    "a handle": pull_handle,
    "easing": ease,
    "a modifier": shake,
    "extrapolation": lambda action: setattr(curve(action), "extrapolation", "LINEAR"),
    "mute": lambda action: setattr(curve(action), "mute", True),
    "range": lambda action: setattr(action, "use_frame_range", True),
    "a tag": lambda action: action.pose_markers.new("step"),
    "a rate": lambda action: action.__setitem__("wayfarer_frame_rate", 12.0),
}
OF_RIG = {
    "a tilt": lambda rig: setattr(rig.rotation_euler, "x", math.pi / 2),
    "size": lambda rig: setattr(rig, "scale", (2, 2, 2)),
    "a constraint": restrict,
    "a driver": drive,
    "inheritance": lambda rig: setattr(rig.data.bones["Spine"], "use_inherit_rotation", False),
    "rotation mode": lambda rig: setattr(rig.pose.bones["Spine"], "rotation_mode", "XZY"),
    "forward": lambda rig: rig.__setitem__("wayfarer_forward", [0.0, 1.0, 0.0]),
    "deforming": lambda rig: setattr(rig.data.bones["Spine"], "use_deform", False),
}
NOTHING = {
    "its place": lambda rig, action: setattr(rig, "location", (3, 2, 1)),
    "its heading": lambda rig, action: setattr(rig.rotation_euler, "z", 1.0),
    "its name": lambda rig, action: setattr(rig, "name", "Somebody"),
    "the action's name": lambda rig, action: setattr(action, "name", "Something"),
    "its pose": lambda rig, action: setattr(rig.pose.bones["Spine"], "location", (1, 1, 1)),
    "the frame": lambda rig, action: bpy.context.scene.frame_set(20),
}


@pytest.fixture
def opened(small_file):
    bpy.ops.wm.open_mainfile(filepath=small_file)
    settings = bpy.context.scene.wayfarer
    # What plays would move it back.
    settings.character.animation_data.action = None
    return settings


def now() -> str:
    bpy.context.view_layer.update()
    return actions_fingerprint(bpy.context.scene)


def test_what_changes_the_motion_is_seen(opened, small_file):
    known = {now()}
    for name, change in {**OF_ACTION, **OF_RIG}.items():
        change(opened.character if name in OF_RIG else opened.used_actions()[0])
        assert now() not in known, name
        known.add(now())


def test_nothing_else_is(opened):
    before = now()
    for name, change in NOTHING.items():
        change(opened.character, opened.used_actions()[0])
        assert now() == before, name


def test_what_moves_with_the_frame_is_told_by_its_curves(opened):
    """Rigs switch between their chains by keys of influences, or by properties that drive them."""
    scene, rig, action = bpy.context.scene, opened.character, opened.used_actions()[0]
    rig.animation_data.action = action
    spine = rig.pose.bones["Spine"]
    keyed, driven, armature = (spine.constraints.new(kind) for kind in ("LIMIT_SCALE", "LIMIT_ROTATION", "ARMATURE"))
    weighted = armature.targets.new()
    spine["switch"] = 0.0
    driver = driven.driver_add("influence").driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = rig, 'pose.bones["Spine"]["switch"]'
    driver.expression = variable.name
    for frame, value in ((1, 0.0), (20, 1.0)):
        spine["switch"] = keyed.influence = weighted.weight = value
        spine.keyframe_insert('["switch"]', frame=frame)
        keyed.keyframe_insert("influence", frame=frame)
        rig.keyframe_insert(weighted.path_from_id("weight"), frame=frame)
    scene.frame_set(1)
    before, shown = now(), (keyed.influence, driven.influence, weighted.weight)
    scene.frame_set(20)
    assert (keyed.influence, driven.influence, weighted.weight) != shown
    assert now() == before
    curves = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    curves.find(keyed.path_from_id("influence")).keyframe_points[1].co.y = 0.5
    assert now() != before


def test_a_keyed_property_that_only_drivers_read_is_seen(opened):
    """No constraint has to be there for it."""
    rig, action = opened.character, opened.used_actions()[0]
    rig["switch"] = 0.0
    rig.animation_data.action = action
    for frame, value in ((1, 0.0), (20, 1.0)):
        rig["switch"] = value
        rig.keyframe_insert('["switch"]', frame=frame)
    read_by_driver(rig, "Spine", rig, '["switch"]')
    bpy.context.scene.frame_set(1)
    before = now()
    bpy.context.scene.frame_set(20)
    assert rig["switch"] == 1.0 and now() == before
    curves = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    curves.find('["switch"]').keyframe_points[1].co.y = 0.5
    assert now() != before


def new_object(name, data=None, location=(0, 0, 0), parent=None):
    made = bpy.data.objects.new(name, data)
    made.location, made.parent = location, parent
    bpy.context.scene.collection.objects.link(made)
    return made


def keyed(block, path: str, index: int = -1):
    """A curve from 0 at frame 1 to 3 at frame 40, by which the block moves now."""
    animation = block.animation_data_create()
    action = animation.action or bpy.data.actions.new(block.name)
    animation.action = action
    made = action.fcurve_ensure_for_datablock(block, path, index=max(index, 0))
    made.keyframe_points.insert(1, 0.0)
    made.keyframe_points.insert(40, 3.0)
    return made


def read_by_driver(rig, bone: str, block, path: str):
    """Turn a bone by a value of another data-block."""
    driven = rig.pose.bones[bone].driver_add("location", 0).driver
    variable = driven.variables.new()
    (target,) = variable.targets
    if path:
        target.id_type = block.id_type
        target.id, target.data_path = block, path
    else:
        variable.type, target.transform_type, target.id = "TRANSFORMS", "LOC_X", block
    driven.expression = variable.name


def surround(rig) -> SimpleNamespace:
    """Whatever may move a rig from outside, at rest and moving with the frame."""
    made = SimpleNamespace()
    bones = [bone for bone in rig.pose.bones if bone.parent]

    def constrain(place: int, kind: str, target, owner=None):
        constraint = (owner or bones[place]).constraints.new(kind)
        constraint.target = target
        return constraint

    made.holder = new_object("Holder")
    made.look = new_object("Look", location=(5, 5, 2), parent=made.holder)
    constrain(0, "DAMPED_TRACK", made.look)
    made.flying = new_object("Flying")
    made.flight = keyed(made.flying, "location", 0)
    constrain(1, "DAMPED_TRACK", made.flying)
    made.behind = new_object("Behind")
    made.follow = constrain(0, "COPY_LOCATION", made.flying, owner=made.behind)
    constrain(2, "DAMPED_TRACK", made.behind)
    made.prop = new_object("Prop", bpy.data.armatures.new("Prop"))
    bpy.context.view_layer.objects.active = made.prop
    bpy.ops.object.mode_set(mode="EDIT")
    made.prop.data.edit_bones.new("Grip").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    keyed(made.prop, 'pose.bones["Grip"].location', 1)
    constrain(3, "DAMPED_TRACK", made.prop).subtarget = "Grip"
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    made.floor = new_object("Floor", mesh)
    constrain(4, "SHRINKWRAP", made.floor).influence = 0.1
    path = bpy.data.curves.new("Path", "CURVE")
    path.use_path = True
    path.splines.new("POLY").points.add(2)
    made.path = new_object("Path", path)
    made.pace = keyed(path, "eval_time")
    constrain(0, "FOLLOW_PATH", made.path, owner=new_object("Wagon"))
    constrain(0, "DAMPED_TRACK", bpy.data.objects["Wagon"])
    made.dial, made.slide = new_object("Dial"), new_object("Slide")
    made.dial["turn"], made.dial["wobble"] = 0.5, 0.0
    made.wobble = keyed(made.dial, '["wobble"]')
    read_by_driver(rig, bones[5].name, made.slide, "")
    for place, block, name in ((6, made.dial, '["turn"]'), (7, made.dial, '["wobble"]'), (8, path, "eval_time")):
        read_by_driver(rig, bones[place].name, block, name)
    read_by_driver(rig, bones[9].name, bpy.context.scene, "frame_current")
    read_by_driver(rig, bones[10].name, made.flying, "matrix_world[0][3]")
    read_by_driver(rig, bones[12].name, made.dial, '["gone"]')
    rig.pose.bones[bones[12].name].driver_add("scale", 1).driver.variables.new().type = "CONTEXT_PROP"
    made.band = new_object("Band")
    keyed(made.band, "location", 2)
    action = made.band.animation_data.action
    made.band.animation_data.action = None
    made.strip = made.band.animation_data.nla_tracks.new().strips.new("Band", 1, action)
    made.strip.use_animated_influence = True
    made.strip.fcurves[0].keyframe_points.insert(1, 0.0)
    made.strip.fcurves[0].keyframe_points.insert(40, 1.0)
    constrain(11, "DAMPED_TRACK", made.band)
    made.cart = new_object("Cart", location=(0, 1, 0), parent=new_object("Track"))
    made.ride = keyed(made.cart, "location", 0)
    for name, index in (("rotation_euler", 0), ("scale", 0)):
        keyed(made.cart, name, index)
    rig.parent = made.cart
    return made


OUTSIDE = {
    "a target": lambda made: setattr(made.look, "location", (-5, -5, -2)),
    "its parent": lambda made: setattr(made.holder.rotation_euler, "z", 1.0),
    "how it hangs from it": lambda made: setattr(made.look, "matrix_parent_inverse", made.cart.matrix_basis),
    "a key of a target": lambda made: setattr(made.flight.keyframe_points[1].co, "y", 9.0),
    "what is not keyed of it": lambda made: setattr(made.flying.location, "y", 2.0),
    "a constraint of a target": lambda made: setattr(made.follow, "use_offset", True),
    "a bone of another rig": lambda made: setattr(made.prop.pose.bones["Grip"].location, "x", 1.0),
    "a surface": lambda made: setattr(made.floor.data.vertices[0].co, "z", 1.0),
    "a path": lambda made: setattr(made.path.data.splines[0].points[1], "co", (1, 1, 1, 1)),
    "a pace": lambda made: setattr(made.pace.keyframe_points[1].co, "y", 9.0),
    "a switch": lambda made: made.dial.__setitem__("turn", 0.75),
    "a keyed switch": lambda made: setattr(made.wobble.keyframe_points[0].co, "y", 1.0),
    "what a driver follows": lambda made: setattr(made.slide.location, "x", 2.0),
    "a strip": lambda made: setattr(made.strip, "scale", 2.0),
    "a key of a parent": lambda made: setattr(made.ride.keyframe_points[1].co, "y", 20.0),
    "what is not keyed of a parent": lambda made: setattr(made.cart.location, "y", 4.0),
    "the end of a constraint": lambda made: made.behind.constraints.clear(),
}


def test_what_moves_the_rig_from_outside_is_seen_whatever_the_frame(opened):
    made = surround(opened.character)
    known = set()
    for name, change in {"as it was": lambda made: None, **OUTSIDE}.items():
        bpy.context.scene.frame_set(1)
        change(made)
        present = now()
        assert present not in known, name
        known.add(present)
        shown = made.flying.location.x, made.dial["wobble"], made.cart.rotation_euler.x, made.band.location.z
        for frame in (13, 40):
            bpy.context.scene.frame_set(frame)
            assert now() == present, (name, frame)
        moved = made.flying.location.x, made.dial["wobble"], made.cart.rotation_euler.x, made.band.location.z
        assert all(one != other for one, other in zip(shown, moved, strict=True))


def test_what_has_no_say_makes_no_difference(opened):
    """Things that nothing refers to, or a constraint that is switched off, and parents that stand."""
    made = surround(opened.character)
    limit = opened.character.pose.bones[0].constraints.new("DAMPED_TRACK")
    limit.target, limit.mute = new_object("Off"), True
    before = now()
    bpy.data.objects["Off"].location = (1, 2, 3)
    new_object("Bystander", parent=made.cart)
    made.floor.data.vertices[0].select = True
    opened.character.location.x += 1
    assert now() == before
    opened.character.parent = stand = new_object("Stand")
    before = now()
    stand.location, stand.rotation_euler = (3, 2, 1), (0, 0, 1)
    assert now() == before
    stand.rotation_euler.x = 1
    assert now() != before


@pytest.mark.parametrize("how", ["constraint", "driver", "parent"])
def test_the_graph_is_stale_when_what_it_was_read_beside_has_moved(opened, how):
    scene, rig = bpy.context.scene, opened.character
    beside = new_object("Beside", location=(5, 5, 2))
    if how == "constraint":
        rig.pose.bones["Spine"].constraints.new("DAMPED_TRACK").target = beside
    elif how == "driver":
        read_by_driver(rig, "Hips", beside, "")
    else:
        ride = keyed(beside, "location", 0)
        rig.parent = beside
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    assert staleness.graph_changes(scene) == ()
    before = read_character(scene)[0][0].world
    if how == "parent":
        ride.keyframe_points[1].co.y = 20
    else:
        beside.location = (-5, -5, -2)
    bpy.context.view_layer.update()
    after = read_character(scene)[0][0].world
    assert any(np.abs(one - other).max() > 0.01 for one, other in zip(before, after, strict=True))
    assert staleness.graph_changes(scene) != ()


def test_a_direction_of_any_kind_is_seen(opened):
    """Also one that is none: it is refused where it is used, never where its change is looked for."""
    known = {now()}
    odd = ("front", "back", 2.5, True, [1.0, 2.0], [0.0, 0.0, 0.0], [math.nan] * 3, {"a": 1}, {"a": 2}, [[1], [2]])
    for value in (*odd, [0.0, 1.0, 0.0]):
        opened.character["wayfarer_forward"] = value
        assert now() not in known, value
        known.add(now())


def test_known_fingerprints_are_not_taken_again(opened):
    scene = bpy.context.scene
    seen = finish(read_character_steps(scene)).seen
    assert actions_fingerprint(scene, seen) == actions_fingerprint(scene)
    assert actions_fingerprint(scene, {**seen, next(iter(seen)): "another"}) != actions_fingerprint(scene)


def test_results_of_deleted_scenes_are_forgotten(opened):
    first = bpy.context.scene
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    for _ in range(12):
        other = bpy.data.scenes.new("Other")
        assert store.results(other).graph is None
        bpy.data.scenes.remove(other)
    assert len(SESSION.all(store.SceneResults)) <= 5 and store.results(first).graph is not None


def test_a_namesake_that_is_not_in_use_makes_no_difference(sample_settings, tmp_path):
    """An action of another file may bear the name of one of this file."""
    scene, action = bpy.context.scene, sample_settings.used_actions()[0]
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {action})
    with bpy.data.libraries.load(path, link=True) as (_, here):
        here.actions = [action.name]
    [linked] = here.actions
    curve(action).keyframe_points[3].co.y += 1
    sample_settings.refresh_clips()
    for clip in sample_settings.clips:
        clip.use = clip.use and clip.action != action
    used = sample_settings.used_actions()
    assert linked.name == action.name and linked in used and action not in used
    seen = {each.name: action_fingerprint(scene, each) for each in used}
    assert seen[linked.name] != action_fingerprint(scene, action)
    # Both have been looked at, one after the other.
    both = seen | {action.name: action_fingerprint(scene, action)}
    assert actions_fingerprint(scene, seen) == actions_fingerprint(scene, both) == actions_fingerprint(scene)
    assert bpy.ops.wayfarer.examine_clips() == {"FINISHED"}
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    assert not staleness.graph_is_stale(scene)
    curve(linked).keyframe_points[3].co.y += 1
    assert staleness.graph_is_stale(scene)
