"""Characters of every make perform the same walks, are read alike, and walk on in the manner that is theirs."""

from dataclasses import dataclass, field

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip, read_clips
from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.addon.bridge.write_action import assign_action, write_clip
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.environment.environment import EnvironmentSettings, build_environment
from bl_ext.user_default.wayfarer.core.environment.grid import Grid
from bl_ext.user_default.wayfarer.core.motion import quat
from bl_ext.user_default.wayfarer.core.motion.contacts import foot_contacts
from bl_ext.user_default.wayfarer.core.motion.graph import build_motion_graph
from bl_ext.user_default.wayfarer.core.playback.synthesis import SynthesisSettings, synthesize
from bl_ext.user_default.wayfarer.core.playback.walk import WalkSettings, random_walk_steps
from bl_ext.user_default.wayfarer.core.progress import finish

from .rigify_character import FULL, rigify_character
from .rigs import (
    BESIDE,
    FRAME_RATE,
    mixamo_character,
    object_rooted_character,
    placed_character,
    sample_walks,
    similarity,
    unreal_character,
)

#: The root keeps to the walk's path to the millimetre.
EXACT = SynthesisSettings(root_tolerance=0.0)

RIGIFY = {
    "rigify": rigify_character,
    "rigify, root travels": lambda clips: rigify_character(clips, root_travels=True),
}
PERSONS = {
    "mixamo": mixamo_character,
    "unreal, root travels": lambda clips: unreal_character(clips, "root"),
    "unreal, pelvis travels": lambda clips: unreal_character(clips, "pelvis"),
    "object travels": object_rooted_character,
    "object travels unturned": lambda clips: object_rooted_character(clips, turns=False),
    "moved and turned": lambda clips: placed_character(clips, similarity((0, 0, 37), (2, -1, 0.3))),
    "Y up": lambda clips: placed_character(clips, similarity((90, 0, 37), (2, -1, 0))),
    "scaled": lambda clips: placed_character(clips, similarity((0, 0, -70), (0, 3, 0), 2.54)),
    **RIGIFY,
}
"""As large as the sample, whatever their armature's scale."""
OTHER_SIZES = {
    "2.54 times as large": lambda clips: placed_character(clips, similarity((0, 0, 37), (2, -1, 0), 2.54), 2.54),
    "ten times as large": lambda clips: placed_character(clips, np.eye(4), 10.0),
    "a tenth as large": lambda clips: placed_character(clips, similarity(scale=0.1), 0.1),
}
BUILDERS = PERSONS | OTHER_SIZES


@dataclass
class Studio:
    """Builds each character once and keeps it in a file; what is read from it does not depend on the file."""

    folder: object
    sources: tuple = field(default_factory=sample_walks)
    _characters: dict = field(default_factory=dict)
    _clips: dict = field(default_factory=dict)
    _graphs: dict = field(default_factory=dict)

    def character(self, name):
        """The character, in a scene of its own."""
        path = str(self.folder / f"{name}.blend")
        if name not in self._characters:
            bpy.context.scene.render.fps = FRAME_RATE
            self._characters[name] = BUILDERS[name](self.sources)
            bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        return self._characters[name]

    def clips(self, name):
        """What is read from the character's actions."""
        if name not in self._clips:
            character = self.character(name)
            clips, problems = read_clips(character.armature_object, character.actions)
            assert problems == []
            self._clips[name] = clips
        return self._clips[name]

    def graph(self, name):
        """The motion graph of the clips that are read, or of the sample's own."""
        if name not in self._graphs:
            self._graphs[name] = build_motion_graph(self.sources if name == "sample" else self.clips(name))
        return self._graphs[name]

    def walk(self, name, size=1.0):
        """A random walk through an empty room of 8 x 8 m, for a character of that size."""
        grid = Grid.over_rectangle((-4 * size, -4 * size), (4 * size, 4 * size), 0.25 * size, 12)
        settings = EnvironmentSettings(radius=0.25 * size)
        room = build_environment(grid, np.empty((0, 3, 3)), settings=settings)
        walk = finish(random_walk_steps(embed(self.graph(name), room), np.random.default_rng(1), WalkSettings(8.0)))
        assert np.ptp(walk.root_path[:, :2], axis=0).max() > 2 * size
        return walk

    def walking(self, name):
        """The character, its walk and the clip of it that the character plays."""
        graph = self.graph(name)
        character = self.character(name)
        assert graph is self._graphs[name]
        walk = self.walk(name, character.size)
        clip = synthesize(walk, EXACT)
        assign_action(character.armature_object, write_clip(character.armature_object, clip, "Walk"))
        return character, walk, clip


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    return Studio(tmp_path_factory.mktemp("characters"))


