"""What a walk shows to be wrong with its character: how it stands, how large it is, what carries it, where it faces."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ... import wording
from .. import quat
from ..body_size import PERSON_HEIGHT, PERSON_LEGS, UNIT_NAMES, unit_of_person
from ..clip import MotionClip
from ..contacts import FLOOR_PERCENTILE
from ..joint_roles import LEG, SIDES, JointRole
from ..kinematics import ancestors
from ..limb_shapes import toes_direction
from .finding import Finding, FindingKind, Remedy, RemedyKind

_PERSON = (0.7, 2.6)
"""Metres: anyone taller or smaller is taken for a matter of units."""
_UNITS = (*UNIT_NAMES, *(100 * unit for unit in UNIT_NAMES), 1000.0, 1 / 0.0254, 1 / 0.3048, 1 / 2.54)
"""Factors between units in use: metres of each, also of files read as centimetres, and what is read as too large."""
_UPRIGHT = 0.5
"""Cosine to the vertical down to which a body stands."""
_AHEAD = 0.7
"""Cosine of heading and way of a walk, from which on it goes where it faces."""
_CLIMBS = 2.0
"""How many times as far as over the ground, and as its legs are long, nobody goes up."""
_BELOW, _ABOVE = 0.1, 0.4
"""Metres, for a person, that feet may stand below and above the floor."""
_FOLDED = 0.5
"""Share of the height in the motion below which a rest pose is folded."""

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class _Body:
    """The places of a clip's body in the world: (F, 3) each, and at rest (3,); lengths in metres."""

    clip: MotionClip
    legs: tuple[tuple[int, ...], ...]
    top: int

    def hips(self) -> np.ndarray:
        return self.clip.world[1][:, [leg[0] for leg in self.legs]].mean(axis=1)

    def spine(self, positions: np.ndarray) -> np.ndarray:
        """(..., 3) from between the ankles to the head, or to the highest joint that is known."""
        feet = np.mean([positions[..., leg[2], :] for leg in self.legs], axis=0)
        return positions[..., self.top, :] - feet

    def leg_length(self) -> float:
        positions, leg = self.clip.world[1], self.legs[0]
        bones = (positions[:, a] - positions[:, b] for a, b in ((leg[0], leg[1]), (leg[1], leg[2])))
        return float(np.median(sum(np.linalg.norm(bone, axis=1) for bone in bones)))


def posture_findings(clip: MotionClip) -> Iterator[Finding]:
    """Yield what the motion shows to be wrong with the character; nothing about skeletons without known legs.

    Each remedy is one of the character, not of the clip.
    """
    body = _find_body(clip)
    if body is None or body.leg_length() < 1e-6:
        return
    found = _lying(body) or _size(body)
    if found is not None:
        yield found  # what follows from it is no finding of its own
        return
    for look in (_root_stays, _facing, _floor, _rest_pose):
        if (found := look(body)) is not None:
            yield found


def _find_body(clip: MotionClip) -> _Body | None:
    roles = clip.skeleton.roles
    if not all((role, side) in roles for role in LEG for side in SIDES):
        return None
    legs = tuple(
        tuple(roles[role, side][0] for role in (*LEG, JointRole.TOES) if (role, side) in roles) for side in SIDES
    )
    top = roles.get((JointRole.HEAD, "")) or roles.get((JointRole.UPPER_ARM, "left")) or (legs[0][0],)
    return _Body(clip, legs, top[0])


def _lying(body: _Body) -> Finding | None:
    spine, hips = body.spine(body.clip.world[1]), body.hips()
    along = np.median(spine / np.maximum(np.linalg.norm(spine, axis=1, keepdims=True), 1e-9), axis=0)
    way = np.ptp(hips, axis=0)
    if way[2] > _CLIMBS * max(*way[:2], body.leg_length()):
        return _climbing(body)
    # Who crawls goes where the head is, who lies stays: a walk goes across its own body, whatever way is up.
    walks = np.linalg.norm(way) > body.leg_length() and np.abs(along) @ way < 0.5 * np.linalg.norm(way)
    if along[2] > _UPRIGHT or not walks:
        return None
    axis = np.zeros(3)
    axis[np.argmax(np.abs(along))] = np.sign(along[np.argmax(np.abs(along))])
    turn = quat.about("x", np.pi) if axis[2] < 0 else quat.between(axis, _UP)
    how = "upside down" if axis[2] < 0 else "lying"
    sentence = (
        f"Clip '{body.clip.name}' walks {how}: its head is not above its feet; another axis points up in its source. "
        "Turn the character upright."
    )
    return _of_the_character(body.clip, FindingKind.LYING, sentence, Remedy(RemedyKind.STAND, values=_plain(turn)))


def _climbing(body: _Body) -> Finding:
    """Tell of a body that goes straight up, which nobody does; its own vertical is that of its legs."""
    feet = np.mean([body.clip.world[1][:, leg[2]] for leg in body.legs], axis=0)
    hang = np.median(body.hips() - feet, axis=0)
    place, axis = np.argmax(np.abs(hang[:2])), np.zeros(3)
    axis[place] = np.sign(hang[place])
    sentence = (
        f"Clip '{body.clip.name}' goes straight up into the air; another axis points up in its source. Turn the "
        "character upright."
    )
    return _of_the_character(
        body.clip, FindingKind.LYING, sentence, Remedy(RemedyKind.STAND, values=_plain(quat.between(axis, _UP)))
    )


def _size(body: _Body) -> Finding | None:
    height = PERSON_HEIGHT / PERSON_LEGS * body.leg_length()
    if _PERSON[0] <= height <= _PERSON[1]:
        return None
    factor = unit_of_person(height, body.clip.skeleton.names, _UNITS) or PERSON_HEIGHT / height
    sentence = (
        f"The character of clip '{body.clip.name}' is about {wording.small(height)} tall; if it is a person, its "
        f"lengths are in another unit: scale it by {wording.exact(float(f'{factor:.3g}'))}."
    )
    return _of_the_character(body.clip, FindingKind.SIZE, sentence, Remedy(RemedyKind.SCALE, values=(factor,)))


