"""Planted feet: made-up feet whose contacts are known, and recorded walks and jumps."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.errors import ClipError
from core.motion.clip import MotionClip
from core.motion.contacts import ContactSettings, foot_contacts
from core.motion.skeleton import Skeleton

from .bvh import read_bvh

NAMES = ("root", "foot.L", "toe.L", "foot.R", "toe.R")


def puppet(left, right, floor=0.0):
    """A clip at 30 frames per second whose ankles follow ``left`` and ``right`` (F, 3); toes 0.1 m ahead."""
    parents = np.array([-1, 0, 1, 0, 3])
    rest = np.zeros((5, 3))
    skeleton = Skeleton(NAMES, parents, np.tile([1.0, 0, 0, 0], (5, 1)), rest, np.array([1.0, 0, 0]))
    n_frames = len(left)
    rotations = np.tile([1.0, 0, 0, 0], (n_frames, 5, 1))
    translations = np.zeros((n_frames, 5, 3))
    translations[:, 0, 2] = floor
    translations[:, 1], translations[:, 3] = left, right
    translations[:, [2, 4]] = [0.1, 0, -0.05]
    return MotionClip("puppet", skeleton, 30.0, rotations, translations)


def step(n_frames, lift_frames, height=0.2, length=0.6):
    """A foot that stands, travels through the air during ``lift_frames``, and stands again."""
    share = np.clip((np.arange(n_frames) - lift_frames[0]) / (lift_frames[1] - lift_frames[0]), 0, 1)
    return np.column_stack([share * length, np.zeros(n_frames), 0.08 + height * np.sin(np.pi * share)])


@pytest.mark.parametrize("floor", [0.0, 3.0, -1.0])
def test_a_step_lifts_one_foot_on_any_floor(floor):
    contacts = foot_contacts(puppet(step(60, (20, 32)), step(60, (0, 1), height=0, length=0), floor))
    assert contacts.shape == (60, 2)
    assert contacts[:, 1].all()
    assert contacts[:19, 0].all() and contacts[34:, 0].all()
    assert not contacts[22:31, 0].any()


def test_a_foot_held_up_is_not_planted():
    still = np.zeros((40, 3))
    contacts = foot_contacts(puppet(still, still + [0, 0, 0.3]))
    assert contacts[:, 0].all() and not contacts[:, 1].any()


def test_a_foot_that_glides_over_the_ground_is_not_planted():
    glide = np.column_stack([np.arange(40) / 30 * 1.5, np.zeros(40), np.zeros(40)])
    contacts = foot_contacts(puppet(np.zeros((40, 3)), glide))
    assert contacts[:, 0].all() and not contacts[:, 1].any()


def test_between_the_thresholds_a_foot_stays_as_it_was():
    height = np.interp(np.arange(80), [20, 25, 35, 50, 60, 70], [0.0, 0.065, 0.065, 0.3, 0.3, 0.065])
    moving = np.column_stack([np.zeros((80, 2)), height])
    contacts = foot_contacts(puppet(moving, np.zeros((80, 3))))
    assert contacts[:36, 0].all()
    assert not contacts[40:, 0].any()


def test_a_clip_may_begin_between_the_thresholds():
    leaving = np.column_stack([np.zeros((40, 2)), np.interp(np.arange(40), [5, 20], [0.065, 0.3])])
    contacts = foot_contacts(puppet(leaving, np.zeros((40, 3))))
    assert contacts[:6, 0].all() and not contacts[10:, 0].any()
    contacts = foot_contacts(puppet(leaving[::-1], np.zeros((40, 3))))
    assert not contacts[:, 0].any()


def test_thresholds_are_settings():
    height = np.column_stack([np.zeros((40, 2)), np.interp(np.arange(40), [20, 25], [0.0, 0.06])])
    clip = puppet(height, np.zeros((40, 3)))
    strict = ContactSettings(height=0.01, release_height=0.02)
    assert foot_contacts(clip)[30:, 0].all()
    assert not foot_contacts(clip, strict)[30:, 0].any()
    with pytest.raises(ClipError, match="Lifted Above"):
        ContactSettings(height=0.1, release_height=0.05)


def test_feet_may_be_named():
    lifted = np.column_stack([np.zeros((40, 2)), np.full(40, 0.3)])
    clip = puppet(np.zeros((40, 3)), lifted)
    swapped = foot_contacts(clip, ContactSettings(feet=(("foot.R", "toe.R"), ("foot.L", "toe.L"))))
    np.testing.assert_array_equal(swapped, foot_contacts(clip)[:, ::-1])
    with pytest.raises(ClipError, match=r"'foot\.M'"):
        foot_contacts(clip, ContactSettings(feet=(("foot.M",), ("foot.L",))))


def test_heading_and_place_do_not_matter():
    clip = puppet(step(60, (20, 32)), np.zeros((60, 3)))
    turn = Rotation.from_rotvec([0, 0, 2.5])
    rotations, translations = clip.rotations.copy(), clip.translations.copy()
    rotations[:, 0] = turn.as_quat(scalar_first=True)
    translations[:, 0] += [3, 4, 0]
    moved = MotionClip("moved", clip.skeleton, 30.0, rotations, translations)
    np.testing.assert_array_equal(foot_contacts(moved), foot_contacts(clip))


@pytest.mark.parametrize("number", ["16", "22", "47", "31", "13"])
def test_recorded_walks_alternate_and_never_fly(data_folder, number):
    contacts = foot_contacts(read_bvh(data_folder / "cmu16" / f"16_{number}.bvh").resampled(30.0))
    assert contacts.any(axis=1).all()
    for side in (0, 1):
        changes = np.flatnonzero(np.diff(contacts[:, side].astype(int))) + 1
        # Swing and stance last 0.2 s at least: nothing flickers.
        assert np.diff(changes).min() >= 6
    lone = contacts[contacts.sum(axis=1) == 1].argmax(axis=1)
    assert np.count_nonzero(np.diff(lone)) >= 3


@pytest.mark.parametrize("number", ["09", "10"])
def test_recorded_jumps_fly_once(data_folder, number):
    clip = read_bvh(data_folder / "cmu16" / f"16_{number}.bvh").resampled(30.0)
    flying = ~foot_contacts(clip).any(axis=1)
    assert np.count_nonzero(np.diff(flying.astype(int))) == 2
    assert 0.4 < np.count_nonzero(flying) / 30 < 0.7
    toes = clip.world[1][:, [clip.skeleton.index("LeftToeBase"), clip.skeleton.index("RightToeBase")], 2]
    assert flying[toes.min(axis=1).argmax()]
