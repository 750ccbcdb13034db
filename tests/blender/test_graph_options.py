"""Mirroring, steady headings, thresholds and joint weights, from the panel to the motion graph."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.addon.scene import inputs
from bl_ext.user_default.wayfarer.core.motion.distance import joint_weights
from bl_ext.user_default.wayfarer.core.motion.graph_settings import ThresholdMode
from bl_ext.user_default.wayfarer.core.motion.heading import steady_heading
from bl_ext.user_default.wayfarer.core.motion.mirror import mirrored

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def built():
    assert operators.build_motion_graph() == {"FINISHED"}
    return store.results(bpy.context.scene).graph


def test_mirrored_clips_are_added(settings):
    plain = built()
    settings.graph.mirror_clips = True
    assert staleness.graph_is_stale(bpy.context.scene)
    graph = built()
    assert not staleness.graph_is_stale(bpy.context.scene)
    names = [clip.name for clip in plain.clips]
    assert [clip.name for clip in graph.clips] == names + [f"{name} (mirrored)" for name in names]
    original = read_clip(settings.character, bpy.data.actions[names[0]])
    added = graph.clips[len(names)]
    np.testing.assert_allclose(added.rotations, mirrored(original).resampled(30.0).rotations, atol=1e-9)
    # A turn to the left has become one to the right.
    turning = names.index("turn_left_90")
    turns = [np.ptp(graph.clips[i].ground_path[:, 2]) for i in (turning, len(names) + turning)]
    ends = [np.subtract(*graph.clips[i].ground_path[[-1, 0], 2]) for i in (turning, len(names) + turning)]
    assert turns[0] == pytest.approx(turns[1]) and ends[0] == pytest.approx(-ends[1], abs=1e-6) and ends[0] > 1


def test_a_rig_that_cannot_be_mirrored_says_which_bones(settings):
    character = settings.character
    bpy.context.view_layer.objects.active = character
    bpy.ops.object.mode_set(mode="EDIT")
    for name in ("LeftForeArm", "LeftHand"):
        character.data.edit_bones[name].head.z += 0.3
    bpy.ops.object.mode_set(mode="OBJECT")
    settings.graph.mirror_clips = True
    with pytest.raises(RuntimeError, match=r"cannot be mirrored: .*LeftForeArm|cannot be mirrored: .*LeftHand"):
        operators.build_motion_graph()
    assert store.results(bpy.context.scene).graph is None


def test_headings_are_steadied(settings):
    plain = built()
    settings.graph.steady_heading = True
    assert staleness.graph_is_stale(bpy.context.scene)
    steady = built()
    for clip, before in zip(steady.clips, plain.clips, strict=True):
        assert clip.name == before.name
        wanted = steady_heading(read_clip(settings.character, bpy.data.actions[clip.name]))
        np.testing.assert_allclose(clip.ground_path[:, 2], wanted[: clip.n_frames], atol=0.02)
        np.testing.assert_allclose(clip.rotations, before.rotations)
    swaying = next(i for i, clip in enumerate(plain.clips) if clip.name == "walk")
    sways = [np.ptp(graph.clips[swaying].ground_path[:, 2]) for graph in (steady, plain)]
    assert sways[0] < 0.5 * sways[1]


def test_thresholds_by_links_and_by_coverage(settings):
    loose = built()
    settings.graph.threshold_mode = ThresholdMode.LINKS.name
    settings.graph.max_links = len(loose.links) // 3
    few = built()
    assert 0 < len(few.links) <= settings.graph.max_links
    assert few.max_cost < loose.max_cost
    settings.graph.threshold_mode = ThresholdMode.COVERAGE.name
    settings.graph.min_coverage = 0.3
    part = built()
    seconds = sum(segment.duration for segment in part.segments)
    given = sum(clip.duration for clip in part.clips)
    assert seconds >= 0.3 * given and part.max_cost < loose.max_cost
    settings.graph.min_coverage = 1.0
    with pytest.raises(RuntimeError, match="of the motion can be kept"):
        operators.build_motion_graph()


def test_only_what_the_mode_heeds_makes_the_graph_stale(settings):
    built()
    scene = bpy.context.scene
    settings.graph.max_links += 1
    assert not staleness.graph_is_stale(scene)
    settings.graph.threshold_mode = ThresholdMode.LINKS.name
    assert staleness.graph_is_stale(scene)


def test_weights_are_guessed_and_heeded(settings):
    graph = settings.graph
    scene = bpy.context.scene
    assert operators.guess_weights() == {"FINISHED"}
    skeleton = read_clip(settings.character, bpy.data.actions["walk"]).skeleton
    guessed = dict(zip(skeleton.names, joint_weights(skeleton).tolist(), strict=True))
    assert {item.name: item.weight for item in graph.joint_weights} == guessed
    assert inputs.graph_settings(scene).cost.joint_weights is None
    plain = built()
    graph.use_custom_weights = True
    same = built()
    np.testing.assert_array_equal(same.links, plain.links)
    np.testing.assert_allclose(same.link_costs, plain.link_costs)
    graph.joint_weights["LeftUpLeg"].weight = graph.joint_weights["RightUpLeg"].weight = 0.0
    assert staleness.graph_is_stale(scene)
    other = built()
    assert other.links.shape != plain.links.shape or not np.allclose(other.link_costs, plain.link_costs)
    # They belong to these bones.
    settings.character = None
    assert len(graph.joint_weights) == 0 and not graph.use_custom_weights


def test_the_summary_is_that_of_the_graph(settings):
    graph = built()
    summary = store.results(bpy.context.scene).graph_summary
    best = summary.hubs(1)[0]
    degrees = [(graph.links[:, 1] == i).sum() * (graph.links[:, 0] == i).sum() for i in range(len(graph.segments))]
    assert degrees[best] == max(degrees) > 0
    assert sorted(summary.dropped) == sorted((d.clip, d.seconds, d.reason) for d in graph.dropped)
