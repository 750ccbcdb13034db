"""The repertoire: walks, turns, starts, stops and steps of the sample character."""

from collections.abc import Iterable, Iterator

import numpy as np

from ..clip import MotionClip
from .body import Style, move_body
from .character import sample_character
from .footsteps import STAND_WIDTH, WALK_WIDTH, FootstepPlan

STEP_TAG = "step"
"""Tag of the frames in which the character steps over an obstacle."""

STEP_OBSTACLE = (0.25, 0.20)
"""Depth and height in metres of the low obstacle that the tagged clips step over."""

NORMAL = 1.2
"""Speed of the walk that all others begin and end in, in m/s."""

LEFT, RIGHT = 1, -1
_LEAD_IN = 4


def _cadence(speed: float) -> tuple[float, float, float]:
    """Step length (m), time between two landings and double support (s) of a walk at ``speed`` m/s.

    People walk faster with longer and quicker steps at once, and with both feet down for less of the time.
    """
    length = 0.65 * (speed / NORMAL) ** 0.57
    interval = length / speed
    return length, interval, 2 * interval * (0.16 - 0.0375 * speed)


class _Walker:
    """Takes one step after the other, each a little different from what was asked, as people do."""

    def __init__(self, plan: FootstepPlan, rng: np.random.Generator):
        self.plan, self._rng = plan, rng

    @property
    def landed(self) -> float:
        """Time of the last landing in seconds."""
        return self.plan.steps[-1].land

    def walk(self, steps: int, speed: float = NORMAL, turn: float = 0.0) -> "_Walker":
        """Add some steps at ``speed`` m/s, each turning by ``turn`` degrees."""
        for _ in range(steps):
            self.stride(speed, turn)
        return self

    def stride(self, speed: float, turn: float = 0.0, length: float = 1.0, **swing) -> "_Walker":
        """Add one step, ``length`` times as long as usual at ``speed`` m/s."""
        usual, interval, overlap = _cadence(speed)
        vary = np.clip(self._rng.standard_normal(3), -2, 2) * [0.012, 0.012, 1.0]
        # In a turn the feet keep further apart, so that one does not strike the other.
        swing.setdefault("half_width", WALK_WIDTH + 0.025 * min(abs(turn) / 25, 1) + 0.003 * vary[2])
        self.plan = self.plan.step(
            usual * length * (1 + vary[0]), np.radians(turn), interval * (1 + vary[1]), overlap, **swing
        )
        return self

    def place(self, length: float, turn: float, interval: float, overlap: float, **swing) -> "_Walker":
        """Add one step exactly as given; ``turn`` in degrees."""
        self.plan = self.plan.step(length, np.radians(turn), interval, overlap, **swing)
        return self


