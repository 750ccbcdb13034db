"""Pairs of a left and a right bone, recognized by their names."""

import re
from collections.abc import Iterable

_WORDS = {
    "left": "right",
    "right": "left",
    "l": "r",
    "r": "l",
    "左": "右",
    "右": "左",
    "lf": "rt",
    "lt": "rt",
    "rt": "lf",
}
_SIDE = re.compile(
    r"""
      left | right                              # LeftUpLeg, mixamorig:LeftUpLeg, leg_left
    | (?<![a-z0-9]) [lr] (?![a-z0-9])           # thigh.L, thigh.L.001, upperleg_l, l_thigh, Bip01 L Thigh
    | (?<![a-z0-9]) (?: lf | lt | rt ) (?![a-z0-9])  # thigh_lf
    | 左 | 右                                    # 左足
    | (?-i: (?<![A-Za-z0-9]) [LR] (?=[A-Z]) )   # LThumb, Hero_LThumb
    | (?-i: (?<![A-Za-z0-9]) [lr] (?=[A-Z]) )   # lThumb
    | (?-i: (?<=[a-z0-9]) [LR] (?=[A-Z][a-z]) ) # HeroLThumb
    | (?-i: (?<![A-Za-z0-9]) [lr] (?=[a-z]{3}) ) # lthumb
    | (?-i: (?<=[a-z0-9]) [LR] (?![A-Za-z]) )   # ThumbL
    """,
    re.VERBOSE | re.IGNORECASE,
)


def mirrored_pairs(names: Iterable[str]) -> list[tuple[str, str]]:
    """List (left, right) for every two names that differ only in their side, in the order of the left ones.

    >>> mirrored_pairs(["hips", "thigh.R", "thigh.L", "hand_l", "hand_r"])
    [('thigh.L', 'thigh.R'), ('hand_l', 'hand_r')]
    """
    names = list(names)
    known = set(names)
    pairs = []
    for name in names:
        for match in _SIDE.finditer(name):
            word = match.group()
            other = _WORDS[word.lower()]
            other = other.upper() if word.isupper() else other.capitalize() if word[0].isupper() else other
            partner = name[: match.start()] + other + name[match.end() :]
            if word[0] in "lL左" and partner in known:
                pairs.append((name, partner))
                break
    return pairs
