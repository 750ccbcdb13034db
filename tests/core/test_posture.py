"""What the motion of the sample shows to be wrong with its character, where something is."""

from dataclasses import replace

import numpy as np
import pytest

from core.errors import ClipError
from core.motion import quat
from core.motion.body_size import MMD_UNIT, person_height
from core.motion.clip import MotionClip
from core.motion.doctor import FindingKind, RemedyKind, apply_remedy, examine
from core.motion.repertoire import sample_repertoire
from core.motion.skeleton import Skeleton

CLIPS = {clip.name: clip for clip in sample_repertoire(30.0)}
WALK = CLIPS["walk"]


def moved(clip, turn=quat.IDENTITY, scale=1.0, up=0.0):
    """The clip and its character turned, scaled and lifted in the world."""
    skeleton = clip.skeleton

    def placed(rotations, translations):
        rotations, translations = rotations.copy(), translations * scale
        rotations[..., 0, :] = quat.multiply(turn, rotations[..., 0, :])
        translations[..., 0, :] = quat.rotate(turn, translations[..., 0, :]) + [0.0, 0.0, up]
        return rotations, translations

    rest = placed(skeleton.rest_rotations, skeleton.rest_translations)
    rotations, translations = placed(clip.rotations, clip.translations)
    skeleton = Skeleton(skeleton.names, skeleton.parents, *rest, skeleton.forward)
    return replace(clip, skeleton=skeleton, rotations=rotations, translations=translations)


def facing(clip, degrees):
    """The clip with its forward direction turned about the vertical."""
    skeleton = clip.skeleton
    forward = quat.rotate(quat.about("z", np.radians(degrees)), skeleton.rest_forward)
    own = quat.rotate(quat.inverse(skeleton.rest_rotations[0]), forward)
    return replace(clip, skeleton=replace(skeleton, forward=own))


def on_a_pole(clip):
    """The clip under a joint 0 that stays at the origin, where the character has a root bone for the ground."""
    skeleton = clip.skeleton
    forward = skeleton.rest_forward
    one = np.array([1.0, 0, 0, 0])
    parents = np.concatenate([[-1], np.asarray(skeleton.parents) + 1])
    rest = np.vstack([one, skeleton.rest_rotations]), np.vstack([np.zeros(3), skeleton.rest_translations])
    n_frames = clip.n_frames
    return MotionClip(
        clip.name,
        Skeleton(("ground", *skeleton.names), parents, *rest, forward),
        clip.frame_rate,
        np.concatenate([np.tile(one, (n_frames, 1, 1)), clip.rotations], axis=1),
        np.concatenate([np.zeros((n_frames, 1, 3)), clip.translations], axis=1),
    )


def kinds(clip):
    return [finding.kind for finding in examine(clip)]


@pytest.mark.parametrize("name", CLIPS)
def test_nothing_is_wrong_with_the_sample(name):
    assert kinds(CLIPS[name]) == []


@pytest.mark.parametrize("turn", [("x", 90), ("x", -90), ("y", 90), ("y", -90), ("x", 180)], ids=str)
def test_a_walk_that_lies_is_turned_upright(turn):
    lying = moved(WALK, quat.about(turn[0], np.radians(turn[1])))
    (finding,) = (found for found in examine(lying) if found.kind is FindingKind.LYING)
    assert finding.remedy.kind is RemedyKind.STAND
    assert FindingKind.LYING not in kinds(moved(lying, np.array(finding.remedy.values)))


@pytest.mark.parametrize(
    ("scale", "factor"), [(100, 0.01), (0.01, 100), (39.37, 0.0254), (0.0254, 39.37), (2.54, 0.394)]
)
def test_a_person_in_other_units_is_scaled(scale, factor):
    (finding,) = (found for found in examine(moved(WALK, scale=scale)) if found.kind is FindingKind.SIZE)
    assert finding.remedy.kind is RemedyKind.SCALE
    assert finding.remedy.values[0] == pytest.approx(factor, rel=1e-2)
    assert f"scale it by {factor:.3g}" in finding.sentence


@pytest.mark.parametrize("height", [1.55, 1.95])
@pytest.mark.parametrize(
    ("unit", "center"),
    [(0.1, "Hips"), (0.01, "Hips"), (0.001, "Hips"), (0.0254, "Hips"), (MMD_UNIT, "センター"), (10, "Hips")],
)
def test_persons_small_and_tall_keep_their_height(unit, center, height):
    person = moved(WALK, scale=height / (unit * person_height(WALK.skeleton)))
    skeleton = replace(person.skeleton, names=(center, *person.skeleton.names[1:]))
    (finding,) = (found for found in examine(replace(person, skeleton=skeleton)) if found.kind is FindingKind.SIZE)
    assert finding.remedy.values[0] == pytest.approx(unit)


@pytest.mark.parametrize("up", [-0.4, -0.15, 0.8])
def test_feet_off_the_floor_are_set_on_it(up):
    (finding,) = examine(moved(WALK, up=up))
    assert finding.kind is FindingKind.FLOOR and ("below" if up < 0 else "above") in finding.sentence
    assert kinds(moved(WALK, up=up + finding.remedy.values[0])) == []


