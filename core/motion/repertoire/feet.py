"""The motion of a foot between and during its footsteps: land on the heel, lie flat, roll off the toes, swing."""

from dataclasses import dataclass

import numpy as np

from .character import ANKLE_HEIGHT, HEEL, STATION_OFFSET, TOE_JOINT
from .footsteps import Footstep, FootstepPlan

TOE_OUT = np.radians(6.0)
STRIDE = 1.3
"""Metres that a foot swings in a walk at 1.2 m/s; the foot's pitch at landing and lift-off scales with it."""

# In full stride: toes up at landing, heel up at lift-off (rad), and seconds from landing to foot flat.
STRIKE_PITCH, LIFT_PITCH, FLATTEN = np.radians(22.0), np.radians(58.0), 0.11
# The part of the time from foot flat to lift-off after which the heel starts to rise.
HEEL_OFF = 0.5


@dataclass(frozen=True)
class FootMotion:
    """One foot over time.

    Attributes
    ----------
    ankle : (T, 3) float array
        Metres, in the world of the footstep plan.
    heading, pitch, toe_bend : (T,) float array
        Radians; pitch is positive with the toes up, and so is the toes' bend against the foot.
    """

    ankle: np.ndarray
    heading: np.ndarray
    pitch: np.ndarray
    toe_bend: np.ndarray


