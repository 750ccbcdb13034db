"""Motion as BVH text in the manner of several programs, for tests of the reader."""

from collections.abc import Callable

import numpy as np

from core.motion import quat
from core.motion.clip import MotionClip

AXES = {
    "Y": quat.about("x", -np.pi / 2),
    "Z": quat.IDENTITY,
    "-Y": quat.about("x", np.pi / 2),
    "X": quat.about("y", np.pi / 2),
}
"""From Z up, facing -Y, to a file's axes, by the one that is up there."""


def bvh_text(
    clip: MotionClip,
    up: str = "Y",
    unit: float = 0.01,
    folded: str = "",
    order: str = "ZXY",
    all_positions: bool = False,
    extra_root: str = "",
    name_of: Callable[[str], str] = str,
) -> str:
    """Write a clip whose character stands at rest.

    ``folded`` writes a rest pose in which every bone lies along X, with the third axis of joints upwards ("up") or to
    the left ("left"), as programs do that write the axes of joints. ``extra_root`` is the name of a root above the
    hips that stays where it is.
    """
    skeleton, to_file = clip.skeleton, AXES[up]
    rest_turns, rest_places = skeleton.rest_world
    turns, places = clip.world
    # Axes of the joints at rest, in the file.
    axes = _folded_axes(skeleton, to_file, folded) if folded else np.tile(quat.IDENTITY, (skeleton.n_joints, 1))
    moved = quat.multiply(to_file, turns, quat.inverse(rest_turns), quat.inverse(to_file), axes)
    placed, rest = quat.rotate(to_file, places) / unit, quat.rotate(to_file, rest_places) / unit
    lines, columns = ["HIERARCHY"], []

    def numbers(values) -> str:
        return " ".join(f"{value:.6f}" for value in values)

    def joint(index: int, kind: str) -> None:
        above = skeleton.parents[index]
        offset = rest[index] if above < 0 else quat.rotate(quat.inverse(axes[above]), rest[index] - rest[above])
        with_place = bool(above < 0 or all_positions)
        lines.extend([f"{kind} {name_of(skeleton.names[index])}", "{", f"OFFSET {numbers(offset)}"])
        channels = ["Xposition", "Yposition", "Zposition"] * with_place + [f"{axis}rotation" for axis in order]
        lines.append(f"CHANNELS {len(channels)} {' '.join(channels)}")
        local_turn, local_place = moved[:, index], placed[:, index]
        if above >= 0:
            back = quat.inverse(moved[:, above])
            local_turn, local_place = quat.multiply(back, local_turn), quat.rotate(back, local_place - placed[:, above])
        columns.extend([local_place] * with_place + [np.degrees(quat.to_euler(order, local_turn))])
        children = np.flatnonzero(skeleton.parents == index)
        for child in children:
            joint(int(child), "JOINT")
        if len(children) == 0:
            lines.extend(["End Site", "{", "OFFSET 0 0 0", "}"])
        lines.append("}")

    if extra_root:
        lines.extend([f"ROOT {extra_root}", "{", "OFFSET 0 0 0", "CHANNELS 3 Zrotation Xrotation Yrotation"])
        columns.append(np.zeros((clip.n_frames, 3)))
    joint(0, "JOINT" if extra_root else "ROOT")
    lines.extend("}" * bool(extra_root))
    lines.extend(["MOTION", f"Frames: {clip.n_frames}", f"Frame Time: {1 / clip.frame_rate:.6f}"])
    lines.extend(numbers(row) for row in np.concatenate(columns, axis=1))
    return "\n".join(lines) + "\n"


def _folded_axes(skeleton, to_file, folded: str) -> np.ndarray:
    places = quat.rotate(to_file, skeleton.rest_world[1])
    third = quat.rotate(to_file, [0.0, 0.0, 1.0] if folded == "up" else [1.0, 0.0, 0.0])
    other = quat.rotate(to_file, [0.0, 1.0, 0.0])
    axes = []
    for index in range(skeleton.n_joints):
        children = np.flatnonzero(skeleton.parents == index)
        along = (
            places[children[0]] - places[index] if len(children) else places[index] - places[skeleton.parents[index]]
        )
        along = along / np.linalg.norm(along)
        second = np.cross(third if abs(along @ third) < 0.9 else other, along)
        second = second / np.linalg.norm(second)
        axes.append(np.column_stack([along, second, np.cross(along, second)]))
    return quat.from_matrix(np.array(axes))
