"""Rest poses of two armatures, compared bone by bone."""

import numpy as np

from ...core.motion import quat
from .rig import read_matrices

_TURNED = np.radians(2.0)
_MOVED = 0.01
"""Share of the armature's size."""
_SHARED = 0.8


def have_same_rest(own, other) -> bool:
    """Test whether actions of the armature object ``other`` show the same on ``own``.

    Most bones are in both, and rest in the same way beside their parents. Ends of chains may be missing.
    """
    if own == other:
        return True
    here, there = own.data.bones, other.data.bones
    shared = [bone.name for bone in here if bone.name in there]
    if len(shared) < max(_SHARED * min(len(here), len(there)), 1):
        return False
    rests = [_relative_rests(bones, shared) for bones in (here, there)]
    if rests[0] is None or rests[1] is None or rests[0][2] != rests[1][2]:
        return False
    size = max(float(np.ptp(read_matrices(here, "matrix_local")[:, :3, 3], axis=0).max()), 1e-9)
    turned = quat.angle_between(rests[0][0], rests[1][0])
    moved = np.linalg.norm(rests[0][1] - rests[1][1], axis=1)
    return bool(turned.max() < _TURNED and moved.max() < _MOVED * size)


def _relative_rests(bones, names):
    """Rotations (N, 4) and places (N, 3) of bones beside their parents, and the parents' names."""
    place = {bone.name: index for index, bone in enumerate(bones)}
    matrices = read_matrices(bones, "matrix_local")
    parents = [bones[name].parent.name if bones[name].parent else "" for name in names]
    above = np.array([matrices[place[parent]] if parent else np.eye(4) for parent in parents])
    own = matrices[[place[name] for name in names]]
    if not (np.isfinite(own).all() and np.isfinite(above).all()):
        return None
    relative = np.linalg.solve(above, own)
    return quat.from_matrix(relative[:, :3, :3]), relative[:, :3, 3], parents
