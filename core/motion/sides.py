"""Which joints are the left and the right one of a pair, told from their names."""

import re

import numpy as np

from .skeleton import Skeleton

_WORDS = {"left": "right", "right": "left", "l": "r", "r": "l"}
_SIDE = re.compile(
    r"""
      left | right                              # LeftUpLeg, mixamorig:LeftUpLeg, leg_left
    | (?<![a-z0-9]) [lr] (?![a-z0-9])           # thigh.L, thigh.L.001, upperleg_l, l_thigh, Bip01 L Thigh
    | (?-i: \b [LR] (?=[A-Z]) )                 # LThumb
    | (?-i: (?<=[a-z0-9]) [LR] (?![A-Za-z]) )   # ThumbL
    """,
    re.VERBOSE | re.IGNORECASE,
)


def partners(skeleton: Skeleton) -> np.ndarray:
    """(J,) int: for each joint the one whose name differs only in its side, or itself if there is none."""
    index = {name: joint for joint, name in enumerate(skeleton.names)}
    result = np.arange(skeleton.n_joints)
    for joint, name in enumerate(skeleton.names):
        if result[joint] != joint:
            continue
        for match in _SIDE.finditer(name):
            word = match.group()
            other = _WORDS[word.lower()]
            other = other.upper() if word.isupper() else other.capitalize() if word[0].isupper() else other
            partner = index.get(name[: match.start()] + other + name[match.end() :])
            if partner is not None:
                result[joint], result[partner] = partner, joint
                break
    return result