@pytest.mark.parametrize("name", ["walk", "turn_left_90", "arc_right"])
@pytest.mark.parametrize("degrees", [90, -90, 180])
def test_facing_elsewhere_than_the_body_does(name, degrees):
    wrong = facing(CLIPS[name], degrees)
    (finding,) = (found for found in examine(wrong) if found.kind is FindingKind.FACING)
    assert finding.remedy.kind is RemedyKind.FACE
    assert np.array(finding.remedy.values) @ CLIPS[name].skeleton.rest_forward > 0.98


@pytest.mark.parametrize("degrees", [90, 180])
def test_sideways_and_backwards_by_nature(degrees):
    """The whole body is turned against its way, and faces where its feet point."""
    turn = quat.about("z", np.radians(degrees))
    rotations = WALK.rotations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    assert FindingKind.FACING not in kinds(replace(WALK, rotations=rotations))


def test_a_root_that_stays_while_the_hips_travel():
    (finding,) = (found for found in examine(on_a_pole(WALK)) if found.kind is FindingKind.ROOT_STAYS)
    assert finding.remedy.kind is RemedyKind.ROOT and finding.remedy.bone == "Hips"
    assert "'ground'" in finding.sentence and "'Hips'" in finding.sentence


def with_rest(clip, rotations=None, translations=None):
    """The same motion over another rest pose."""
    skeleton = clip.skeleton
    rest = replace(
        skeleton,
        rest_rotations=skeleton.rest_rotations if rotations is None else rotations,
        rest_translations=skeleton.rest_translations if translations is None else translations,
    )
    return replace(clip, skeleton=rest)


def test_rest_poses_that_lie_or_are_folded():
    lying = WALK.skeleton.rest_rotations.copy()
    lying[0] = quat.multiply(quat.about("x", np.pi / 2), lying[0])
    (finding,) = (found for found in examine(with_rest(WALK, lying)) if found.kind is FindingKind.ODD_REST)
    assert "lies" in finding.sentence and finding.remedy.kind is RemedyKind.BY_HAND
    folded = WALK.skeleton.rest_translations.copy()
    folded[1:] = np.linalg.norm(folded[1:], axis=1)[:, None] * [1.0, 0, 0]
    rest = np.tile([1.0, 0, 0, 0], (len(folded), 1))
    (finding,) = (found for found in examine(with_rest(WALK, rest, folded)) if found.kind is FindingKind.ODD_REST)
    assert "folded" in finding.sentence


def test_remedies_of_the_character_are_none_of_a_clip():
    (finding,) = examine(moved(WALK, up=-0.4))
    with pytest.raises(ClipError, match="the character of clip 'walk'"):
        apply_remedy(WALK, finding.remedy)


def test_a_crawl_and_someone_who_lies_are_not_turned_upright():
    hips = WALK.translations[:, 0, :2]
    lying = moved(WALK, quat.about("x", np.pi / 2))
    still = lying.translations.copy()
    still[:, 0] = still[:1, 0]
    assert FindingKind.LYING not in kinds(replace(lying, translations=still))
    # On its belly, head ahead.
    turn = quat.between([0.0, 0, 1], np.append(hips[-1] - hips[0], 0.0))
    rotations = WALK.rotations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    assert FindingKind.LYING not in kinds(replace(WALK, rotations=rotations))


def on_all_fours(clip):
    """The clip with its trunk bent forward by 90 degrees, at rest as well."""
    skeleton, spine = clip.skeleton, clip.skeleton.index("Spine")
    root = skeleton.rest_rotations[0]
    bend = quat.multiply(quat.inverse(root), quat.about("x", np.pi / 2), root)
    rotations, rests = clip.rotations.copy(), skeleton.rest_rotations.copy()
    rotations[:, spine] = quat.multiply(bend, rotations[:, spine])
    rests[spine] = quat.multiply(bend, rests[spine])
    return replace(clip, skeleton=replace(skeleton, rest_rotations=rests), rotations=rotations)


@pytest.mark.parametrize("degrees", [90, -90])
@pytest.mark.parametrize("posture", [lambda clip: clip, on_all_fours], ids=["upright", "on all fours"])
def test_nobody_walks_straight_up(posture, degrees):
    """The head of an animal is ahead of its feet: read with another axis up it stands, and walks into the air."""
    clip = moved(posture(WALK), turn=quat.about("x", np.radians(degrees)))
    (finding,) = examine(clip)
    assert finding.kind is FindingKind.LYING and finding.remedy.kind is RemedyKind.STAND
    mended = moved(clip, turn=np.array(finding.remedy.values))
    assert kinds(mended) == kinds(posture(WALK))
    hips, feet = (mended.world[1][:, mended.skeleton.index(name), 2] for name in ("Hips", "LeftFoot"))
    assert np.all(hips > feet)
