"""Size of a character beside a person: what is stated in metres for a person grows with it."""

from collections.abc import Iterable, Sequence

import numpy as np

from .bone_names import are_japanese
from .joint_roles import LEG, JointRole
from .skeleton import Skeleton

#: Metres that a person is tall, and those of its thigh and shin.
PERSON_HEIGHT, PERSON_LEGS = 1.75, 0.845

#: Metres between which a person usually is tall.
USUAL_PERSONS = (1.4, 2.1)

#: Metres per unit in the files of the CMU motion capture database (inches / 0.45), and of MikuMikuDance.
CMU_UNIT, MMD_UNIT = 0.056444, 0.08

#: The units of length in use, by their metres.
UNIT_NAMES = {
    1.0: "metres",
    0.1: "decimetres",
    0.01: "centimetres",
    0.001: "millimetres",
    0.0254: "inches",
    0.3048: "feet",
    CMU_UNIT: "units of the CMU database",
    MMD_UNIT: "units of MikuMikuDance",
}

#: Stature beside legs, for skeletons whose names do not say where the legs are.
_STATURE_TO_LEGS = 1.55 / PERSON_LEGS

#: Anyone between these is a person, and compared with others in plain metres.
_PERSONS = (0.8, 1.25)


#: What flesh adds to the shoulders' joints on each side, and half the width of a body without arms: shares of the legs
#: and of the height of a person who needs 0.25 m.
_FLESH, _HALF_WIDTH = 0.09, 0.145


def body_radius(skeleton: Skeleton) -> float:
    """Return the metres that a walking character needs to each side: half the width of its shoulders, and flesh.

    Arms that swing out farther are left out, as by someone who passes through a door. A share of the height of a
    skeleton without recognizable arms or legs.
    """
    roles, positions = skeleton.roles, skeleton.rest_world[1]
    arms = [roles.get((JointRole.UPPER_ARM, side), ()) for side in ("left", "right")]
    if not all(arms) or not all(roles.get((role, "left"), ()) for role in (JointRole.THIGH, JointRole.SHIN)):
        return _HALF_WIDTH * skeleton.stature
    left, right = (positions[joints[0]] for joints in arms)
    return 0.5 * float(np.linalg.norm(left - right)) + _FLESH * PERSON_LEGS * relative_size(skeleton)


def person_height(skeleton: Skeleton) -> float:
    """Return the metres that a person with these legs is tall; the stature of a skeleton without recognizable legs."""
    length = _leg_length(skeleton)
    return skeleton.stature if length is None else PERSON_HEIGHT / PERSON_LEGS * length


def unit_of_person(height: float, bones: Sequence[str], units: Iterable[float] = UNIT_NAMES) -> float | None:
    """Return the unit that makes a person of a height: of those that do, the one that comes next to the usual height.

    MikuMikuDance's, which make small persons of what others make tall ones, are for Japanese names of bones, or where
    nothing else fits.

    Parameters
    ----------
    height : float
        In the unit that is sought.
    bones : sequence of str
    units : iterable of float
        Metres per unit.

    >>> unit_of_person(19.5, ["Hips"]), unit_of_person(19.5, ["センター"]), unit_of_person(300.0, ["Hips"])
    (0.1, 0.08, None)
    """
    fitting = [unit for unit in units if USUAL_PERSONS[0] <= unit * height <= USUAL_PERSONS[1]]
    of_mmd = [unit for unit in fitting if unit in (MMD_UNIT, 100 * MMD_UNIT)]
    others = [unit for unit in fitting if unit not in of_mmd]
    chosen = of_mmd or others if are_japanese(bones) else others or of_mmd
    return min(chosen, key=lambda unit: abs(np.log(unit * height / PERSON_HEIGHT)), default=None)


def relative_size(skeleton: Skeleton) -> float:
    """Return the size beside a person's: 1 for everyone of human size, 10 for a giant of 17 m.

    By the length of the legs in the rest pose, because stature depends on hats and weapons.
    """
    length = _leg_length(skeleton)
    legs = skeleton.stature / _STATURE_TO_LEGS if length is None else length
    size = legs / PERSON_LEGS
    # A rest pose shrunk to a point has no size.
    return 1.0 if _PERSONS[0] <= size <= _PERSONS[1] or size < 1e-3 else size


def _leg_length(skeleton: Skeleton) -> float | None:
    """Metres of the left thigh and shin at rest; None if nothing says which they are."""
    leg = [skeleton.roles.get((role, "left"), ()) for role in LEG]
    if not all(leg):
        return None
    hip, knee, ankle = (skeleton.rest_world[1][joints[0]] for joints in leg)
    return float(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee))
