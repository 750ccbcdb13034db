"""BVH files, in any of the manners that programs write them: a hierarchy, its channels, and their values.

The format has no standard. Known here: text in UTF-8, UTF-16 or UTF-32 with or without a mark, in Shift-JIS and in
Latin-1; any line ends; braces anywhere; ``End Site`` or ``End Name``; names with spaces; comments; decimal commas;
channels in any order, on all joints or some; frames over several lines, more or fewer than announced.
"""

import re
import warnings
from collections.abc import Generator
from pathlib import Path

import numpy as np

from ... import wording
from ...errors import ClipError
from ...files import read_regular, why
from ...progress import Progress
from ..clip import FASTEST_RATE, SLOWEST_RATE
from .file import BvhFile
from .hierarchy import LARGEST, NUMBER, Hierarchy, distinct, halves, parse_hierarchy

_LARGEST_FILE = 500_000_000
"""Bytes; its numbers take four times as much at most, and an hour of motion is a fifth of it."""
_CHUNK = 1 << 18  # bytes that are turned into numbers at a time
_DIGITS = 18
"""Of an announced number of frames; nothing has more."""
_WHOLE_RATES = (24, 25, 30, 48, 50, 60, 75, 90, 100, 120, 144, 150, 180, 200, 240, 300)
_OTHER_RATES = tuple(rate / 1.001 for rate in (24, 30, 60))
_HEADER = re.compile(
    rb"(?i)(?:\s|(?:#|//)[^\r\n]*)*(Frame\s*Time|Frame\s*Rate|Frames?)\b[ \t]*:?[ \t]*([^\s]*)",
)
_COMMENT = re.compile(rb"(?m)(?:^|(?<=\s))(?:#|//)[^\r\n]*")


def load_bvh_steps(path) -> Generator[Progress, None, BvhFile]:
    """Read a BVH file, as a generator that yields progress; ClipError names the file and what is wrong with it."""
    path = Path(path)
    yield Progress(0.0, f"Reading {path.name}")
    try:
        data = read_regular(path, _LARGEST_FILE)
    except OSError as error:
        raise ClipError(f"'{path.name}' cannot be read, because {why(error)}.") from None
    return (yield from parse_bvh_steps(data, path.name))


def parse_bvh_steps(data: bytes, name: str) -> Generator[Progress, None, BvhFile]:
    """Read the content of the BVH file called ``name``.

    Raises ClipError, naming the file and the remedy, if it is no BVH file, says no frame time or one that no motion
    clip can have, holds fewer than two frames, or values that are no numbers or do not fill its frames. How many
    frames it announces does not matter: those that are there count.

    >>> from core.progress import finish
    >>> hierarchy = b"HIERARCHY ROOT Hips { OFFSET 0 0 0 CHANNELS 1 Yrotation End Site { OFFSET 0 1 0 } }"
    >>> finish(parse_bvh_steps(hierarchy + b" MOTION Frames: 2 Frame Time: 0,04 0 90", "turn.bvh")).frame_rate
    25.0
    """
    head, motion = halves(data)
    hierarchy = parse_hierarchy(head, name)
    n_channels = sum(map(len, hierarchy.channels))
    announced, frame_rate, start = _parse_header(motion, name)
    values = yield from _numbers_steps(motion[start:], name, n_channels)
    if len(values) % n_channels:
        raise ClipError(
            f"The last frame in '{name}' is incomplete: {len(values) % n_channels} of {n_channels} values; "
            "delete that line or export the file again."
        )
    values = values.reshape(-1, n_channels)
    bad = ~(np.abs(values) <= LARGEST)
    if bad.any():
        raise ClipError(
            f"'{name}' holds a value that is not a number, or far too large to be one, in frame "
            f"{int(np.argmax(bad.any(axis=1))) + 1}; export it again."
        )
    if len(values) < 2:
        raise ClipError(f"'{name}' holds {wording.counted(len(values), 'frame')}; a motion needs at least two.")
    remarks = []
    if announced is not None and announced != len(values):
        remarks.append(
            f"'{name}' announces {wording.counted(announced, 'frame')} and holds {wording.number(len(values))}; "
            "those are used."
        )
    if not _has_size(hierarchy, values):
        raise ClipError(f"'{name}' holds no skeleton of any size; it is not a BVH file or is damaged.")
    n_joints = hierarchy.parents.index(-1, 1) if -1 in hierarchy.parents[1:] else len(hierarchy.names)
    if n_joints < len(hierarchy.names):
        remarks.append(f"'{name}' holds several skeletons; the first, '{hierarchy.names[0]}', is used.")
    nowhere = np.full(3, np.nan)
    return BvhFile(
        name=name,
        names=tuple(distinct(hierarchy.names[:n_joints])),
        parents=np.array(hierarchy.parents[:n_joints]),
        offsets=np.array([np.zeros(3) if offset is None else offset for offset in hierarchy.offsets[:n_joints]]),
        ends=np.array([nowhere if end is None else end for end in hierarchy.ends[:n_joints]]),
        channels=tuple(hierarchy.channels[:n_joints]),
        columns=np.cumsum([0, *map(len, hierarchy.channels)])[:n_joints],
        frame_rate=frame_rate,
        values=values,
        remarks=tuple(remarks),
    )