def _root_stays(body: _Body) -> Finding | None:
    clip, skeleton = body.clip, body.clip.skeleton
    way = np.ptp(body.hips()[:, :2], axis=0).max()
    if way < body.leg_length() or np.ptp(clip.translations[:, 0, :2], axis=0).max() > 0.3 * way:
        return None
    shared = set.intersection(*(set(ancestors(skeleton.parents, leg[0])) for leg in body.legs)) - {0}
    travels = np.ptp(clip.world[1][..., :2], axis=0).max(axis=1) > 0.7 * way
    carrying = [joint for joint in sorted(shared, reverse=True) if travels[joint]]
    # Legs that hang from different bones have none in common: then a bone of the trunk will do.
    carrying += [
        j for role in (JointRole.SPINE, JointRole.HEAD) for j in skeleton.roles.get((role, ""), ()) if travels[j]
    ]
    if not carrying:
        return None
    bone = skeleton.names[carrying[0]]
    sentence = (
        f"Clip '{clip.name}' travels while bone '{skeleton.names[0]}', which is taken for its root, stays; choose "
        f"'{bone}' as the root."
    )
    remedy = Remedy(RemedyKind.ROOT, bone=bone)
    return _of_the_character(clip, FindingKind.ROOT_STAYS, sentence, remedy, skeleton.names[:1])


def _facing(body: _Body) -> Finding | None:
    clip, skeleton = body.clip, body.clip.skeleton
    positions, hips = clip.world[1], body.hips()[:, :2]
    steps = np.diff(hips, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    moves = lengths > 0.2 * np.quantile(lengths, 0.9)  # where it stands, it goes nowhere
    if lengths.sum() < body.leg_length() or not moves.any():
        return None
    forward = quat.rotate(clip.rotations[:, 0], skeleton.forward)[:, :2]
    heading = forward / np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    way = steps / np.maximum(lengths, 1e-12)[:, None]
    ahead = float(np.sum(lengths * np.sum(way * heading[:-1], axis=1)) / lengths.sum())
    if ahead >= _AHEAD:
        return None
    feet = toes_direction(positions, body.legs)
    left, right = (leg[0] for leg in body.legs)
    if feet is not None:
        front = feet[:-1, :2]
    elif skeleton.partners[left] == right:
        front = np.cross(positions[:, left] - positions[:, right], _UP)[:-1, :2]
    else:
        front = way
    front = front / np.maximum(np.linalg.norm(front, axis=1, keepdims=True), 1e-9)
    # Sideways and backwards by nature: it faces where its body does, and goes elsewhere.
    if np.mean(np.sum(front * heading[:-1], axis=1)[moves]) >= _AHEAD:
        return None
    seen = quat.rotate(quat.inverse(clip.rotations[:-1, 0]), np.column_stack([front, 0 * front[:, 0]]))[moves].mean(
        axis=0
    )
    direction = quat.rotate(skeleton.rest_rotations[0], seen)
    direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
    sentence = (
        f"Clip '{clip.name}' goes at {wording.angle(float(np.arccos(np.clip(ahead, -1, 1))))} to where it faces, and "
        "its body does not face there either; let it face the way that its body does."
    )
    return _of_the_character(
        clip, FindingKind.FACING, sentence, Remedy(RemedyKind.FACE, values=_plain(direction)), skeleton.names[:1]
    )


def _floor(body: _Body) -> Finding | None:
    clip = body.clip
    joints = [joint for leg in body.legs for joint in leg[2:]]
    lowest = float(np.percentile(clip.world[1][:, joints, 2].min(axis=1), FLOOR_PERCENTILE))
    size = body.leg_length() / PERSON_LEGS
    if -_BELOW * size <= lowest <= _ABOVE * size:
        return None
    names = tuple(clip.skeleton.names[joint] for joint in joints)
    where = "below" if lowest < 0 else "above"
    sentence = (
        f"The feet of clip '{clip.name}' stand {wording.small(abs(lowest))} {where} the floor at height 0; move the "
        f"character {'up' if lowest < 0 else 'down'}."
    )
    return _of_the_character(clip, FindingKind.FLOOR, sentence, Remedy(RemedyKind.LIFT, values=(-lowest,)), names)


def _rest_pose(body: _Body) -> Finding | None:
    clip = body.clip
    rest, spine = body.spine(clip.skeleton.rest_world[1]), body.spine(clip.world[1])
    height = float(np.median(np.linalg.norm(spine, axis=1)))
    length = float(np.linalg.norm(rest))
    if length < _FOLDED * height:
        what = "is folded: its head is near its feet"
    elif rest[2] < _UPRIGHT * length and np.median(spine[:, 2]) > _UPRIGHT * height:
        what = "lies, while the motion stands"
    else:
        return None
    sentence = (
        f"The rest pose under clip '{clip.name}' {what}, so that sizes and mirrored clips are wrong; import the file "
        "again, or make a standing pose the rest pose."
    )
    return _of_the_character(clip, FindingKind.ODD_REST, sentence, Remedy(RemedyKind.BY_HAND))


def _of_the_character(
    clip: MotionClip, kind: FindingKind, sentence: str, remedy: Remedy, joints: tuple[str, ...] = ()
) -> Finding:
    return Finding(clip.name, kind, (0, clip.n_frames - 1), joints, sentence, remedy)


def _plain(values: np.ndarray) -> tuple[float, ...]:
    return tuple(float(value) for value in np.ravel(values))
