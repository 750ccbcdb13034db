"""How large a character is beside a person: what is stated in metres for a person grows with it."""

import numpy as np

from .joint_roles import JointRole, guess_joint_roles
from .skeleton import Skeleton
from .stature import rest_world, stature

#: Thigh and shin of a person of 1.75 m, in metres.
_LEGS = 0.845

#: Stature beside legs, for skeletons whose names do not tell the legs.
_STATURE_TO_LEGS = 1.55 / _LEGS

#: Anyone between these is a person, and compared with others in plain metres.
_PERSONS = (0.8, 1.25)


def relative_size(skeleton: Skeleton) -> float:
    """Size beside a person's: 1 for everyone of human size, 10 for a giant of 17 m.

    By the length of the legs in the rest pose, because stature depends on hats and weapons.
    """
    roles, positions = guess_joint_roles(skeleton), rest_world(skeleton)[1]
    leg = [roles.get((role, "left"), ()) for role in (JointRole.THIGH, JointRole.SHIN, JointRole.FOOT)]
    if all(leg):
        hip, knee, ankle = (positions[joints[0]] for joints in leg)
        legs = float(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee))
    else:
        legs = stature(skeleton) / _STATURE_TO_LEGS
    size = legs / _LEGS
    # A rest pose shrunk to a point tells no size.
    return 1.0 if _PERSONS[0] <= size <= _PERSONS[1] or size < 1e-3 else size
