"""Feet that were cleaned up stand still in Blender too, where keys belong on controls."""

import numpy as np

from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.bridge.write_action import write_clip
from bl_ext.user_default.wayfarer.core.playback.cleanup import clean_feet
from bl_ext.user_default.wayfarer.core.playback.quality import foot_slide
from bl_ext.user_default.wayfarer.core.playback.synthesis import synthesize

from .test_rigs import studio  # noqa: F401  (a fixture)


def test_feet_that_follow_controls_stand_still(studio):  # noqa: F811  (the fixture)
    """Rigify's legs are moved by IK: its controls have to go where the clean-up puts the feet."""
    studio.graph("rigify")
    armature_object = studio.character("rigify").armature_object
    walk = studio.walk("rigify")
    before = synthesize(walk)
    cleaned = clean_feet(walk, before)
    assert len(cleaned.plants) > 5 and cleaned.untreated == ()
    slides = []
    for clip in (before, cleaned.clip):
        again = read_clip(armature_object, write_clip(armature_object, clip, "Walk"))
        order = [again.skeleton.index(joint) for joint in clip.skeleton.names]
        slides.append(foot_slide(list(cleaned.plants), again.world[1][:, order], again.frame_rate).mean())
    assert slides[1] <= 0.02 < slides[0] / 3
    np.testing.assert_allclose(again.ground_path[:, :2], cleaned.clip.ground_path[:, :2], atol=1e-3)
