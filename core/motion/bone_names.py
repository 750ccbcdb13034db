"""Names of bones in the dialects of many programs, read as a side and a core."""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Sequence

_SIDES = {"left": "left", "l": "left", "lf": "left", "lt": "left"} | {
    "right": "right", "r": "right", "rt": "right", "rg": "right"
}  # fmt: skip
_DECORATION = {
    *("def", "bip", "valve", "biped", "j", "c", "b", "x", "cc", "base", "mixamorig", "character", "bind", "skin"),
    *("jnt", "jt", "joint", "bn", "bone", "sk", "skel", "stretch", "bend"),
}
"""Words that say nothing of a bone's purpose: marks of programs, and of bones that stretch or bend with their limb."""

#: Longest first where one holds another.
_JAPANESE = [
    *(("左", "left"), ("右", "right"), ("足首", "ankle"), ("足先", "toes"), ("つま先", "toes")),
    *(("足", "thigh"), ("ひざ", "knee"), ("ヒザ", "knee"), ("膝", "knee"), ("手首", "hand"), ("捩", "twist")),
    *(("ひじ", "elbow"), ("肘", "elbow"), ("腕", "upperarm"), ("肩", "collar"), ("上半身", "spine"), ("指", "finger")),
    *(("下半身", "pelvis"), ("センター", "center"), ("首", "neck"), ("頭", "head"), ("親", "parent")),
]


def are_japanese(names: Iterable[str]) -> bool:
    """Return True if any of the names of bones is Japanese, as in MikuMikuDance.

    >>> are_japanese(["Hips", "左足"]), are_japanese(["Hips"])
    (True, False)
    """
    return any(word in unicodedata.normalize("NFKC", name) for name in names for word, _ in _JAPANESE)


def split_names(names: Sequence[str]) -> list[tuple[str, str]]:
    """Split each bone's name into its side ("left", "right" or "") and its core, in lower case without separators.

    What most names begin with is a prefix, and says nothing.

    >>> split_names(["Hero_Hips", "Hero_LeftUpLeg", "Hero_lShin", "左足首"])
    [('', 'hips'), ('left', 'upleg'), ('left', 'shin'), ('left', 'ankle')]
    """
    words = [_words(name) for name in names]
    while True:
        firsts = Counter(own[0] for own in words if len(own) > 1).most_common(1)
        if not firsts or firsts[0][1] <= 0.6 * len(words) or firsts[0][0] in _SIDES:
            break
        words = [own[1:] if len(own) > 1 and own[0] == firsts[0][0] else own for own in words]
    return [_side_and_core(own) for own in words]


def _words(name: str) -> list[str]:
    name = unicodedata.normalize("NFKC", name)  # full-width letters
    for character, word in _JAPANESE:
        name = name.replace(character, f" {word} ")
    name = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", re.split(r"[:|]", name)[-1])
    name = re.sub(r"([A-Z])([A-Z][a-z])", r"\1 \2", name)
    words = [word.lower() for word in re.split(r"[^A-Za-z]+", name) if word]
    # "mixamorigLeftUpLeg" and "leftupleg" are written without any separator.
    return [part for word in words for part in _parted(word)]


def _parted(word: str) -> list[str]:
    found = re.fullmatch(r"(left|right)(.+)", word)
    return [*found.groups()] if found else [word]


def _side_and_core(words: list[str]) -> tuple[str, str]:
    side, core = "", []
    for word in words:
        if word in _SIDES and not side:
            side = _SIDES[word]
        elif word not in _DECORATION:
            core.append(word)
    return side, "".join(core)
