"""A giant and a dwarf who move like a person are cut like a person."""

from dataclasses import replace

import numpy as np
import pytest

from core.motion.body_size import relative_size
from core.motion.contacts import foot_contacts
from core.motion.distance import pose_features, transition_costs
from core.motion.repertoire import sample_repertoire

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
