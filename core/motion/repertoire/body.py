"""The whole body over a footstep plan: hips, legs, spine, arms and head of a walking or standing person.

The footsteps lead. The hips follow them on the ground, as high as both legs reach; all else that swings in a
walk is driven by two signals that are read off the same plan: how far the left foot leads, and which foot
bears the weight.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from .. import quat
from ..kinematics import local_transforms
from ..limb import limb_frames
from .character import REST_HEADING, SIDES, Character
from .feet import FootMotion, foot_motion
from .footsteps import FootstepPlan

GRAVITY = 9.81
# Legs are never straighter than this part of their length: the knee keeps 10 degrees.
_REACH = 0.996
# Before it is sampled, the plan is evaluated at no less than this rate (1/s),
# and beyond both ends for so long (s).
_FINE_RATE, _MARGIN = 240.0, 0.8


@dataclass(frozen=True)
class Style:
    """Traits by which this walker differs from the model: factors about 1.

    ``drift`` scales the slow wandering of a body that is never quite still.
    """

    arms: float = 1.0
    elbows: float = 1.0
    twist: float = 1.0
    sway: float = 1.0
    tilt: float = 1.0
    lean: float = 1.0
    drift: float = 1.0

    @classmethod
    def varied(cls, rng: np.random.Generator, spread: float = 0.03) -> "Style":
        """Draw a style whose factors scatter about 1 by ``spread`` (standard deviation, cut at twice that)."""
        return cls(*(1 + spread * np.clip(rng.standard_normal(7), -2, 2)))


@dataclass(frozen=True)
class _Course:
    """The body's way over the ground on a fine grid of times: everything that the joints are derived from."""

    times: np.ndarray
    path: np.ndarray  # (T, 3) x, y, heading
    lead: np.ndarray  # metres that the left foot is ahead
    lead_late: np.ndarray  # the same a moment ago; arms follow
    weight: np.ndarray  # 1: on the left foot, -1: on the right
    aside: np.ndarray  # where that foot is, metres to the left of the path
    speed: np.ndarray
    gain: np.ndarray  # acceleration along the path
    inward: np.ndarray  # centripetal acceleration, to the left

    def at(self, pick: slice) -> "_Course":
        return _Course(*(getattr(self, name)[pick] for name in self.__dataclass_fields__))


