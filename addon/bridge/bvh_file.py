"""What a BVH file tells before it is imported: whether it is sound, its rate, and how long its unit may be."""

import codecs
import contextlib
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...core import wording
from ...core.errors import ClipError
from ...core.motion.clip import FASTEST_RATE, SLOWEST_RATE

CMU_UNIT = 0.056444
"""Metres per unit in the files of the CMU motion capture database (inches / 0.45)."""

_UNITS = (1.0, 0.01, 0.001, 0.0254, 0.3048, CMU_UNIT)  # metre, centimetre, millimetre, inch, foot
_SHORTEST, _TALLEST, _USUAL = 1.4, 2.1, 1.7  # height of the rest pose in metres


def guess_bvh_scale(path) -> float:
    """Metres per unit of a BVH file, guessed from the height of its rest pose.

    The likely unit that makes the character most nearly 1.7 m tall; if none makes it between 1.4 and 2.1 m,
    whatever makes it 1.7 m. Rest poses need not stand: the height is that of the extended body, leg plus
    trunk.

    Raises ClipError if the file cannot be read or holds no skeleton.
    """
    height = _rest_height(path)
    scale = min(_UNITS, key=lambda unit: abs(np.log(unit * height / _USUAL)))
    return scale if _SHORTEST <= scale * height <= _TALLEST else _USUAL / height


def check_bvh(path) -> float:
    """The frame rate of a BVH file, in frames per second, once it is found to be sound.

    Raises ClipError, naming the file and what is wrong with it, if it cannot be read, is no BVH file, says no
    frame time or one that no motion clip can have, holds fewer than two frames, or values that are no numbers or
    do not fill its frames.
    """
    name = Path(path).name
    hierarchy, motion = _halves(path)
    channels = sum(int(count) for count in re.findall(r"CHANNELS\s+(\d+)", hierarchy, re.IGNORECASE))
    if not re.match(r"\s*HIERARCHY", hierarchy, re.IGNORECASE) or channels == 0:
        raise ClipError(f"'{name}' is not a BVH file: it holds no skeleton.")
    header = re.match(r"\s*Frames:\s*\d+\s+Frame\s+Time:\s*(\S+)", motion, re.IGNORECASE)
    try:
        frame_time = float(header.group(1)) if header else 0.0
    except ValueError:
        frame_time = 0.0
    if header is None or not 0 < frame_time < np.inf:
        raise ClipError(f"'{name}' does not say how long its frames last; repair its line 'Frame Time:'.")
    # Files state the time with few digits: 0.0083333 s is 120 frames per second.
    frame_rate = round(1 / frame_time, 2)
    if not SLOWEST_RATE <= frame_rate <= FASTEST_RATE:
        raise ClipError(
            f"The frames in '{name}' last {header.group(1)} seconds each; correct its line 'Frame Time:' to between "
            f"{wording.exact(1 / FASTEST_RATE)} and {wording.exact(1 / SLOWEST_RATE)} seconds."
        )
    try:
        values = np.array(motion[header.end() :].split(), dtype=float)
    except ValueError as error:
        raise ClipError(f"The motion in '{name}' is damaged: {error}; export it again.") from None
    if not np.isfinite(values).all():
        frame = int(np.argmin(np.isfinite(values))) // channels + 1
        raise ClipError(f"'{name}' holds a value that is not a number in frame {frame}; export it again.")
    if len(values) % channels:
        raise ClipError(
            f"The last frame in '{name}' is incomplete: {len(values) % channels} of {channels} values; "
            "delete that line or export the file again."
        )
    if len(values) < 2 * channels:
        raise ClipError(f"'{name}' holds {len(values) // channels} frames; a motion needs at least two.")
    return frame_rate


@contextlib.contextmanager
def without_mark(path) -> Iterator[Path]:
    """The file itself; or, if it begins with the byte order mark of UTF-8, a copy without it while the block lasts.

    Some programs write the mark, and Blender's importer takes it for a part of the first word.
    """
    path = Path(path)
    content = path.read_bytes()
    if not content.startswith(codecs.BOM_UTF8):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="wayfarer-") as folder:
        copy = Path(folder) / path.name
        copy.write_bytes(content.removeprefix(codecs.BOM_UTF8))
        yield copy


def _rest_height(path) -> float:
    """Extent of the rest pose, in the file's units, along the axis in which it is longest without its arms."""
    positions, names = _rest_positions(_halves(path)[0])
    spread = np.ptp(positions, axis=0) if len(positions) > 1 else np.zeros(3)
    if not spread.max() > 0:
        raise ClipError(f"'{Path(path).name}' holds no skeleton of any size; it is not a BVH file or is damaged.")
    body = [
        position
        for position, name in zip(positions, names, strict=True)
        if not re.search(r"arm|hand|finger|thumb|wrist|elbow|index|shoulder|collar", name, re.IGNORECASE)
    ]
    return float(np.ptp(body, axis=0).max()) if len(body) > 1 else float(spread.max())


def _rest_positions(hierarchy: str):
    """(N, 3) positions of joints and end sites, and the joint that each belongs to."""
    positions, names, stack = [], [], [(np.zeros(3), "")]
    name = ""
    for line in hierarchy.splitlines():
        words = line.split()
        if not words:
            continue
        keyword = words[0].lower()
        if keyword in ("root", "joint") and len(words) > 1:
            name = words[1]
        elif keyword == "end":
            name = stack[-1][1]
        elif keyword == "offset":
            try:
                offset = np.array([float(word) for word in words[1:4]])
            except ValueError:
                continue
            if len(offset) == 3 and np.isfinite(offset).all():
                stack.append((stack[-1][0] + offset, name))
                positions.append(stack[-1][0])
                names.append(name)
        elif keyword == "}" and len(stack) > 1:
            stack.pop()
    return np.array(positions), names


def _halves(path) -> tuple[str, str]:
    """The text before and after the word MOTION."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise ClipError(f"'{path}' cannot be read: {error.strerror}.") from None
    parts = re.split(r"^\s*MOTION\b", text, maxsplit=1, flags=re.MULTILINE | re.IGNORECASE)
    return parts[0], parts[1] if len(parts) == 2 else ""
