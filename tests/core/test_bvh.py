"""The reader of BVH files: the sample's motion, written in the manners of many programs, comes back in its place."""

import os
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from core.errors import ClipError
from core.motion import quat
from core.motion.body_size import CMU_UNIT, MMD_UNIT
from core.motion.bvh.character import BvhCharacter, understand_bvh_steps
from core.motion.bvh.clip import bvh_clip_steps, fit_character
from core.motion.bvh.file import BvhFile
from core.motion.bvh.reader import load_bvh_steps, parse_bvh_steps
from core.motion.clip import MotionClip
from core.motion.repertoire import sample_repertoire
from core.progress import finish

from .bvh import read_bvh
from .bvh_writer import bvh_text


@cache
def walks() -> dict[str, MotionClip]:
    """Some of the sample's clips, half a second each of which is enough for most."""
    return {clip.name: clip for clip in sample_repertoire(30)}


@cache
def walk_text(name: str = "walk", **manner) -> str:
    return bvh_text(walks()[name], **manner)


def parsed(content: str | bytes, name: str = "walk.bvh") -> BvhFile:
    return finish(parse_bvh_steps(content.encode() if isinstance(content, str) else content, name))


def understood(files, unit: float | None = None, up: str = "") -> list[BvhCharacter]:
    return finish(understand_bvh_steps(files, unit, up))


def clips_of(*files: BvhFile, unit: float | None = None, up: str = "") -> list[MotionClip]:
    """What an import makes of files: clips on the skeleton of the first."""
    characters = understood(files, unit, up)
    return [
        finish(bvh_clip_steps(file, character, fit_character(characters[0], character)))
        for file, character in zip(files, characters, strict=True)
    ]


def assert_same_motion(clip: MotionClip, expected: MotionClip, atol: float = 1e-4) -> None:
    joints = [clip.skeleton.index(name) for name in expected.skeleton.names]
    np.testing.assert_allclose(clip.world[1][:, joints], expected.world[1], atol=atol)
    assert clip.frame_rate == expected.frame_rate


def decimal_commas(text: str) -> str:
    head, mark, motion = text.partition("Frame Time")
    return head.replace(".", ",") + mark + motion.replace(".", ",")


TIME = "Frame Time: 0.033333\n"


def several_lines(text: str, between: str = "\n") -> str:
    head, mark, motion = text.partition(TIME)
    return head + mark + between.join(motion.split())


def commas_between(text: str) -> str:
    head, mark, motion = text.partition(TIME)
    return head + mark + motion.replace(" ", ", ")


