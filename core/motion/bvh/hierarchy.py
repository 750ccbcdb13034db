"""The first half of a BVH file: which joints there are, where they are at rest, and what their channels are."""

import codecs
import re
from dataclasses import dataclass, field

import numpy as np

from ...errors import ClipError
from ...wording import quoted

NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?")
LARGEST = 1e12
"""Beyond any place, whatever the unit."""

_LONGEST_NAME = 59  # bytes; Blender keeps 63 of a bone's name, and a number may have to be added
_MOTION = re.compile(rb"(?i)(?:^|[\r\n}])\s*(MOTION)\b")
_CHANNEL = re.compile(r"(?i)([xyz])[ _]?(pos|trans|loc|rot|scal)")


@dataclass
class Hierarchy:
    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[np.ndarray | None] = field(default_factory=list)
    ends: list[np.ndarray | None] = field(default_factory=list)
    channels: list[tuple[str, ...]] = field(default_factory=list)


def parse_hierarchy(text: str, name: str) -> Hierarchy:
    text = re.sub(r"(?:^|(?<=\s))(?:#|//)[^\r\n]*", "", text)
    if not re.match(r"\s*HIERARCHY\b", text, re.IGNORECASE) or not re.search(r"\bCHANNELS\b", text, re.IGNORECASE):
        raise ClipError(f"'{name}' is not a BVH file: it holds no skeleton.")
    # One statement a line, whatever the exporter did.
    text = re.sub(r"([{}])", r"\n\1\n", text)
    text = re.sub(r"(?i)\b(OFFSET[ \t]+[-+.,\d]|CHANNELS[ \t]+\d)", r"\n\1", text)
    text = re.sub(r"(?i)\bHIERARCHY\b", "\n", text, count=1)
    damaged = ClipError(f"The skeleton in '{name}' is damaged: its braces do not match; export it again.")
    found, stack, opened = Hierarchy(), [], None
    lines = re.split(r"[\r\n]+", text)[::-1]
    while lines:
        line = lines.pop()
        words = line.split()
        keyword = words[0].lower() if words else ""
        following = next((k for k, word in enumerate(words[1:], 1) if word.lower() in ("joint", "end")), 0)
        if keyword in ("offset", "channels") and following:
            lines.append(" ".join(words[following:]))
            words = words[:following]
            line = " ".join(words)
        if keyword in ("root", "joint"):
            opened = len(found.names)
            found.names.append(" ".join(words[1:]) or "Joint")
            found.parents.append(next((joint for joint in reversed(stack) if joint >= 0), -1))
            found.offsets.append(None)
            found.ends.append(None)
            found.channels.append(())
            if keyword == "joint" and found.parents[-1] < 0:
                raise damaged
        elif keyword == "end":
            opened = -1
        elif keyword == "{":
            if opened is None:
                raise damaged
            stack.append(opened)
            opened = None
        elif keyword == "}":
            if not stack:
                raise damaged
            stack.pop()
        elif keyword == "offset" and stack:
            place = _numbers(line[line.lower().index("offset") + 6 :], 3)
            if place is None:
                raise ClipError(
                    f"An offset in '{name}' is not three numbers: '{' '.join(words[1:])[:40]}'; export the file again."
                )
            if stack[-1] >= 0:
                found.offsets[stack[-1]] = place
            else:
                above = next((joint for joint in reversed(stack) if joint >= 0), None)
                if above is not None and found.ends[above] is None:
                    found.ends[above] = place
        elif keyword == "channels" and stack and stack[-1] >= 0:
            found.channels[stack[-1]] = _parse_channels(words[1:], found.names[stack[-1]], name)
    if stack or opened is not None:
        raise damaged
    if not found.names or not any(found.channels):
        raise ClipError(f"'{name}' is not a BVH file: it holds no skeleton.")
    return found


def _parse_channels(words: list[str], joint: str, name: str) -> tuple[str, ...]:
    kinds = {"pos": "position", "trans": "position", "loc": "position", "rot": "rotation"}
    # A count of more digits than any has is none that fits.
    count = int(words[0][:9]) if words and words[0].isdecimal() else len(words) - 1
    matches = [_CHANNEL.match(word) for word in words[1 : count + 1]]
    channels = tuple(
        f"{match[1].upper()}{kinds[match[2].lower()]}" if match and match[2].lower() in kinds else ""
        for match in matches
    )
    known = [channel for channel in channels if channel]
    if len(channels) != count or len(set(known)) < len(known) or None in matches:
        raise ClipError(
            f"The channels of {quoted(joint)} in '{name}' cannot be: '{' '.join(words)[:80]}'; export the file again."
        )
    return channels


def halves(data: bytes) -> tuple[str, bytes]:
    """Return the text before the word MOTION, and what comes after it in ASCII."""
    wide = _wide_encoding(data)
    if wide:
        data = data.decode(wide, errors="replace").encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    found = _MOTION.search(data)
    return (_decoded(data[: found.start(1)]), data[found.end() :]) if found else (_decoded(data), b"")


def _wide_encoding(data: bytes) -> str:
    """Name the encoding of text with several bytes for every letter; empty if it is none."""
    for mark, encoding in (
        (codecs.BOM_UTF32_LE, "utf-32"),
        (codecs.BOM_UTF32_BE, "utf-32"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
    ):
        if data.startswith(mark):
            return encoding
    start = data[:200]
    even, odd = start[::2].count(0), start[1::2].count(0)
    if max(even, odd) > 0.4 * len(start) and min(even, odd) == 0:
        return "utf-16-le" if odd else "utf-16-be"
    return ""


def _decoded(data: bytes) -> str:
    """Return the text of bytes in UTF-8, Shift-JIS or Latin-1, told apart by what can be.

    Kana and most of the kanji in names of bones begin with bytes that are control characters in Latin-1.
    """
    encodings = ("utf-8", "cp932") if re.search(rb"[\x81-\x9f]", data) else ("utf-8",)
    for encoding in encodings:
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            continue
    return data.decode("latin-1")


def _numbers(text: str, count: int) -> np.ndarray | None:
    """Read the first numbers of a line, with decimal points or commas."""
    if "," in text and "." in text:
        text = text.replace(",", " ")
    words = text.split()[:count]
    if len(words) < count or not all(NUMBER.fullmatch(word) for word in words):
        return None
    numbers = np.array([float(word.replace(",", ".")) for word in words])
    return numbers if (np.abs(numbers) <= LARGEST).all() else None


def distinct(names: list[str]) -> list[str]:
    """Give names that come twice a number, and cut those that are too long for Blender."""
    taken: set[str] = set()
    result = []
    for name in names:
        short = name.encode()[:_LONGEST_NAME].decode(errors="ignore")
        unique, number = short, 0
        while unique in taken:
            number += 1
            unique = f"{short}.{number:03}"
        taken.add(unique)
        result.append(unique)
    return result
