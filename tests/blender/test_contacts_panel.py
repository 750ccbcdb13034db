"""When feet are planted, shown; feet chosen by hand."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.results import clips, staleness
from bl_ext.user_default.wayfarer.addon.scene import inputs
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion.contacts import foot_contacts
from bl_ext.user_default.wayfarer.core.wording import share

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def test_shares_are_those_of_the_contacts(settings):
    settings.active_clip = next(i for i, clip in enumerate(settings.clips) if clip.use)
    action = settings.active_action()
    assert clips.contacts_of(bpy.context.scene, action) is None
    assert operators.show_contacts() == {"FINISHED"}
    shares = clips.contacts_of(bpy.context.scene, action)
    left, right = foot_contacts(read_clip(settings.character, action)).T
    assert (shares.left, shares.right) == (left.mean(), right.mean())
    assert (shares.both, shares.none) == ((left & right).mean(), (~left & ~right).mean())
    assert 0.4 < shares.left < 0.9
    # Another idea of a planted foot: the numbers do not fit any more.
    settings.contacts.height = 0.01
    assert clips.contacts_of(bpy.context.scene, action) is None


def test_clips_that_cannot_be_read_are_said(settings):
    for clip in settings.clips:
        clip.action.use_frame_range, clip.action.frame_start, clip.action.frame_end = True, 1, 1
    with pytest.raises(RuntimeError, match=r"No action of 'Wayfarer Character' can be used\. '"):
        operators.show_contacts()


def test_the_page_shows_every_clip(settings):
    operators.show_contacts()
    page = Path(bpy.app.tempdir, "wayfarer_contacts.html").read_text("utf-8")
    used = [clip.action.name for clip in settings.clips if clip.use]
    assert all(f">{name[:25]}" in page for name in used) and page.count("<svg") == 1
    # A table of shares below: a row for each clip, and its head.
    assert page.count("<tr>") == len(used) + 1
    for name in used:
        shares = clips.contacts_of(bpy.context.scene, bpy.data.actions[name])
        assert f'<td>{name}</td><td class="number">{share(shares.left)}</td>' in page
    assert not bpy.data.images


def test_feet_can_be_chosen(settings):
    character, contacts = settings.character, settings.contacts
    assert contacts.feet(character) is None
    contacts.left_foot = "RightFoot"
    with pytest.raises(ClipError, match="No bone is chosen for the right foot"):
        contacts.feet(character)
    contacts.right_foot = "LeftFoot"
    assert contacts.feet(character) == (("RightFoot", "RightToeBase"), ("LeftFoot", "LeftToeBase"))
    # Exchanged on purpose, to see that they are heeded.
    clip = read_clip(character, next(clip.action for clip in settings.clips if clip.use))
    chosen = foot_contacts(clip, contacts.to_core(character))
    np.testing.assert_array_equal(chosen, foot_contacts(clip)[:, ::-1])
    assert inputs.graph_settings(bpy.context.scene).contacts.feet == contacts.feet(character)
    assert inputs.doctor_settings(bpy.context.scene).feet == contacts.feet(character)
    contacts.right_foot = "Tail"
    with pytest.raises(RuntimeError, match="no bone 'Tail' for the right foot"):
        operators.show_contacts()
    with pytest.raises(RuntimeError, match="no bone 'Tail'"):
        operators.build_motion_graph()


def test_contradicting_thresholds_are_reported(settings):
    settings.contacts.release_height = 0.01
    with pytest.raises(RuntimeError, match="must be positive, and not above"):
        operators.build_motion_graph()


def test_feet_make_the_graph_stale(settings):
    operators.build_motion_graph()
    scene = bpy.context.scene
    assert not staleness.graph_is_stale(scene)
    settings.contacts.left_foot = "LeftFoot"
    assert staleness.graph_is_stale(scene)
