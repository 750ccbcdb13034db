"""Mirrored clips: left for right, in every skeleton that has both."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.errors import ClipError
from core.motion.contacts import foot_contacts
from core.motion.heading import with_steady_heading
from core.motion.mirror import asymmetry, mirrored
from core.motion.repertoire import sample_repertoire
from core.motion.skeleton import Skeleton

from .bvh import read_bvh
from .rotations import as_quaternions, as_rotation

CLIPS = {clip.name: clip for clip in sample_repertoire()}


def along_start(points, clip):
    """World positions (..., 3) as seen from the first frame: ahead, to the left, up."""
    x, y, heading = clip.ground_path[0]
    return Rotation.from_euler("Z", -heading).apply((points - [x, y, 0]).reshape(-1, 3)).reshape(points.shape)


def with_rolls(clip, rng):
    """The same motion on a skeleton whose every joint has other axes of its own."""
    skeleton, n_frames = clip.skeleton, clip.n_frames
    roll = Rotation.random(skeleton.n_joints, random_state=rng)
    rest, moves = skeleton.rest_rotations.copy(), skeleton.rest_translations.copy()
    rotations, translations = clip.rotations.copy(), clip.translations.copy()
    for joint, parent in enumerate(skeleton.parents):
        before = roll[int(parent)].inv() if joint else Rotation.identity()
        rest[joint] = (before * as_rotation(rest[joint])[0] * roll[joint]).as_quat(scalar_first=True)
        rotations[:, joint] = as_quaternions(before * as_rotation(rotations[:, joint]) * roll[joint], (n_frames,))
        if joint:
            moves[joint], translations[:, joint] = before.apply(moves[joint]), before.apply(translations[:, joint])
    forward = roll[0].inv().apply(skeleton.forward)
    rolled = Skeleton(skeleton.names, skeleton.parents, rest, moves, forward)
    return replace(clip, skeleton=rolled, rotations=rotations, translations=translations)


def check_mirror_image(clip, tolerance):
    """Every joint is where the mirror image of its partner is."""
    image = mirrored(clip)
    other = clip.skeleton.partners
    expected = along_start(clip.world[1][:, other], clip) * [1, -1, 1]
    np.testing.assert_allclose(along_start(image.world[1], clip), expected, atol=tolerance)
    np.testing.assert_allclose(image.ground_path[0], clip.ground_path[0], atol=1e-9)
    np.testing.assert_allclose(
        image.ground_path[:, 2] - image.ground_path[0, 2],
        clip.ground_path[0, 2] - clip.ground_path[:, 2],
        atol=1e-9,
    )
    return image


@pytest.mark.parametrize("clip", CLIPS.values(), ids=CLIPS)
def test_every_joint_is_where_its_partner_is_in_the_mirror(clip):
    image = check_mirror_image(clip, 1e-6)
    np.testing.assert_array_equal(foot_contacts(image), foot_contacts(clip)[:, ::-1])
    assert image.name == f"{clip.name} (mirrored)"
    assert image.tags.keys() == clip.tags.keys()
    assert all(np.array_equal(image.tags[tag], clip.tags[tag]) for tag in clip.tags)
    assert not np.allclose(image.rotations, clip.rotations)


@pytest.mark.parametrize("name", CLIPS)
def test_mirrored_twice_is_the_clip(name):
    clip = with_steady_heading(CLIPS[name])
    twice = mirrored(mirrored(clip))
    assert twice.name == clip.name
    np.testing.assert_allclose(twice.rotations, clip.rotations, atol=1e-9)
    np.testing.assert_allclose(twice.translations, clip.translations, atol=1e-9)
    np.testing.assert_allclose(twice.heading, clip.heading, atol=1e-9)


def test_a_left_turn_becomes_a_right_turn():
    image = mirrored(CLIPS["turn_left_90"])
    turned = np.degrees(image.ground_path[-1, 2] - image.ground_path[0, 2])
    assert turned == pytest.approx(-90, abs=12)
    ahead, left = along_start(image.translations[-1, 0], image)[:2]
    assert ahead > 0.5 and left < -0.5


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["turn_left_45", "step_over_left"])
def test_bone_rolls_do_not_matter(name, seed):
    clip = CLIPS[name]
    rolled = with_rolls(clip, np.random.default_rng(seed))
    np.testing.assert_allclose(rolled.world[1], clip.world[1], atol=1e-9)
    np.testing.assert_allclose(mirrored(rolled).world[1], mirrored(clip).world[1], atol=1e-9)


def test_joints_that_move_in_their_sockets_do_so_in_the_mirror():
    clip = CLIPS["walk"]
    translations = clip.translations.copy()
    wave = np.sin(np.arange(clip.n_frames) / 7)
    translations[:, clip.skeleton.index("LeftArm")] += wave[:, None] * [0.03, 0.02, 0.01]
    check_mirror_image(replace(clip, translations=translations), 1e-6)
    rolled = with_rolls(replace(clip, translations=translations), np.random.default_rng(5))
    check_mirror_image(rolled, 1e-6)


def test_recordings_of_a_nearly_symmetric_person(data_folder):
    for name in ("16_18", "16_20", "16_10"):
        clip = read_bvh(data_folder / "cmu16" / f"{name}.bvh")
        assert 0.01 < asymmetry(clip.skeleton).max() / clip.skeleton.stature < 0.02
        # Bones keep their own lengths, which differ by up to 8 mm from side to side, and add up.
        image = check_mirror_image(clip, 0.06)
        np.testing.assert_array_equal(image.translations[:, 1:], clip.translations[:, 1:])
        assert np.mean(foot_contacts(image) == foot_contacts(clip)[:, ::-1]) > 0.95
        twice = mirrored(image)
        np.testing.assert_allclose(twice.rotations, clip.rotations, atol=1e-9)
        np.testing.assert_allclose(twice.translations, clip.translations, atol=1e-9)


def test_a_lopsided_rest_pose_is_refused_with_bones_and_distance():
    clip = CLIPS["walk"]
    skeleton = clip.skeleton
    moved = skeleton.rest_translations.copy()
    moved[skeleton.index("RightLeg")] += [0, 0.1, 0]
    broken = replace(clip, skeleton=replace(skeleton, rest_translations=moved))
    with pytest.raises(ClipError, match=r"'(Left|Right)(Leg|Foot|ToeBase)'.* \d\d\.\d cm"):
        mirrored(broken)
    mirrored(broken, tolerance=0.1)


def test_skeletons_without_sides_or_with_another_hierarchy_are_refused():
    clip = CLIPS["walk"]
    skeleton = clip.skeleton
    nameless = replace(skeleton, names=tuple(f"bone{joint}" for joint in range(skeleton.n_joints)))
    with pytest.raises(ClipError, match=r"thigh\.L"):
        mirrored(replace(clip, skeleton=nameless))
    parents = skeleton.parents.copy()
    parents[skeleton.index("RightArm")] = skeleton.index("Spine2")
    with pytest.raises(ClipError, match="hierarchy"):
        mirrored(replace(clip, skeleton=replace(skeleton, parents=parents)))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("LeftUpLeg", "RightUpLeg"),
        ("mixamorig:LeftHandIndex1", "mixamorig:RightHandIndex1"),
        ("thigh.L", "thigh.R"),
        ("DEF-thigh.L.001", "DEF-thigh.R.001"),
        ("upperarm_l", "upperarm_r"),
        ("l_thigh", "r_thigh"),
        ("Bip01 L Calf", "Bip01 R Calf"),
        ("LThumb", "RThumb"),
        ("LHipJoint", "RHipJoint"),
        ("J_Bip_L_UpperLeg", "J_Bip_R_UpperLeg"),
        ("leftupleg", "rightupleg"),
    ],
)
def test_sides_are_told_from_names(left, right):
    names = ("Root", "LowerBack", left, "Collar", right, "Roll")
    n_joints = len(names)
    rest = np.tile([1.0, 0, 0, 0], (n_joints, 1))
    parents = np.array([-1, 0, 0, 0, 0, 0])
    skeleton = Skeleton(names, parents, rest, np.zeros((n_joints, 3)), np.array([1.0, 0, 0]))
    assert skeleton.partners.tolist() == [0, 1, 4, 3, 2, 5]
