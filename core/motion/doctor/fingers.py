"""Fingers: joints whose defects no motion graph minds."""

import numpy as np

from ..joint_roles import JointRole, guess_joint_roles
from ..skeleton import Skeleton


def fingers(skeleton: Skeleton) -> np.ndarray:
    """(J,) bool: joints below the hands, which are the children of the lower arms; none if no arms can be told."""
    forearms = {joints[0] for (role, _), joints in guess_joint_roles(skeleton).items() if role is JointRole.LOWER_ARM}
    below = np.zeros(skeleton.n_joints, dtype=bool)
    for joint in range(1, skeleton.n_joints):
        parent = skeleton.parents[joint]
        below[joint] = below[parent] or skeleton.parents[parent] in forearms
    return below
