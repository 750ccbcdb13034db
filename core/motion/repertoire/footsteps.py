"""Footstep plans: places and times at which each foot comes down, and the path that the body takes over them."""

from dataclasses import dataclass, field, replace

import numpy as np

WALK_WIDTH = 0.055
STAND_WIDTH = 0.085
"""Half the distance between the two ankles' tracks, in metres."""


@dataclass(frozen=True)
class Footstep:
    """One footprint, and how the foot swings there.

    Attributes
    ----------
    side : int
        1 for the left foot, -1 for the right.
    station : (3,) float array
        x, y (m) and heading (rad) of the body as if it stood at this step.
    half_width : float
        How far beside the station the foot is, in metres.
    land, overlap : float
        The time at which the heel touches down, and the seconds from then until the other foot lifts.
    height : float
        Metres that the swing rises above a foot that is merely carried forward.
    rise, fall : float
        Fractions of the swing's time that going up and coming down take.
    """

    side: int
    station: np.ndarray
    half_width: float
    land: float
    overlap: float
    height: float = 0.03
    rise: float = 0.5
    fall: float = 0.5


@dataclass(frozen=True)
class FootstepPlan:
    """Alternating footsteps in the order of landing, and shifts of weight while standing (time, -1..1)."""

    steps: tuple[Footstep, ...] = ()
    shifts: tuple[tuple[float, float], ...] = field(default=())

    @classmethod
    def standing(cls, side: int, seconds: float) -> "FootstepPlan":
        """Both feet down for ``seconds``; then the foot ``side`` will step."""
        feet = Footstep(side, np.zeros(3), STAND_WIDTH, 0.0, 0.0)
        return cls((feet, replace(feet, side=-side, overlap=seconds)))

    @classmethod
    def walking(cls, side: int, overlap: float) -> "FootstepPlan":
        """A first footprint at the origin; it takes a few more steps before both feet move as they should."""
        return cls((Footstep(-side, np.zeros(3), WALK_WIDTH, 0.0, overlap),))

    def step(
        self,
        length: float,
        turn: float,
        interval: float,
        overlap: float,
        half_width: float = WALK_WIDTH,
        height: float = 0.03,
        rise: float = 0.5,
        fall: float = 0.5,
    ) -> "FootstepPlan":
        """The plan with one more step: ``length`` m on, ``turn`` rad round, ``interval`` s after the last.

        While both feet are down after a standing start, ``interval`` counts from the lift of the foot.
        """
        last = self.steps[-1]
        direction = last.station[2] + turn / 2
        station = last.station + np.array([length * np.cos(direction), length * np.sin(direction), turn])
        since = last.land + last.overlap if self._is_rest(len(self.steps) - 1) else last.land
        new = Footstep(-last.side, station, half_width, since + interval, overlap, height, rise, fall)
        return replace(self, steps=(*self.steps, new))

    def shift(self, time: float, amount: float) -> "FootstepPlan":
        """The plan with the weight over one foot (1: all of it on the left) at ``time``."""
        return replace(self, shifts=(*self.shifts, (time, amount)))

    def lift(self, k: int) -> float:
        """The time at which the foot of step k leaves the floor; infinite if it never does."""
        return self.steps[k + 1].land + self.steps[k + 1].overlap if k + 2 < len(self.steps) else np.inf

    def _is_rest(self, k: int) -> bool:
        """Test whether the body comes to rest when step k has landed: the feet are side by side for a while."""
        return k > 0 and bool(np.allclose(self.steps[k].station, self.steps[k - 1].station))

    def body_knots(self, settle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (K,), stations (K, 3) and the lead of the left foot (K,) in metres, at which the body passes.

        Half-way through each double support the body is half-way between the feet. At rest it stays there,
        from ``settle`` s after landing to ``settle`` s before the next lift.
        """
        times, stations, leads = [], [], []
        for k in range(1, len(self.steps)):
            before, step = self.steps[k - 1], self.steps[k]
            middle = (before.station + step.station) / 2
            forward = np.array([np.cos(middle[2]), np.sin(middle[2])])
            lead = step.side * float(forward @ (step.station - before.station)[:2])
            end = step.land + min(step.overlap, 60.0)
            if self._is_rest(k) or step.overlap > 2 * settle:
                moments = [step.land + settle, max(end - settle, step.land + settle + 0.05)]
            else:
                moments = [(step.land + end) / 2]
            times += moments
            stations += [middle] * len(moments)
            leads += [lead] * len(moments)
        return np.array(times), np.array(stations), np.array(leads)

    def weight_knots(self, settle: float) -> tuple[np.ndarray, np.ndarray]:
        """Times (K,) and (K, 2) values: which foot bears the weight (1 left, -1 right), and where it is.

        The second value is the foot's distance to the left of the body's path in metres. The weight is over a
        foot in the middle of the time for which it alone is down.
        """
        knots = [(time, amount, amount * STAND_WIDTH) for time, amount in self.shifts]
        for k in range(1, len(self.steps)):
            step = self.steps[k]
            end = step.land + min(step.overlap, 60.0)
            if self._is_rest(k):
                knots += [
                    (step.land + settle, 0.0, 0.0),
                    (max(end - settle, step.land + settle + 0.05), 0.0, 0.0),
                ]
            if k + 1 < len(self.steps):
                alone = (end + self.steps[k + 1].land) / 2
                knots.append((alone, float(step.side), step.side * step.half_width))
        table = np.array(sorted(knots))
        return table[:, 0], table[:, 1:]