def joints(clip, names):
    """(F, N, 3) world positions."""
    return clip.world[1][:, [clip.skeleton.index(name) for name in names]]


def shown(armature_object, frame) -> dict[str, np.ndarray]:
    """Where Blender shows the heads of all bones on a frame."""
    bpy.context.scene.frame_set(frame)
    return {bone.name: np.array(armature_object.matrix_world @ bone.head) for bone in armature_object.pose.bones}


def key_paths(action) -> set[str]:
    return {curve.data_path for curve in action.layers[0].strips[0].channelbags[0].fcurves}


def wrapped(angles):
    return (angles + np.pi) % (2 * np.pi) - np.pi


def samples_of(clip, n=5):
    return np.linspace(0, clip.n_frames - 1, n).astype(int).tolist()


@pytest.mark.parametrize("name", BUILDERS)
def test_root_joint_and_facing(studio, name):
    character = studio.character(name)
    skeleton, own = character.clips[0].skeleton, bind_rig(character.armature_object).skeleton
    assert own.names[0] == character.root
    directions = [quat.rotate(each.rest_rotations[0], each.forward) for each in (own, skeleton)]
    np.testing.assert_allclose(*directions, atol=1e-5)


@pytest.mark.parametrize("name", BUILDERS)
def test_every_bone_is_where_blender_shows_it(studio, name):
    clips, character = studio.clips(name), studio.character(name)
    for clip, action in list(zip(clips, character.actions))[::3]:
        assign_action(character.armature_object, action)
        for sample in samples_of(clip):
            heads = shown(character.armature_object, sample + 1)
            expected = [heads[bone] for bone in clip.skeleton.names]
            np.testing.assert_allclose(clip.world[1][sample], expected, atol=1e-4 * character.size)


@pytest.mark.parametrize("name", BUILDERS)
def test_the_same_motion_as_the_source(studio, name):
    clips, character = studio.clips(name), studio.character(name)
    size, copy = character.size, character.is_copy
    # Rigify's human is of another build: its toes go where the sample's do, its hip bone lies 4 cm further back.
    followed = {joint: bone for joint, bone in character.bone_of.items() if copy or joint.endswith("ToeBase")}
    for clip, source in zip(clips, character.clips, strict=True):
        assert clip.n_frames == source.n_frames and clip.frame_rate == source.frame_rate
        difference = clip.ground_path - source.ground_path
        np.testing.assert_allclose(wrapped(difference[:, 2]), 0, atol=1e-4)
        np.testing.assert_allclose(difference[:, :2], 0, atol=1e-4 * size if copy else 0.05)
        places, expected = joints(clip, followed.values()), joints(source, followed)
        np.testing.assert_allclose(places, expected, atol=1e-4 * size if copy else 1e-3)


@pytest.mark.parametrize("name", BUILDERS)
def test_the_same_feet_are_planted(studio, name):
    agree = [
        (foot_contacts(clip) == foot_contacts(source)).all(axis=1)
        for clip, source in zip(studio.clips(name), studio.sources, strict=True)
    ]
    assert np.concatenate(agree).mean() > (0.95 if name in RIGIFY else 0.999)


@pytest.mark.parametrize("name", BUILDERS)
def test_a_motion_graph_like_the_samples(studio, name):
    graph, expected = studio.graph(name), studio.graph("sample")
    assert len(expected.links) > 100
    if name in RIGIFY:
        # Poses that differ by a hair may be cut at other frames; links grow with the square of the segments.
        assert len(graph.segments) == pytest.approx(len(expected.segments), rel=0.15)
        assert len(graph.links) == pytest.approx(len(expected.links), rel=0.3)
    else:
        assert np.array_equal(graph.links, expected.links)


