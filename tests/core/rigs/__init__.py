"""The bones of characters as they come from elsewhere: one a line, indented by a tab below its parent.

Where it matters, the place of the bone's head in the rest pose follows: "name @ x y z", in metres.
"""

from pathlib import Path

import numpy as np

from core.motion.skeleton import Skeleton


def rig(name: str, root: str | None = None) -> Skeleton:
    """The skeleton in ``name``.txt; all bones rest unturned, at the origin if their place is not given.

    With ``root`` that bone becomes joint 0, and what does not hang below it hangs directly from it: as the
    extension's bridge reads an armature.
    """
    names, parents, places, trail = [], [], {}, []
    for line in (Path(__file__).parent / f"{name}.txt").read_text().splitlines():
        depth = len(line) - len(line.lstrip("\t"))
        bone, _, place = line.strip().partition(" @ ")
        trail = [*trail[:depth], bone]
        places[bone] = np.array(place.split() or [0, 0, 0], dtype=float)
        names.append(trail[-1])
        parents.append(trail[-2] if depth else None)
    root = root or names[0]
    parent_of = dict(zip(names, parents, strict=True))

    def below(bone):
        while bone is not None and bone != root:
            bone = parent_of[bone]
        return bone == root

    order = [root, *(n for n in names if n != root and below(n)), *(n for n in names if not below(n))]
    is_below = {bone: below(bone) for bone in order}
    index = {bone: number for number, bone in enumerate(order)}
    joints = [-1, *(index[parent_of[bone]] if is_below[bone] else 0 for bone in order[1:])]
    rest = np.array([places[bone] for bone in order])
    rest[1:] -= rest[joints[1:]]
    n_joints = len(order)
    upright = np.tile([1.0, 0, 0, 0], (n_joints, 1))
    return Skeleton(tuple(order), np.array(joints), upright, rest, np.array([1.0, 0, 0]))