def _roll(pivot: np.ndarray, pitch: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity (..., 2: forward, up) of the ankle of a foot that turns about ``pivot``."""
    arm = -pivot
    sine, cosine = np.sin(pitch), np.cos(pitch)
    turned = np.stack([arm[0] * cosine - arm[1] * sine, arm[0] * sine + arm[1] * cosine], axis=-1)
    velocity = np.stack([-turned[..., 1], turned[..., 0]], axis=-1) * np.asarray(rate)[..., None]
    return turned - arm, velocity


def _hermite(u, start, end, duration):
    """Quintic from (value, velocity, acceleration) ``start`` to ``end``, at u in 0..1 of ``duration`` s."""
    p0, v0, a0 = start[0], start[1] * duration, start[2] * duration**2
    p1, v1, a1 = end[0], end[1] * duration, end[2] * duration**2
    c3 = 10 * (p1 - p0) - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15 * (p1 - p0) + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    c5 = 6 * (p1 - p0) - 3 * (v0 + v1) - 0.5 * a0 + 0.5 * a1
    return p0 + u * (v0 + u * (a0 / 2 + u * (c3 + u * (c4 + u * c5))))


def _ease(u):
    """0 to 1 with no velocity and no acceleration at either end."""
    u = np.clip(u, 0, 1)
    return u**3 * (10 + u * (6 * u - 15))


@dataclass(frozen=True)
class _Print:
    """A footprint with its own roll: ankle (2,) m when flat, heading, pitch at landing and at lift-off."""

    step: Footstep
    ankle: np.ndarray
    heading: float
    land: float
    lift: float
    strike: float
    push: float

    @property
    def forward(self) -> np.ndarray:
        return np.array([np.cos(self.heading), np.sin(self.heading)])

    def stance(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Ankle (T, 3), its velocity, pitch and pitch rate while the foot is down."""
        flat = self.land + FLATTEN
        landing = np.clip((flat - t) / FLATTEN, 0, 1)
        pitch = self.strike * landing**2
        rate = -2 * self.strike / FLATTEN * landing
        moved, velocity = _roll(HEEL, pitch, rate)
        if np.isfinite(self.lift):
            heel_off = flat + HEEL_OFF * (self.lift - flat)
            # A long stand must not roll off slowly.
            heel_off = max(heel_off, self.lift - 0.42)
            leaving = np.clip((t - heel_off) / (self.lift - heel_off), 0, 1)
            push_rate = -2 * self.push / (self.lift - heel_off) * leaving
            push_moved, push_velocity = _roll(TOE_JOINT, -self.push * leaving**2, push_rate)
            # The two rolls never overlap: one of them is always flat.
            pitch, rate = pitch - self.push * leaving**2, rate + push_rate
            moved, velocity = moved + push_moved, velocity + push_velocity
        ankle = np.column_stack([self.ankle + moved[:, :1] * self.forward, ANKLE_HEIGHT + moved[:, 1]])
        return ankle, np.column_stack([velocity[:, :1] * self.forward, velocity[:, 1]]), pitch, rate


def _prints(plan: FootstepPlan, side: int) -> list[_Print]:
    indices = [k for k, step in enumerate(plan.steps) if step.side == side]
    places = []
    for k in indices:
        x, y, heading = plan.steps[k].station
        lateral = side * plan.steps[k].half_width
        left, forward = (
            np.array([-np.sin(heading), np.cos(heading)]),
            np.array([np.cos(heading), np.sin(heading)]),
        )
        places.append(np.array([x, y]) + lateral * left - STATION_OFFSET * forward)
    # How far the foot swings forward, before and after each footprint, in strides: a foot that turns on the
    # spot neither lands on its heel nor pushes off like a walker's.
    swings = []
    for a, b, k in zip(places[:-1], places[1:], indices[1:], strict=True):
        heading = plan.steps[k].station[2]
        swings.append(np.clip(np.array([np.cos(heading), np.sin(heading)]) @ (b - a) / STRIDE, 0, 1.15))
    before, after = [swings[0] if swings else 0.0, *swings], [*swings, 0.0]
    prints = []
    for i, (k, place) in enumerate(zip(indices, places, strict=True)):
        step = plan.steps[k]
        strike = STRIKE_PITCH * before[i] if step.land > 0 else 0.0
        push = LIFT_PITCH * (0.3 + 0.7 * after[i])
        heading = step.station[2] - side * TOE_OUT
        prints.append(_Print(step, place, heading, step.land, plan.lift(k), strike, push))
    return prints


def foot_motion(plan: FootstepPlan, side: int, times: np.ndarray) -> FootMotion:
    """Move the foot ``side`` (1 left, -1 right) at ``times`` (T,) s, as the plan has it."""
    prints = _prints(plan, side)
    ankle, pitch = np.zeros((len(times), 3)), np.zeros(len(times))
    heading, toe_bend = np.zeros(len(times)), np.zeros(len(times))
    for i, here in enumerate(prints):
        down = (times >= here.land if i else times >= -np.inf) & (times <= here.lift)
        ankle[down], _, pitch[down], _ = here.stance(times[down])
        heading[down] = here.heading
        # The toes stay flat on the floor while the heel is up.
        toe_bend[down] = np.maximum(-pitch[down], 0)
        if i + 1 == len(prints):
            break
        there = prints[i + 1]
        swinging = (times > here.lift) & (times < there.land)
        if swinging.any():
            swing = _swing(here, there, times[swinging])
            ankle[swinging], heading[swinging], pitch[swinging], toe_bend[swinging] = swing
    return FootMotion(ankle, heading, pitch, toe_bend)


def _swing(here: _Print, there: _Print, t: np.ndarray):
    """Ankle, heading, pitch and toe bend between two footprints, continuing both stances' velocities."""
    duration = there.land - here.lift
    u = (t - here.lift) / duration
    p0, v0, pitch0, rate0 = (value[0] for value in here.stance(np.array([here.lift])))
    p1, v1, pitch1, rate1 = (value[0] for value in there.stance(np.array([there.land])))
    # A swing that starts and ends with some acceleration is less hasty half-way than one of minimum jerk.
    pull = 4.0 * (p1 - p0) / duration**2 * [1, 1, 0]
    ankle = _hermite(u[:, None], (p0, v0, pull), (p1, v1, -pull), duration)
    step = there.step
    arch = _ease(u / step.rise) * _ease((1 - u) / step.fall)
    left = np.array([-np.sin(there.heading), np.cos(there.heading), 0])
    # Past the other leg the foot swings a little outwards.
    ankle += (arch * step.height)[:, None] * [0, 0, 1] + (16 * u**2 * (1 - u) ** 2 * 0.02 * step.side)[:, None] * left
    pitch = _hermite(u, (pitch0, rate0, 0.0), (pitch1, rate1, 0.0), duration)
    # The toes straighten in the first part of the swing, once they have left the floor.
    bend0, bend_rate0 = max(-pitch0, 0.0), -rate0
    straighten = np.clip(u / 0.8, 0, 1)
    toe_bend = _hermite(straighten, (bend0, bend_rate0, -24.0 * bend0 / duration), (0.0, 0.0, 0.0), 0.8 * duration)
    heading = here.heading + (there.heading - here.heading) * _ease(u)
    return ankle, heading, pitch, toe_bend