def _course(plan: FootstepPlan, times: np.ndarray) -> _Course:
    step = times[1] - times[0]

    def smooth(values: np.ndarray, seconds: float) -> np.ndarray:
        return gaussian_filter1d(values, seconds / step, axis=0, mode="nearest")

    def through(knots: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
        if len(knots) == 1:
            return np.repeat(values, len(at), axis=0)
        return PchipInterpolator(knots, values)(np.clip(at, knots[0], knots[-1]))

    knots, stations, leads = plan.body_knots(settle=0.25)
    path = smooth(through(knots, stations, times), 0.07)
    weight_times, weights = plan.weight_knots(settle=0.35)
    weight = smooth(through(weight_times, weights, times), 0.05)
    velocity = np.gradient(path, step, axis=0)
    speed = smooth(np.hypot(velocity[:, 0], velocity[:, 1]), 0.08)
    return _Course(
        times=times,
        path=path,
        lead=smooth(through(knots, leads, times), 0.05),
        lead_late=smooth(through(knots, leads, times - 0.04), 0.06),
        weight=weight[:, 0],
        aside=weight[:, 1],
        speed=speed,
        gain=smooth(np.gradient(speed, step), 0.12),
        inward=smooth(speed * velocity[:, 2], 0.12),
    )


def _drift(rng: np.random.Generator, times: np.ndarray, channels: int) -> np.ndarray:
    """(channels, T) slow wandering of about unit size."""
    rates = rng.uniform(0.12, 0.5, (channels, 3, 1))
    phases = rng.uniform(0, 2 * np.pi, (channels, 3, 1))
    return np.sin(2 * np.pi * rates * times + phases).sum(axis=1) / np.sqrt(1.5)


def _turned(yaw, pitch, roll) -> np.ndarray:
    """Turns about a trunk bone's own axes: up (to the left), left (bend forward), forward (left side up)."""
    return quat.from_euler("YXZ", np.column_stack([yaw, pitch, roll]))


def _headed(heading) -> np.ndarray:
    """The turn about Z that makes the resting character face ``heading``."""
    return quat.about("z", np.subtract(heading, REST_HEADING))


def _hip_turn(course: _Course, style: Style) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Yaw, pitch, roll of the hips against the path: the leading side forward, the swinging side low."""
    yaw = -0.13 * style.twist * course.lead
    pitch = style.lean * np.radians(2.0 + 1.5 * course.speed)
    roll = style.tilt * np.radians(3.0) * course.weight - 0.3 * np.arctan(course.inward / GRAVITY)
    return yaw, pitch, roll


def _hip_height(
    character: Character, course: _Course, hips: np.ndarray, feet: dict[str, FootMotion], ground: np.ndarray
) -> np.ndarray:
    """(T,) height of the root: as high as both legs reach, smoothed from below."""
    step = course.times[1] - course.times[0]
    highest = np.full(len(course.times), np.inf)
    for side, foot in feet.items():
        reach = _REACH * (character.length_of(side + "UpLeg") + character.length_of(side + "Leg"))
        offset = quat.rotate(hips, character.offset_of(side + "UpLeg"))
        away = foot.ankle[:, :2] - ground - offset[:, :2]
        rise = np.sqrt(np.maximum(reach**2 - np.sum(away**2, axis=1), 0.0))
        highest = np.minimum(highest, foot.ankle[:, 2] + rise - offset[:, 2])
    # The lowest value within the filter's reach: smoothing it cannot ask more of a leg than it has.
    radius = round(0.08 / step)
    lowest = minimum_filter1d(highest, 2 * radius + 1, mode="nearest")
    smooth = gaussian_filter1d(lowest, radius / 2.2, radius=radius, mode="nearest")
    # Both knees give when the weight passes from one leg to the other.
    return smooth - 0.014 * course.lead**2


def move_body(
    character: Character,
    plan: FootstepPlan,
    start: float,
    end: float,
    frame_rate: float,
    style: Style,
    rng: np.random.Generator,
    watch: float | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Move the sample character as planned, from ``start`` to ``end`` s.

    It starts above the world's origin, facing -Y. ``watch``, if given, is the time (s) around which the head
    looks down at the feet.

    Returns
    -------
    times : (F,) float array
        The plan's time of each frame, in seconds.
    rotations : (F, J, 4) float array
    translations : (F, J, 3) float array
        As a :class:`core.motion.clip.MotionClip` has them.
    """
    n_frames = int(np.floor((end - start) * frame_rate + 1e-6)) + 1
    fine = int(np.ceil(_FINE_RATE / frame_rate))
    margin = int(np.ceil(_MARGIN * frame_rate)) * fine
    times = start + (np.arange((n_frames - 1) * fine + 2 * margin + 1) - margin) / (frame_rate * fine)
    frames = slice(margin, len(times) - margin, fine)

    course = _course(plan, times)
    feet = {side: foot_motion(plan, sign, times) for side, sign in SIDES.items()}
    heading = course.path[:, 2]
    forward = np.column_stack([np.cos(heading), np.sin(heading)])
    left = np.column_stack([-np.sin(heading), np.cos(heading)])
    sway = 0.4 * style.sway * course.aside + 0.35 * course.inward / GRAVITY
    # The faster the walk, the further the hips are ahead of the middle between the feet.
    ground = course.path[:, :2] + sway[:, None] * left + (0.03 * course.speed)[:, None] * forward
    hips = quat.multiply(_headed(heading), character.rest_of("Hips"), _turned(*_hip_turn(course, style)))
    height = _hip_height(character, course, hips, feet, ground)

    # The head turns where the path will be.
    ahead = np.interp(times + 0.35, times, gaussian_filter1d(heading, 0.12 * frame_rate * fine, mode="nearest"))
    course, hips = course.at(frames), hips[frames]
    feet = {
        side: FootMotion(foot.ankle[frames], foot.heading[frames], foot.pitch[frames], foot.toe_bend[frames])
        for side, foot in feet.items()
    }
    root = np.column_stack([ground, height])[frames]
    drift = style.drift * _drift(rng, course.times, 16)
    world: dict[str, np.ndarray] = {"Hips": hips}
    _pose_trunk(character, world, course, ahead[frames], style, drift[:8], watch)
    for side, sign in SIDES.items():
        _pose_arm(character, world, side, sign, course, style, drift[8:12] if sign > 0 else drift[12:])
        _pose_leg(character, world, side, root, feet[side])
    skeleton = character.skeleton
    oriented = np.stack([world[name] for name in skeleton.names], axis=1)
    rotations, _ = local_transforms(oriented, np.zeros((n_frames, skeleton.n_joints, 3)), skeleton.parents)
    translations = np.repeat(skeleton.rest_translations[None], n_frames, axis=0)
    translations[:, 0] = root

    # Put the start of the path at the origin, whatever the body's sway and twist there.
    x, y, facing = course.path[0]
    turn = quat.inverse(_headed(facing))
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    translations[:, 0] = quat.rotate(turn, translations[:, 0] - [x, y, 0])
    return course.times, quat.continuous(rotations), translations


def _pose_trunk(
    character: Character,
    world: dict[str, np.ndarray],
    course: _Course,
    ahead: np.ndarray,
    style: Style,
    drift: np.ndarray,
    watch: float | None,
) -> None:
    """Spine, neck and head: the shoulders turn against the hips, the head stays level and looks ahead."""
    hip_yaw, hip_pitch, hip_roll = _hip_turn(course, style)
    small = np.radians(0.5)
    yaw = 0.11 * style.twist * course.lead - hip_yaw + small * drift[0]
    pitch = style.lean * np.radians(1.0 + 2.2 * course.speed + 2.5 * course.gain) - hip_pitch + small * drift[1]
    roll = -1.2 * hip_roll - 0.7 * np.arctan(course.inward / GRAVITY) + small * drift[2]
    parent = "Hips"
    for name in ("Spine", "Spine1", "Spine2"):
        straight = quat.multiply(quat.inverse(character.rest_of(parent)), character.rest_of(name))
        world[name] = quat.multiply(world[parent], straight, _turned(yaw / 3, pitch / 3, roll / 3))
        parent = name
    down = 0.0 if watch is None else np.radians(16) * np.exp(-(((course.times - watch) / 0.45) ** 2))
    nod = quat.from_euler("zx", np.column_stack([2 * small * drift[3], np.radians(2) + down + small * drift[4]]))
    level = quat.multiply(_headed(ahead), nod)
    chest = quat.multiply(world["Spine2"], quat.inverse(character.rest_of("Spine2")))
    world["Neck"] = quat.multiply(_half_way(chest, level), character.rest_of("Neck"))
    world["Head"] = quat.multiply(level, character.rest_of("Head"))


def _pose_arm(
    character: Character,
    world: dict[str, np.ndarray],
    side: str,
    sign: int,
    course: _Course,
    style: Style,
    drift: np.ndarray,
) -> None:
    """One arm: hangs from the shoulder, swings against the leg of its side, elbow bent, more so in front."""
    chest = quat.multiply(world["Spine2"], quat.inverse(character.rest_of("Spine2")))
    swing = -sign * style.arms * course.lead_late * (0.38 + 0.14 * course.speed)
    shoulder = quat.about("z", -sign * 0.12 * swing)
    world[side + "Shoulder"] = quat.multiply(chest, shoulder, character.rest_of(side + "Shoulder"))
    # Gravity, not the chest, says which way is down; only half of the chest's lean reaches the arm.
    hanging = _half_way(quat.about("z", quat.to_euler("ZXY", chest)[:, 0]), chest)
    # Bone axes of an arm that hangs straight down: X to the right, Y down, Z forward, for both sides.
    down = quat.from_matrix(np.column_stack([(-1, 0, 0), (0, 0, -1), (0, -1, 0)]))
    wander = np.radians(1.0)
    out = sign * (np.radians(8.0) + 0.2 * swing + wander * 0.5 * drift[0])
    arm = quat.about("x", swing + np.radians(-2) + wander * drift[1])
    # Turned in a little, so that the forearm swings across rather than straight ahead.
    across = quat.about("y", sign * 0.08)
    world[side + "Arm"] = quat.multiply(hanging, down, quat.about("z", out), arm, across)
    elbow = style.elbows * (np.radians(14.0 + 7.0 * course.speed) + 0.35 * swing + 0.15 * np.abs(swing))
    forearm = quat.multiply(world[side + "Arm"], quat.about("x", elbow + wander * drift[2]))
    world[side + "ForeArm"] = forearm
    world[side + "Hand"] = quat.multiply(forearm, quat.about("x", np.radians(8) + wander * drift[3]))


def _half_way(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The rotations (F, 4) in the middle between two."""
    return quat.slerp(start, end, np.array([0.5]))


def _pose_leg(
    character: Character, world: dict[str, np.ndarray], side: str, root: np.ndarray, foot: FootMotion
) -> None:
    """One leg: the foot where the plan has it, the knee pointing between the hips' and the foot's heading."""
    thigh, shin = side + "UpLeg", side + "Leg"
    hip = root + quat.rotate(world["Hips"], character.offset_of(thigh))
    hips_right = quat.rotate(world["Hips"], [-1, 0, 0])
    foot_right = np.column_stack([np.sin(foot.heading), -np.cos(foot.heading), np.zeros(len(root))])
    lengths = character.length_of(thigh), character.length_of(shin)
    world[thigh], world[shin] = limb_frames(hip, foot.ankle, hips_right + foot_right, *lengths)
    level = _headed(foot.heading)
    for bone, pitch in (("Foot", foot.pitch), ("ToeBase", foot.pitch + foot.toe_bend)):
        world[side + bone] = quat.multiply(level, quat.about("x", -pitch), character.rest_of(side + bone))
