"""A giant and a dwarf who move like a person are cut like a person."""

from dataclasses import replace

import numpy as np
import pytest

from core.motion.body_size import body_radius, relative_size
from core.motion.contacts import foot_contacts
from core.motion.distance import pose_features
from core.motion.repertoire import sample_repertoire

from .dense_costs import transition_costs

CLIP = sample_repertoire()[0]


def as_large_as(size):
    skeleton = replace(CLIP.skeleton, rest_translations=CLIP.skeleton.rest_translations * size)
    return replace(CLIP, skeleton=skeleton, translations=CLIP.translations * size)


@pytest.mark.parametrize("size", [0.1, 0.5, 2.54, 10.0, 100.0])
def test_contacts_and_costs_do_not_depend_on_the_size(size):
    clip = as_large_as(size)
    assert relative_size(clip.skeleton) == pytest.approx(size, rel=0.01)
    assert np.mean(foot_contacts(clip) == foot_contacts(CLIP)) > 0.99
    # The leg of the sample is not to the millimetre that of the person that sizes are told by.
    costs, expected = (transition_costs(f, f) for f in (pose_features(clip), pose_features(CLIP)))
    assert np.allclose(costs, expected, rtol=0.02, atol=1e-3)


@pytest.mark.parametrize("size", [0.85, 1.0, 1.2])
def test_people_are_compared_in_plain_metres(size):
    assert relative_size(as_large_as(size).skeleton) == 1.0


def test_without_legs_stature_tells():
    skeleton = replace(CLIP.skeleton, names=tuple(f"bone{i}" for i in range(CLIP.skeleton.n_joints)))
    assert relative_size(skeleton) == 1.0
    assert relative_size(replace(skeleton, rest_translations=skeleton.rest_translations * 10)) == pytest.approx(
        10, rel=0.1
    )


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_the_radius_holds_the_shoulders_and_grows_with_the_body(size):
    skeleton = as_large_as(size).skeleton
    left, right = (skeleton.rest_world[1][skeleton.names.index(f"{side}Arm")] for side in ("Left", "Right"))
    half_shoulders = np.linalg.norm(left - right) / 2
    assert half_shoulders + 0.06 * size < body_radius(skeleton) < half_shoulders + 0.09 * size
    assert 0.2 * size < body_radius(skeleton) < 0.32 * size


def test_the_radius_of_a_body_without_known_arms_is_a_share_of_its_height():
    skeleton = replace(CLIP.skeleton, names=tuple(f"bone{i}" for i in range(CLIP.skeleton.n_joints)))
    assert 0.2 < body_radius(skeleton) < 0.32