DIALECTS = {
    "plain": lambda text: text,
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "CR": lambda text: text.replace("\n", "\r"),
    "tabs": lambda text: text.replace(" ", "\t"),
    "no final newline": lambda text: text.rstrip("\n"),
    "blank lines": lambda text: text.replace("\n", "\n\n"),
    "braces on the same line": lambda text: text.replace("\n{\n", " {\n"),
    "one line for a joint": lambda text: text.replace("\n{\n", " { ").replace("\nCHANNELS", " CHANNELS"),
    "End Name": lambda text: text.replace("End Site", "End LeftHandEnd"),
    "lower case": lambda text: text.replace("ROOT", "root").replace("JOINT", "joint").replace("OFFSET", "Offset"),
    "channels in lower case": lambda text: text.replace("rotation", "ROTATION").replace("Xposition", "xposition"),
    "comments": lambda text: (
        "# by hand\n" + text.replace("OFFSET", "// where\nOFFSET").replace("MOTION\n", "MOTION\n# m\n")
    ),
    "a comment after numbers": lambda text: text.rstrip("\n") + "  # the last frame\n",
    "decimal commas": decimal_commas,
    "commas between numbers": commas_between,
    "frames over several lines": several_lines,
    "all frames on one line": lambda text: several_lines(text, " "),
    "no colons": lambda text: text.replace("Frames:", "Frames").replace("Frame Time:", "Frame Time"),
    "no frames announced": lambda text: text.replace("Frames: 82\n", ""),
    "the time first": lambda text: text.replace("Frames: 82\n", "").replace("0.033333\n", "0.033333\nFrames: 82\n", 1),
    "a rate": lambda text: text.replace("Frame Time: 0.033333", "Frame Rate: 30"),
    "three digits": lambda text: text.replace("Frame Time: 0.033333", "Frame Time: 0.033"),
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects(dialect):
    [clip] = clips_of(parsed(DIALECTS[dialect](walk_text())))
    assert_same_motion(clip, walks()["walk"])
    assert clip.name == "walk" and clip.skeleton.names[0] == "Hips"


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_encodings(encoding):
    [clip] = clips_of(parsed(walk_text().encode(encoding)))
    assert_same_motion(clip, walks()["walk"])


JAPANESE = {
    "Hips": "センター", "Spine": "上半身", "Spine1": "上半身2", "Spine2": "胸", "Neck": "首", "Head": "頭",
    "LeftUpLeg": "左足", "LeftLeg": "左ひざ", "LeftFoot": "左足首",
    "RightUpLeg": "右足", "RightLeg": "右ひざ", "RightFoot": "右足首",
}  # fmt: skip


@pytest.mark.parametrize(
    ("encoding", "names"),
    [
        ("cp932", JAPANESE),
        ("utf-8", JAPANESE),
        ("utf-16", JAPANESE),
        ("latin-1", {"Hips": "Hüfte", "Head": "Tête", "LeftFoot": "Pé esquerdo"}),
        ("utf-8", {"Hips": "Hüfte", "Head": "Tête"}),
        ("ascii", {"Hips": "mixamorig1:Hips", "LeftUpLeg": "Bip01 L Thigh", "Head": "MOTION", "Neck": "End"}),
    ],
)
def test_names(encoding, names):
    text = walk_text(name_of=lambda name: names.get(name, name))
    file = parsed(text.encode(encoding))
    original = walks()["walk"]
    assert set(file.names) == {names.get(name, name) for name in original.skeleton.names}
    [clip] = clips_of(file)
    joints = [clip.skeleton.index(names.get(name, name)) for name in original.skeleton.names]
    np.testing.assert_allclose(clip.world[1][:, joints], original.world[1], atol=1e-4)


def test_names_that_come_twice_or_are_long():
    text = walk_text().replace("LeftHand", "Bone").replace("RightHand", "Bone").replace("Head", "H" * 80)
    names = parsed(text).names
    assert len(set(names)) == len(names) and {"Bone", "Bone.001"} <= set(names)
    assert max(len(name.encode()) for name in names) <= 63


@pytest.mark.parametrize("order", ["XYZ", "ZYX", "YXZ", "ZXY"])
@pytest.mark.parametrize("all_positions", [False, True])
def test_channels(order, all_positions):
    [clip] = clips_of(parsed(walk_text(order=order, all_positions=all_positions)))
    assert_same_motion(clip, walks()["walk"])


def test_channels_mixed():
    """Rotations before places, and channels of another kind between them."""
    text = walk_text()
    head, mark, motion = text.partition("Frame Time: 0.033333\n")
    head = head.replace(
        "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation",
        "7 Zrotation Xrotation Yrotation Yposition Xscale Zposition Xposition",
    )
    rows = np.array([row.split() for row in motion.splitlines()])
    rows = np.concatenate([rows[:, [3, 4, 5, 1]], np.ones_like(rows[:, :1]), rows[:, [2, 0]], rows[:, 6:]], axis=1)
    [clip] = clips_of(parsed(head + mark + "\n".join(" ".join(row) for row in rows)))
    assert_same_motion(clip, walks()["walk"])


def test_places_stand_for_offsets_and_zeros_are_added():
    file = parsed(walk_text(all_positions=True))
    np.testing.assert_allclose(file.translations()[:, 5], file.values[:, file.columns[5] : file.columns[5] + 3])
    values = file.values.copy()
    for joint in range(1, file.n_joints):
        values[:, file.columns[joint] : file.columns[joint] + 3] = 0.0
    zeros = replace(file, values=values)
    np.testing.assert_allclose(zeros.translations()[3, 1:], file.offsets[1:])


@pytest.mark.parametrize("up", ["Y", "Z", "-Y", "X"])
@pytest.mark.parametrize("folded", ["", "up", "left"])
@pytest.mark.parametrize("unit", [1.0, 0.01, 0.0254, CMU_UNIT])
def test_axes_units_and_rest_poses(up, folded, unit):
    file = parsed(walk_text(up=up, folded=folded, unit=unit))
    [character] = understood([file])
    assert (character.up, character.unit) == (up, unit)
    assert 1.5 < character.height < 1.9 and f"{up} is up" in character.describe()
    [clip] = clips_of(file)
    assert_same_motion(clip, walks()["walk"])
    # The rest pose stands at the origin, on the ground, upright.
    places = clip.skeleton.rest_world[1]
    assert abs(places[:, 2].min()) < 1e-6 and np.abs(places[0, :2]).max() < 1e-6
    assert places[clip.skeleton.index("Head"), 2] > 1.3 and 0.7 < places[0, 2] < 1.1


@pytest.mark.parametrize("height", [1.55, 1.75, 1.95])
@pytest.mark.parametrize("unit", [1.0, 0.1, 0.01, 0.001, 0.0254, MMD_UNIT])
def test_persons_small_and_tall_in_each_unit(unit, height):
    japanese = {"Hips": "センター", "LeftUpLeg": "左足", "RightUpLeg": "右足"} if unit == MMD_UNIT else {}
    [usual] = understood([parsed(walk_text())])
    text = walk_text(unit=unit * usual.height / height, name_of=lambda name: japanese.get(name, name))
    [character] = understood([parsed(text)])
    assert character.unit == unit and character.height == pytest.approx(height, rel=1e-3)


def test_axes_without_names():
    names = {name: f"bone{index}" for index, name in enumerate(walks()["walk"].skeleton.names)}
    for up in ("Y", "Z", "-Y"):
        [character] = understood([parsed(walk_text(up=up, name_of=names.__getitem__))])
        assert (character.up, character.unit) == (up, 0.01)


def test_what_is_set_counts():
    [character] = understood([parsed(walk_text())], unit=0.02, up="Z")
    assert (character.up, character.unit) == ("Z", 0.02)


@pytest.mark.parametrize("offset", ["0 0 0", "268 99 -45220"])
def test_a_place_on_the_stage_in_an_offset(offset):
    """It lifts nobody, and makes nobody larger: what the channels say is where the hips are."""
    text = walk_text(extra_root="joint_Root")
    start = text.index("OFFSET", text.index("JOINT Hips"))
    file = parsed(text[:start] + f"OFFSET {offset}" + text[text.index("\n", start) :])
    [character] = understood([file])
    assert character.unit == 0.01 and 1.5 < character.height < 1.9
    [clip] = clips_of(file)
    assert_same_motion(clip, walks()["walk"])
    assert np.abs(clip.skeleton.rest_world[1]).max() < 2.0


ALIKE = {
    "other axes": {"up": "Z"},
    "another unit": {"unit": 1.0},
    "folded": {"folded": "up"},
    "folded otherwise": {"folded": "left", "order": "ZYX"},
    "all of it": {"up": "-Y", "unit": 0.0254, "folded": "left"},
}


@pytest.mark.parametrize("first", ["", *ALIKE])
@pytest.mark.parametrize("second", ALIKE)
def test_other_rest_poses_under_the_same_names_are_carried_over(first, second):
    files = [
        parsed(walk_text(**ALIKE.get(first, {})), "a.bvh"),
        parsed(walk_text("turn_left_90", **ALIKE[second]), "b.bvh"),
    ]
    first_clip, second_clip = clips_of(*files)
    assert first_clip.skeleton.is_like(second_clip.skeleton)
    assert_same_motion(first_clip, walks()["walk"])
    assert_same_motion(second_clip, walks()["turn_left_90"], atol=2e-3)


def test_another_size_walks_at_the_size_of_the_first():
    small = walks()["turn_left_90"]
    text = walk_text("turn_left_90", unit=0.01 / 0.7)  # everything 0.7 times as long, and so is the way
    own, other = understood([parsed(walk_text()), parsed(text)], unit=0.01)
    fit = fit_character(own, other)
    assert fit.reason == "another size" and fit.ratio == pytest.approx(1 / 0.7, rel=1e-4)
    clip = finish(bvh_clip_steps(parsed(text), other, fit))
    assert_same_motion(clip, small, atol=2e-3)


def test_other_joints_are_carried_over_and_named():
    renamed = walk_text("turn_left_90", name_of=lambda name: {"Head": "Skull"}.get(name, name))
    first, other = understood([parsed(walk_text()), parsed(renamed)])
    fit = fit_character(first, other)
    assert fit.unmoved == ("Head",)
    clip = finish(bvh_clip_steps(parsed(renamed), other, fit))
    expected = walks()["turn_left_90"]
    joints = [expected.skeleton.index(name) for name in clip.skeleton.names]
    np.testing.assert_allclose(clip.world[1], expected.world[1][:, joints], atol=2e-3)


def test_joints_that_say_nothing_are_refused():
    renamed = walk_text(name_of=lambda name: f"{name[::-1]}{len(name)}" if "Leg" in name else name[::-1])
    flat = "\n".join("OFFSET 0 1 0" if "OFFSET" in line else line for line in renamed.splitlines())
    first, other = understood([parsed(walk_text()), parsed(flat)])
    with pytest.raises(ClipError, match="is not known"):
        fit_character(first, other)


@pytest.mark.parametrize(("announced", "said"), [(82, 0), (0, 1), (500, 1), (10, 1)])
def test_frames_that_are_there_count(announced, said):
    file = parsed(walk_text().replace("Frames: 82", f"Frames: {announced}"))
    assert file.n_frames == 82 and len(file.remarks) == said
    assert all(f"announces {announced} frames and holds 82" in remark for remark in file.remarks)


def test_two_skeletons_in_one_file():
    head, _, motion = walk_text().partition("MOTION")
    other = "ROOT Prop\n{\nOFFSET 0 5 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
    start = motion.index("0.033333\n") + 9
    rows = "".join(f"{row} 7\n" for row in motion[start:].splitlines())
    file = parsed(f"{head}{other}MOTION{motion[:start]}{rows}")
    assert "several skeletons; the first, 'Hips', is used" in file.remarks[0]
    [clip] = clips_of(file)
    assert_same_motion(clip, walks()["walk"])


RATES = {
    "0.033333": 30, "0.0333": 30, "0.033": 30, "0,0333333": 30, "0.0416667": 24, "0.0417": 24, "0.041708": 23.976,
    "0.0083333": 120, "0.00833": 120, "0.0333667": 29.97, "0.016667": 60, "0.05": 20, ".04": 25, "1e-2": 100,
}  # fmt: skip


@pytest.mark.parametrize("time", RATES)
def test_frame_times_of_few_digits(time):
    rate = parsed(walk_text().replace("Frame Time: 0.033333", f"Frame Time: {time}")).frame_rate
    assert rate == pytest.approx(RATES[time], abs=1e-3)


DAMAGED = {
    "": "not a BVH file",
    "HIERARCHY": "not a BVH file",
    "\x00\x01\x02": "not a BVH file",
    walk_text()[:400]: "braces",
    walk_text().partition("MOTION")[0]: "how long its frames last",
    walk_text().replace("Frame Time: 0.033333", "Frame Time: 0"): "how long its frames last",
    walk_text().replace("Frame Time: 0.033333", "Frame Time: soon"): "how long its frames last",
    walk_text().replace("Frame Time: 0.033333", "Frame Time: 33.3333"): "33.3333 seconds each",
    walk_text()[:-30]: "incomplete",
    walk_text().rstrip() + "x\n": "which is not a number, in frame 82",
    walk_text().rstrip() + " -1.#IND\n": "'-1.#IND'",
    walk_text().replace("0.033333\n", "0.033333\nnan ", 1).rpartition(" ")[0]: "not a number",
    walk_text().replace("3 Zrotation", "3 Yrotation"): "channels of",
    walk_text().replace("3 Zrotation", "4 Zrotation"): "channels of",
    walk_text().replace("OFFSET", "OFFSET up"): "not three numbers",
}


@pytest.mark.parametrize("text", DAMAGED, ids=[f"{k} {said}" for k, said in enumerate(DAMAGED.values())])
def test_damaged_files(text):
    with pytest.raises(ClipError, match=DAMAGED[text]) as caught:
        parsed(text)
    assert "walk.bvh" in str(caught.value) and str(caught.value).endswith(".")


def test_numbers_of_thousands_of_digits():
    many = "9" * 5000
    # What a file announces does not matter.
    text = walk_text()
    announced = re.sub(r"Frames: *\d+", f"Frames: {many}", text)
    assert announced != text and len(parsed(announced).values) == len(parsed(text).values)
    for changed in (
        re.sub(r"CHANNELS 3", f"CHANNELS {many}", text, count=1),
        text.replace("Frame Time: ", f"Frame Time: {many}"),
    ):
        assert changed != text
        with pytest.raises(ClipError):
            parsed(changed)


def test_only_files_are_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.bvh")
    (tmp_path / "zero.bvh").symlink_to("/dev/zero")
    (tmp_path / "loop.bvh").symlink_to(tmp_path / "loop.bvh")
    for name, why in (("pipe", "no file"), ("zero", "no file"), ("loop", "in a circle"), ("none", "no such file")):
        with pytest.raises(ClipError, match=rf"'{name}\.bvh' cannot be read, because .*{why}"):
            finish(load_bvh_steps(tmp_path / f"{name}.bvh"))


def test_recorded_motion_as_an_independent_reader_has_it(data_folder):
    for name in ("16_10", "16_16", "16_19"):
        path = data_folder / "cmu16" / f"{name}.bvh"
        [clip] = clips_of(parsed(path.read_bytes(), path.name))
        expected = read_bvh(path)
        assert clip.n_frames == expected.n_frames and clip.frame_rate == 120
        np.testing.assert_allclose(clip.world[1], expected.world[1], atol=1e-6)
        turns = quat.angle_between(clip.rotations, expected.rotations)
        assert turns.max() < 1e-6


def test_one_person_lying_among_others_lies():
    """Up is what most frames say: a file of the same skeleton in which someone lies does not turn the axes."""
    walk, lying = parsed(walk_text()), parsed(walk_text("turn_left_90"))
    values = lying.values.copy()
    values[:, :6] = [0.0, 20.0, 0.0, 0.0, 90.0, 0.0]
    lying = replace(lying, values=values)
    assert [character.up for character in understood([lying])] != ["Y"]
    assert [character.up for character in understood([lying, walk, walk])] == ["Y"] * 3
