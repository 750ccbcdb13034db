"""When feet are planted, shown; feet chosen by hand."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.operators.show_contacts import IMAGE_NAME
from bl_ext.user_default.wayfarer.addon.render.contact_strip import LEFT, RIGHT, ClipContacts, contact_strip
from bl_ext.user_default.wayfarer.addon.render.image_editor import show_in_editor
from bl_ext.user_default.wayfarer.addon.results import state
from bl_ext.user_default.wayfarer.addon.scene import inputs
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion.contacts import foot_contacts

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def colored(picture, color) -> np.ndarray:
    """(height, width) bool: pixels of an sRGB colour."""
    return np.abs(picture[..., :3] - color).max(axis=2) < 0.01


def test_shares_are_those_of_the_contacts(settings):
    settings.active_clip = next(i for i, clip in enumerate(settings.clips) if clip.use)
    action = settings.active_action()
    assert state.contacts_of(bpy.context.scene, action) is None
    assert operators.show_contacts() == {"FINISHED"}
    shares = state.contacts_of(bpy.context.scene, action)
    left, right = foot_contacts(read_clip(settings.character, action)).T
    assert (shares.left, shares.right) == (left.mean(), right.mean())
    assert (shares.both, shares.none) == ((left & right).mean(), (~left & ~right).mean())
    assert 0.4 < shares.left < 0.9
    # Another idea of a planted foot: the numbers do not fit any more.
    settings.contacts.height = 0.01
    assert state.contacts_of(bpy.context.scene, action) is None


def test_the_image_shows_every_clip(settings):
    operators.show_contacts()
    image = bpy.data.images[IMAGE_NAME]
    pixels = np.empty(4 * image.size[0] * image.size[1], dtype=np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(image.size[1], image.size[0], 4)
    used = sum(clip.use for clip in settings.clips)
    for color in (LEFT, RIGHT):
        rows = colored(pixels, color).any(axis=1)
        assert np.count_nonzero(np.diff(rows.astype(int)) == 1) == used
    assert image.packed_file is not None
    operators.show_contacts()
    assert [image.name for image in bpy.data.images] == [IMAGE_NAME]


def test_the_image_appears_in_the_first_image_editor(settings):
    windows = bpy.context.window_manager.windows
    if not windows:
        pytest.skip("no window to open an Image Editor in")
    areas = [area for window in windows for area in window.screen.areas]
    assert not [area for area in areas if area.type == "IMAGE_EDITOR"]
    blank = bpy.data.images.new("Blank", 4, 4)
    # Nowhere to show it, and nobody who would look at a window of its own.
    assert not show_in_editor(bpy.context, blank)
    assert [area for window in windows for area in window.screen.areas] == areas
    for area in areas[:2]:
        area.type = "IMAGE_EDITOR"
        area.spaces.active.image = blank
    operators.show_contacts()
    shown = [area.spaces.active.image.name for area in areas[:2]]
    assert shown == [IMAGE_NAME, *["Blank"] * len(shown[1:])]


def test_the_strip_is_filled_where_feet_are_planted():
    planted = np.zeros((100, 2), dtype=bool)
    planted[:50, 0] = planted[75:, 1] = True
    picture = contact_strip([ClipContacts("half and quarter", 25.0, planted), ClipContacts("none", 25.0, ~planted[:9])])
    left, right = colored(picture, LEFT), colored(picture, RIGHT)
    widths = [mask.sum(axis=1).max() for mask in (left, right)]
    assert widths[0] == pytest.approx(2 * widths[1], rel=0.05)
    # Left above right; time goes to the right.
    first = left.sum(axis=1) == widths[0]
    second = right.sum(axis=1) == widths[1]
    assert np.flatnonzero(first).min() > np.flatnonzero(second).max()
    assert np.flatnonzero(left[first].any(axis=0)).max() < np.flatnonzero(right[second].any(axis=0)).min()
    # The names are written beside it.
    margin = picture[:, : np.flatnonzero(left.any(axis=0)).min() - 1, :3].mean(axis=2)
    assert margin.max() > 0.5 > margin.mean()


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
    assert not state.graph_is_stale(scene)
    settings.contacts.left_foot = "LeftFoot"
    assert state.graph_is_stale(scene)