@pytest.mark.parametrize("name", BUILDERS)
def test_it_walks_where_the_walk_goes(studio, name):
    character, walk, clip = studio.walking(name)
    armature_object, size = character.armature_object, character.size
    for sample in samples_of(clip, 9):
        root = shown(armature_object, sample + 1)[character.root]
        np.testing.assert_allclose(root[:2], walk.root_path[sample, :2], atol=1e-3 * size)
    again = read_clip(armature_object, armature_object.animation_data.action)
    assert again.n_frames == clip.n_frames
    np.testing.assert_allclose(wrapped(again.ground_path[:, 2] - walk.root_path[:, 2]), 0, atol=1e-3)
    np.testing.assert_allclose(again.ground_path[:, :2], walk.root_path[:, :2], atol=1e-4 * size)
    carrying = character.controls or tuple(character.bone_of.values())
    np.testing.assert_allclose(joints(again, carrying), joints(clip, carrying), atol=1e-4 * size)
    # Where controls decide, a blend of theirs is not quite a blend of the bones that follow them.
    bones = character.bone_of.values()
    np.testing.assert_allclose(
        joints(again, bones), joints(clip, bones), atol=(1e-4 if character.is_copy else 0.02) * size
    )


@pytest.mark.parametrize("name", ["unreal, root travels", "rigify, root travels"])
def test_a_root_bone_that_travels_goes_along_on_the_ground(studio, name):
    character, walk, clip = studio.walking(name)
    armature_object = character.armature_object
    floor = armature_object.matrix_world.translation.z
    facing = []
    for sample in samples_of(clip, 9):
        root = shown(armature_object, sample + 1)["root"]
        assert root[2] == pytest.approx(floor, abs=1e-5)
        assert np.linalg.norm(root[:2] - walk.root_path[sample, :2]) < 0.1
        pose = armature_object.matrix_world @ armature_object.pose.bones["root"].matrix
        rest = armature_object.matrix_world @ armature_object.data.bones["root"].matrix_local
        turn = np.array((pose @ rest.inverted()).to_3x3())
        np.testing.assert_allclose(turn[2], [0, 0, 1], atol=1e-5)
        facing.append(np.arctan2(turn[1, 0], turn[0, 0]) - walk.root_path[sample, 2])
    assert np.ptp(wrapped(np.array(facing) - facing[0])) < np.radians(15)


@pytest.mark.parametrize("name", ["unreal, pelvis travels", "rigify"])
def test_a_root_bone_that_stays_is_left_where_it_is(studio, name):
    character, _, clip = studio.walking(name)
    armature_object = character.armature_object
    place = np.array(armature_object.matrix_world.translation)
    for sample in samples_of(clip):
        np.testing.assert_allclose(shown(armature_object, sample + 1)["root"], place, atol=1e-5)
    paths = key_paths(armature_object.animation_data.action)
    assert ('pose.bones["root"].location' in paths) == (name != "rigify")


@pytest.mark.parametrize("turns", [True, False])
def test_an_object_that_travels_goes_along(studio, turns):
    character, walk, clip = studio.walking("object travels" if turns else "object travels unturned")
    armature_object = character.armature_object
    for sample in samples_of(clip, 9):
        shown(armature_object, sample + 1)
        x, y, heading = walk.root_path[sample]
        # At rest the character faces -Y.
        turn = np.degrees(heading) + 90 if turns else 0
        expected = similarity((0, 0, turn), (x, y, 0)) @ similarity(location=BESIDE)
        np.testing.assert_allclose(np.array(armature_object.matrix_world), expected, atol=1e-4)
        hips = armature_object.pose.bones["Hips"]
        np.testing.assert_allclose(hips.head[:2], hips.bone.head_local[:2], atol=1e-4)
    action = armature_object.animation_data.action
    assert ("rotation_euler" in key_paths(action)) and "scale" not in key_paths(action)


