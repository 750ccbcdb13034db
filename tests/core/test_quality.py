"""The quality report: every number against the obvious way to get it, and numbers that notice damage."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from core.embedding.embedding import embed
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.motion import quat
from core.motion.contacts import ContactSettings, foot_joints
from core.motion.distance import joint_weights
from core.playback.cleanup import clean_feet
from core.playback.plants import walk_plants
from core.playback.quality import walk_quality
from core.playback.spikes import find_spikes, graph_roughness
from core.playback.synthesis import SynthesisSettings, synthesize
from core.playback.walk import Walk, WalkSettings, random_walk_steps
from core.progress import finish

from .motion_graphs import sample_graph
from .rotations import as_rotation


@pytest.fixture(scope="module")
def walk():
    grid = Grid.over_rectangle((0, 0), (6, 6), 0.15, 24)
    embedding = embed(sample_graph(), build_environment(grid, np.empty((0, 3, 3))))
    return finish(random_walk_steps(embedding, np.random.default_rng(5), WalkSettings(30.0)))


@pytest.fixture(scope="module")
def played(walk):
    return synthesize(walk)


@pytest.fixture(scope="module")
def report(walk, played):
    return walk_quality(walk, played)


def test_slides_are_those_of_the_planted_joints(walk, played, report):
    positions = played.world[1]
    for side, foot in enumerate(report.feet):
        slides = {}
        for plant in walk_plants(walk):
            for frame in range(plant.first, plant.last) if plant.side == side else ():
                joint = plant.pivots[frame + 1 - plant.first]
                step = positions[frame + 1, joint, :2] - positions[frame, joint, :2]
                slides[frame] = np.hypot(*step) * played.frame_rate
        assert foot.foot == played.skeleton.names[foot_joints(played.skeleton)[side][0]]
        assert foot.mean == pytest.approx(np.mean(list(slides.values())))
        assert foot.worst == pytest.approx(max(slides.values()))
        assert slides[foot.worst_frame] == pytest.approx(foot.worst)
        assert 0 < foot.source_mean < foot.mean


def test_largest_gap_is_that_of_a_joint_that_weighs_between_the_source_clips(walk, report):
    graph = walk.embedding.graph
    weighs = joint_weights(graph.clips[0].skeleton)[1:] > 0
    assert 0 < np.count_nonzero(weighs) < len(weighs)
    largest, where = 0.0, None
    for i in range(len(walk) - 1):
        before, after = (graph.segments[s] for s in walk.segments[i : i + 2])
        a, b = graph.clips[before.clip], graph.clips[after.clip]
        turned = (
            as_rotation(a.rotations[before.last, 1:]).inv() * as_rotation(b.rotations[after.first, 1:])
        ).magnitude() * weighs
        if turned.max() > largest:
            largest = turned.max()
            where = walk.node_frames[i + 1], a.skeleton.names[1 + int(turned.argmax())], a.name, b.name
    gap = report.largest_gap
    assert gap.angle == pytest.approx(largest)
    assert (gap.frame, gap.joint, gap.clip_before, gap.clip_after) == where


def test_edits_and_jumps_are_those_of_the_path(walk, played, report):
    stencils = walk.embedding.unrolling.stencils
    path = walk.root_path
    length = sum(np.hypot(*step) for step in np.diff(path[:, :2], axis=0))
    edits = sum(np.hypot(*stencils.position_error[k]) for k in walk.stencils)
    assert report.position_edit == pytest.approx(edits / length)
    assert report.heading_edit == pytest.approx(np.abs(stencils.heading_error[walk.stencils]).sum() / length)
    root = played.ground_path
    speed, turn = {}, {}
    for k in walk.node_frames[1:-1].tolist():
        before, after = root[k] - root[k - 1], root[k + 1] - root[k]
        speed[k] = abs(np.hypot(*after[:2]) - np.hypot(*before[:2])) * played.frame_rate
        turn[k] = abs(after[2] - before[2]) * played.frame_rate
    assert report.speed_jump.value == pytest.approx(max(speed.values()))
    assert speed[report.speed_jump.frame] == max(speed.values())
    assert report.turn_jump.value == pytest.approx(max(turn.values()))
    rough = walk_quality(walk, synthesize(walk, SynthesisSettings(root_tolerance=0.0)))
    assert rough.speed_jump.value > report.speed_jump.value


def test_worst_frames_are_sorted_and_lie_on_the_walk(walk, report):
    severities = [entry.severity for entry in report.worst_frames]
    assert severities == sorted(severities, reverse=True) and len(severities) == 20
    assert all(0 <= entry.frame < walk.node_frames[-1] for entry in report.worst_frames)
    every = list(walk_quality(walk, synthesize(walk), n_worst=10_000).worst_frames)
    every = [entry for entry in every if not entry.what.endswith(("snaps", "jerks", "lurches"))]
    assert len(every) == 3 * (len(walk) - 1) + len(walk) + sum(p.n_frames > 1 for p in walk_plants(walk))
    assert any("slides" in entry.what for entry in every) and any("gap" in entry.what for entry in every)


def test_a_foot_that_is_pushed_tops_the_list(walk, played):
    """Damage done on purpose: one planted frame with the body pushed half a metre aside."""
    plant = next(p for p in walk_plants(walk) if p.n_frames > 12)
    frame = plant.first + 6
    translations = played.translations.copy()
    translations[frame, 0, 0] += 0.5
    damaged = walk_quality(walk, replace(played, translations=translations))
    assert damaged.worst_frames[0].frame in (frame - 1, frame)
    assert damaged.worst_frames[0].value > 1000 and damaged.worst_frames[0].unit == "cm/s"


def test_clean_up_shows_in_the_report(walk, played, report):
    cleaned = walk_quality(walk, clean_feet(walk, played).clip)
    assert cleaned.mean_slide <= 0.02 < report.mean_slide
    assert cleaned.largest_gap == report.largest_gap


def test_a_foot_that_is_lifted_does_not_slide_and_every_other_frame_counts(walk, played):
    lifted = np.random.default_rng(1).random((played.n_frames, 2)) < 0.4
    positions = played.world[1]
    found = walk_quality(walk, played, n_worst=10_000, lifted=lifted)
    for side, foot in enumerate(found.feet):
        slides = {}
        for plant in walk_plants(walk):
            for frame in range(plant.first, plant.last) if plant.side == side else ():
                if not (lifted[frame, side] and lifted[frame + 1, side]):
                    joint = plant.pivots[frame + 1 - plant.first]
                    step = positions[frame + 1, joint, :2] - positions[frame, joint, :2]
                    slides[frame] = np.hypot(*step) * played.frame_rate
        assert foot.mean == pytest.approx(np.mean(list(slides.values())))
        assert foot.worst == pytest.approx(max(slides.values()))
        assert slides[foot.worst_frame] == pytest.approx(foot.worst)
        named = [entry for entry in found.worst_frames if entry.what == f"{foot.foot} slides" and entry.value > 0]
        assert all(100 * slides[entry.frame] == pytest.approx(entry.value) for entry in named)
    with pytest.raises(WalkError, match="Lifted"):
        walk_quality(walk, played, lifted=lifted[1:])


def test_a_joint_that_jerks_and_a_knee_that_snaps_are_found_beside_the_clips(walk, played):
    """One frame of one joint turned on purpose; a toe has no knee."""
    names, frame = played.skeleton.names, played.n_frames // 2
    rough = graph_roughness(walk.embedding.graph)
    assert len(rough.legs) == 2
    before = find_spikes(walk, played, rough)
    for bone, knee in (("LeftLeg", True), ("RightToeBase", False), ("Spine", False)):
        joint, rotations = names.index(bone), played.rotations.copy()
        rotations[frame, joint] = quat.multiply(rotations[frame, joint], quat.from_rotvec([0.9, 0.0, 0.0]))
        knees, joints, lurches = find_spikes(walk, replace(played, rotations=rotations), rough)
        near = [spike for spike in joints if spike.joint == joint and abs(spike.frame - frame) <= 2]
        assert near and near[0].severity > 1.2
        found = [spike for spike in knees if spike not in before[0]]
        if knee:
            assert [spike.joint for spike in found] == [joint] and abs(found[0].frame - frame) <= 1
            assert found[0].severity > 1.2
        else:
            assert found == []
        assert lurches == before[2]
    told = walk_quality(walk, replace(played, rotations=rotations), n_worst=10_000)
    assert any(entry.what == "Spine jerks" and abs(entry.frame - frame) <= 2 for entry in told.worst_frames)


def test_a_lurch_is_a_change_of_velocity_over_a_fifth_of_a_second(walk, played):
    rough, start = graph_roughness(walk.embedding.graph), played.n_frames // 2
    for change, lurches in ((0.7, False), (3.0, True)):
        translations = np.tile(played.translations[:1], (played.n_frames, 1, 1))
        after = np.maximum(np.arange(played.n_frames) - start, 0) / played.frame_rate
        translations[:, 0, 0] += change * after
        still = replace(
            played, rotations=np.tile(played.rotations[:1], (played.n_frames, 1, 1)), translations=translations
        )
        found = find_spikes(walk, still, rough)[2]
        assert [spike.severity for spike in found] == ([pytest.approx(change / 0.2 / 5.0)] if lurches else [])
        assert all(abs(spike.frame - start) <= 6 for spike in found)


def test_what_the_clips_do_themselves_is_no_spike(walk):
    """A whole clip played as it is has none, however rough it is; bones that are no part of the body have no limit."""
    graph = walk.embedding.graph
    rough = graph_roughness(graph)
    for clip, knees, joints in zip(graph.clips, rough.knees, rough.joints, strict=True):
        assert len(knees) == clip.n_frames - 2 and joints.shape == (clip.n_frames - 3, clip.skeleton.n_joints)
    assert max(joints.max() for joints in rough.joints) > 1
    both = next(
        i
        for i, (a, b) in enumerate(pairwise(walk.segments))
        if graph.segments[a].clip == graph.segments[b].clip and graph.segments[a].last == graph.segments[b].first
    )
    part = Walk(walk.embedding, walk.states[both : both + 3], walk.stencils[both : both + 2])
    first, last = (graph.segments[s] for s in part.segments)
    own = graph.clips[first.clip].taken(slice(first.first, last.last + 1))
    assert find_spikes(
        part,
        own,
        replace(
            rough,
            knee_limit=1e-3,
            joint_limits=rough.joint_limits * 1e-3,
            knees=tuple(k * rough.knee_limit * 1e3 for k in rough.knees),
            joints=tuple(j * 1e3 for j in rough.joints),
        ),
    )[:2] == ([], [])
    names = graph.clips[0].skeleton.names
    body = {joint for joints in graph.clips[0].skeleton.roles.values() for joint in joints}
    assert {names[j] for j in np.flatnonzero(np.isinf(rough.joint_limits))} == set(names) - {names[j] for j in body}


def test_standing_about_and_turning_back_are_counted(walk, played, report):
    path, rate = played.ground_path, played.frame_rate
    half, idle = round(0.25 * rate), 0
    for frame in range(len(path)):
        before, after = max(frame - half, 0), min(frame + half, len(path) - 1)
        idle += np.hypot(*(path[after, :2] - path[before, :2])) * rate / (after - before) < 0.45
    assert report.idle == pytest.approx(idle / len(path)) and 0 < report.idle < 1
    turned, times = False, 0
    for frame in range(len(path) - round(2 * rate)):
        turns = abs(path[frame + round(2 * rate), 2] - path[frame, 2]) > np.radians(120)
        times += turns and not turned
        turned = turns
    assert report.turns_back == pytest.approx(60 * times / walk.duration)


def test_what_cannot_be_measured_says_so(walk, played):
    unknown = walk_quality(walk, played, ContactSettings(feet=(("Nobody",), ("Neither",))))
    assert not unknown.feet and "Nobody" in unknown.feet_unknown and np.isnan(unknown.mean_slide)
    single = Walk(walk.embedding, walk.states[:2], walk.stencils[:1])
    report = walk_quality(single, synthesize(single))
    assert report.largest_gap is None and report.speed_jump is None
    with pytest.raises(WalkError, match="frames"):
        walk_quality(walk, played.resampled(24.0))