def _has_size(hierarchy: Hierarchy, values: np.ndarray) -> bool:
    """Test whether any joint is elsewhere than its parent."""
    if any(place is not None and place.any() for place in (*hierarchy.offsets[1:], *hierarchy.ends)):
        return True
    below = [channel for channels in hierarchy.channels[1:] for channel in channels]
    columns = [k - len(below) for k, channel in enumerate(below) if channel.endswith("position")]
    return bool(values[:, columns].any())


def _parse_header(motion: bytes, name: str) -> tuple[int | None, float, int]:
    """Return the number of frames announced, the frame rate, and where the values begin."""
    announced, time, number, start = None, "", 0.0, 0
    while found := _HEADER.match(motion, start):
        start = found.end()
        word, value = re.sub(rb"\s", b"", found[1]).lower(), found[2].decode("ascii", "replace")
        if word in (b"frametime", b"framerate"):
            time = value
            number = float(value.replace(",", ".")) if NUMBER.fullmatch(value) else 0.0
            if word == b"framerate" and number > 0:
                time, number = wording.exact(1 / number), 1 / number
        elif value.isdigit():
            announced = int(value[:_DIGITS])
    if not time or not 0 < number < np.inf:
        raise ClipError(f"'{name}' does not say how long its frames last; repair its line 'Frame Time:'.")
    frame_rate = _frame_rate(number, time)
    if not SLOWEST_RATE <= frame_rate <= FASTEST_RATE:
        raise ClipError(
            f"The frames in '{name}' last {time} seconds each; correct its line 'Frame Time:' to between "
            f"{wording.exact(1 / FASTEST_RATE)} and {wording.exact(1 / SLOWEST_RATE)} seconds."
        )
    return announced, frame_rate, start


def _frame_rate(seconds: float, text: str) -> float:
    """Return the frames per second that a frame time in few digits stands for: 0.033 s are 30, 0.0417 s are 24."""
    rate = 1 / seconds
    if abs(rate - round(rate)) < 1e-6 * rate:
        return float(round(rate))
    places = len(re.split(r"[.,]", text)[-1]) if re.search(r"[.,]", text) and "e" not in text.lower() else 0
    if places >= 3:
        for rates in (_WHOLE_RATES, _OTHER_RATES):
            meant = [known for known in rates if abs(1 / known - seconds) < 10.0**-places]
            if meant:
                return float(min(meant, key=lambda known: abs(1 / known - seconds)))
    return round(rate, 2)


def _numbers_steps(data: bytes, name: str, n_channels: int) -> Generator[Progress, None, np.ndarray]:
    """Read all numbers of the motion; a word that is none is named in a ClipError."""
    if b"#" in data or b"//" in data:
        data = _COMMENT.sub(b"", data)
    if b"," in data:
        data = data.replace(b",", b" " if b"." in data else b".")
    parts, start, count = [], 0, 0
    while start < len(data):
        end = start + _CHUNK
        while end < len(data) and data[end] not in b" \t\r\n\f\v":
            end += 1
        chunk = data[start:end].strip()
        if chunk:
            parts.append(_numbers(chunk, name, count, n_channels))
            count += len(parts[-1])
            yield Progress(min(end / len(data), 1.0), f"Reading {name}")
        start = end
    return np.concatenate([np.zeros(0), *parts])


def _numbers(chunk: bytes, name: str, before: int, n_channels: int) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(chunk, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    words = chunk.decode("latin-1").split()
    for place, word in enumerate(words):
        if not NUMBER.fullmatch(word):
            raise ClipError(
                f"'{name}' holds '{word[:20]}', which is not a number, in frame {(before + place) // n_channels + 1}; "
                "export it again."
            )
    return np.array([float(word) for word in words])