@pytest.mark.parametrize("name", ["object travels", "mixamo"])
def test_what_was_played_before_does_not_displace_a_walk(studio, name):
    """Actions that key the object leave it where they end, unless the next one keys it too."""
    studio.graph(name)
    character = studio.character(name)
    armature_object = character.armature_object
    armature_object.location.x += 3.0
    bpy.context.view_layer.update()
    walk = studio.walk(name)
    action = write_clip(armature_object, synthesize(walk, EXACT), "Walk")
    for source in character.actions[1:3]:
        assign_action(armature_object, source)
        bpy.context.scene.frame_set(50)
    assign_action(armature_object, action)
    for sample in (0, 60, 120):
        root = shown(armature_object, sample + 1)[character.root]
        np.testing.assert_allclose(root[:2], walk.root_path[sample, :2], atol=1e-3)


def test_an_object_that_travels_in_the_space_of_another(studio):
    studio.graph("object travels")
    character = studio.character("object travels")
    armature_object = character.armature_object
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.matrix_world = Matrix(similarity((0, 0, 50), (1, 2, 0), 1.5))
    bpy.context.view_layer.update()
    armature_object.parent = parent
    walk = studio.walk("object travels")
    action = write_clip(armature_object, synthesize(walk, EXACT), "Walk")
    assign_action(armature_object, action)
    for sample in (0, 60, 120):
        root = shown(armature_object, sample + 1)[character.root]
        np.testing.assert_allclose(root[:2], walk.root_path[sample, :2], atol=1e-3)
        x, y, _ = armature_object.matrix_world.translation
        assert np.hypot(x - root[0], y - root[1]) < 1.0
    # Where something else decides where the object is, keys would not put it where they say.
    armature_object.constraints.new("LIMIT_LOCATION")
    again = write_clip(armature_object, synthesize(walk, EXACT), "Again")
    assert "location" in key_paths(action) and "location" not in key_paths(again)


def test_an_object_without_keys_gets_none(studio):
    character, _, _ = studio.walking("moved and turned")
    paths = key_paths(character.armature_object.animation_data.action)
    assert paths and all(path.startswith("pose.bones") for path in paths)


def test_controls_that_never_move_stay_though_they_have_keys(studio):
    """Many artists key the whole character: what is keyed does not tell what moves."""
    clips, character = studio.clips("rigify"), studio.character("rigify")
    armature_object = character.armature_object
    idle = ("root", "hips", "head", "thigh_ik_target.L", "thigh_ik_target.R")
    for action in character.actions:
        channelbag = action.layers[0].strips[0].channelbags[0]
        for bone in idle:
            for index in range(3):
                curve = channelbag.fcurves.new(f'pose.bones["{bone}"].location', index=index)
                curve.keyframe_points.insert(1, 0.0)
    path = clips[0].ground_path
    action = write_clip(armature_object, clips[0], "Again")
    assign_action(armature_object, action)
    assert 'pose.bones["root"].location' in key_paths(action)
    for sample in samples_of(clips[0]):
        heads = shown(armature_object, sample + 1)
        np.testing.assert_allclose(heads["root"], armature_object.matrix_world.translation, atol=1e-4)
        np.testing.assert_allclose(heads[character.root][:2], path[sample, :2], atol=1e-3)


def test_the_scenes_unit_scale_changes_nothing(studio):
    clips, character = studio.clips("mixamo"), studio.character("mixamo")
    bpy.context.scene.unit_settings.scale_length = 0.01
    again = read_clip(character.armature_object, character.actions[0])
    np.testing.assert_array_equal(again.translations, clips[0].translations)


def test_the_full_human_of_rigify(studio):
    """Face, fingers and all: 700 bones, of which most are none of the body's."""
    bpy.context.scene.render.fps = FRAME_RATE
    source = min(studio.sources, key=lambda clip: clip.n_frames)
    character = rigify_character([source], metarig=FULL)
    clip = read_clip(character.armature_object, character.actions[0])
    assert clip.skeleton.names[0] == "ORG-spine" and clip.skeleton.n_joints > 500
    assert (foot_contacts(clip) == foot_contacts(source)).all(axis=1).mean() > 0.95
    toes = joints(character.clips[0], ["LeftToeBase", "RightToeBase"])
    np.testing.assert_allclose(joints(clip, ["DEF-toe.L", "DEF-toe.R"]), toes, atol=1e-3)