class _Studio:
    """Records clips of one walker in ever slightly different moods."""

    def __init__(self, frame_rate: float, rng: np.random.Generator):
        self._character = sample_character()
        self._frame_rate, self._source, self._rng = frame_rate, rng, rng

    def walker(self, first: int, speed: float = NORMAL) -> _Walker:
        """Someone who walks steadily already and whose next step will be with the foot ``first``."""
        _, _, overlap = _cadence(speed)
        self._new_mood()
        return _Walker(FootstepPlan.walking(first * (-1) ** _LEAD_IN, overlap), self._rng).walk(_LEAD_IN, speed)

    def stander(self, first: int, seconds: float) -> _Walker:
        """Someone who stands for ``seconds`` and will then step with the foot ``first``."""
        self._new_mood()
        return _Walker(FootstepPlan.standing(first, seconds), self._rng)

    def _new_mood(self) -> None:
        # Each clip has its own stream of numbers, so that one can be changed and all others stay as they are.
        (self._rng,) = self._source.spawn(1)

    def clip(
        self,
        name: str,
        walker: _Walker,
        start: float,
        end: float,
        tagged: tuple[float, float] | None = None,
        watch: float | None = None,
    ) -> MotionClip:
        """The walker's plan between two times (s), ``tagged`` from one to another as stepping over.

        The head looks down around the time ``watch``.
        """
        style = Style.varied(self._rng)
        times, rotations, translations = move_body(
            self._character, walker.plan, start, end, self._frame_rate, style, self._rng, watch
        )
        tags = {} if tagged is None else {STEP_TAG: (times >= tagged[0]) & (times <= tagged[1])}
        return MotionClip(name, self._character.skeleton, self._frame_rate, rotations, translations, tags)

    def walking(self, name: str, first: int, steps: Iterable[tuple[float, float]], phase: float = 0.0) -> MotionClip:
        """A walk of steps (speed m/s, turn in degrees), from the landing before the first to the last's.

        ``phase`` delays both ends by a part of a step.
        """
        steps = list(steps)
        walker = self.walker(first, steps[0][0])
        start = walker.landed + phase * _cadence(steps[0][0])[1]
        for speed, turn in steps:
            walker.stride(speed, turn)
        end = walker.landed + phase * _cadence(steps[-1][0])[1]
        return self.clip(name, walker.walk(3, steps[-1][0]), start, end)

    def starting(self, name: str, first: int, rest: float, speeds: Iterable[float]) -> MotionClip:
        """Standing for ``rest`` s, then steps at these speeds."""
        walker = self.stander(first, rest)
        for i, speed in enumerate(speeds):
            walker.stride(speed, length=0.85 if i == 0 else 1.0)
        end = walker.landed
        return self.clip(name, walker.walk(3), 0.0, end)

    def stopping(self, name: str, first: int, speeds: Iterable[float], rest: float) -> MotionClip:
        """Steps at these speeds; then the other foot comes beside the last one."""
        walker = self.walker(first)
        start = walker.landed
        *speeds, last = speeds
        for speed in speeds:
            walker.stride(speed)
        walker.stride(last, length=0.85, half_width=0.07)
        _, interval, _ = _cadence(last)
        walker.place(0.0, 0.0, interval * 1.1, np.inf, half_width=STAND_WIDTH)
        return self.clip(name, walker, start, walker.landed + rest)

    def pivoting(self, name: str, turns: Iterable[float], tempo: float, rests: tuple[float, float]) -> MotionClip:
        """Turns on the spot, a step for each of ``turns`` (degrees), beginning with the foot on the inside.

        Feet turn out more easily than in: steps of the inside foot should be the larger ones. One more
        step closes.
        """
        turns = list(turns)
        walker = self.stander(LEFT if turns[0] > 0 else RIGHT, rests[0])
        for i, turn in enumerate(turns):
            interval = tempo * (0.75 if i == 0 else 1.0)
            walker.place(0.0, turn, interval, 0.3 * tempo, half_width=STAND_WIDTH + 0.015, height=0.05)
        walker.place(0.0, 0.0, tempo, np.inf, half_width=STAND_WIDTH, height=0.05)
        return self.clip(name, walker, 0.0, walker.landed + rests[1])

    def standing(self, name: str, shifts: Iterable[tuple[float, float]], seconds: float) -> MotionClip:
        """Both feet down; ``shifts`` (time s, amount) move the weight from one to the other."""
        walker = self.stander(LEFT, np.inf)
        for time, amount in (*shifts, (0.0, 0.0), (seconds, 0.0)):
            walker.plan = walker.plan.shift(time, amount)
        return self.clip(name, walker, 0.0, seconds)

    def stepping_over(self, name: str, first: int, before: int, slow: float, reach: float) -> MotionClip:
        """Walk up to the obstacle in ``before`` steps, put one foot and then the other over it, walk on.

        ``slow`` stretches the time that both crossing swings take, ``reach`` the step across.
        """
        walker = self.walker(first)
        start = walker.landed
        walker.walk(before - 1).stride(NORMAL, length=0.92)
        walker.stride(0.95, length=0.9)
        leading = len(walker.plan.steps) - 2
        # Both feet in turn rise early or late enough to clear what is before or behind them.
        walker.place(reach, 0.0, 0.74 * slow, 0.16, height=0.30, rise=0.48, fall=0.34)
        walker.place(0.64, 0.0, 0.74 * slow, 0.14, height=0.30, rise=0.34, fall=0.48)
        crossed = walker.landed
        lifted = walker.plan.lift(leading)
        walker.stride(1.1).walk(2)
        end = walker.landed
        return self.clip(name, walker.walk(3), start, end, (lifted, crossed), watch=lifted - 0.4)


def _turning(angles: Iterable[float], speed: float, straight: int = 2) -> list[tuple[float, float]]:
    """Steps (speed, turn) that turn by ``angles`` in degrees, between straight ones at the normal speed."""
    plain = [(NORMAL, 0.0)] * straight
    return [*plain, *((speed, angle) for angle in angles), *plain]


def sample_repertoire(frame_rate: float = 30.0, rng: np.random.Generator | None = None) -> tuple[MotionClip, ...]:
    """Return the sample character's motion clips: walks, turns, arcs, starts, stops, pivots, standing, steps over.

    Each starts above the world's origin, facing -Y. Most begin and end in a straight walk at 1.2 m/s or
    standing, so that they can follow one another. The frames in which it crosses an obstacle of the
    size :data:`STEP_OBSTACLE` carry the tag :data:`STEP_TAG`: from the leading foot's lift to the trailing
    foot's landing.

    Parameters
    ----------
    frame_rate : float
        Samples per second.
    rng : numpy.random.Generator, optional
        Source of the small differences between the clips; by default, always the same.
    """
    rng = np.random.default_rng(2004) if rng is None else rng
    return tuple(_record(_Studio(frame_rate, rng)))


def _record(studio: _Studio) -> Iterator[MotionClip]:
    slow, brisk = 0.8, 1.6
    yield studio.walking("walk", LEFT, [(NORMAL, 0.0)] * 5)
    yield studio.walking("walk_again", RIGHT, [(1.25, 0.0)] * 5, phase=0.4)
    yield studio.walking("walk_slow", RIGHT, [(slow, 0.0)] * 4)
    yield studio.walking("walk_brisk", LEFT, [(brisk, 0.0)] * 5, phase=0.7)
    faster = (slow, slow, 1.0, NORMAL, 1.35, 1.5, brisk)
    yield studio.walking("walk_faster", LEFT, [(speed, 0.0) for speed in faster])
    slower = (brisk, brisk, 1.4, NORMAL, NORMAL, 1.0, slow, slow)
    yield studio.walking("walk_slower", RIGHT, [(speed, 0.0) for speed in slower], phase=0.3)
    yield studio.walking("turn_left_30", LEFT, _turning((14, 16), 1.15))
    yield studio.walking("turn_right_30", LEFT, _turning((-18, -12), 1.25), phase=0.5)
    yield studio.walking("turn_left_45", RIGHT, _turning((12, 21, 12), 1.1), phase=0.3)
    yield studio.walking("turn_right_45", RIGHT, _turning((-22, -23), 1.05))
    yield studio.walking("turn_left_60", LEFT, _turning((16, 26, 18), 1.0))
    yield studio.walking("turn_right_60", LEFT, _turning((-12, -18, -18, -12), 1.15), phase=0.6)
    yield studio.walking("turn_left_90", RIGHT, _turning((28, 34, 28), 0.95))
    yield studio.walking("turn_right_90", LEFT, _turning((-26, -36, -28), 0.85), phase=0.2)
    yield studio.walking("arc_left", LEFT, _turning((10, *[15] * 4, 10), 1.15, straight=1))
    yield studio.walking("arc_right", RIGHT, _turning((-6, *[-10] * 4, -6), 1.2, straight=1), phase=0.5)
    yield studio.starting("start_left", LEFT, 0.4, (0.9, 1.1, NORMAL, NORMAL))
    yield studio.starting("start_right", RIGHT, 0.6, (0.8, 1.0, 1.15, NORMAL))
    yield studio.stopping("stop_left", RIGHT, (NORMAL, NORMAL, 1.05, 0.85), 0.5)
    yield studio.stopping("stop_right", LEFT, (NORMAL, 1.1, 0.85, 0.6), 0.6)
    yield studio.stopping("stop_short", LEFT, (NORMAL, NORMAL, 0.95), 0.5)
    yield studio.standing("stand", [(0.6, 0.0), (1.3, 0.8), (1.9, 0.7), (2.7, -0.6), (3.2, -0.5)], 4.0)
    yield studio.pivoting("pivot_left_90", (56, 34), 0.60, (0.4, 0.5))
    yield studio.pivoting("pivot_right_90", (-48, -22, -20), 0.52, (0.5, 0.4))
    yield studio.pivoting("pivot_left_180", (56, 28, 56, 28, 12), 0.52, (0.4, 0.5))
    yield studio.stepping_over("step_over_left", RIGHT, 2, 0.97, 0.80)
    yield studio.stepping_over("step_over_right", LEFT, 2, 1.05, 0.78)
    yield studio.stepping_over("step_over_again", LEFT, 3, 0.93, 0.82)
