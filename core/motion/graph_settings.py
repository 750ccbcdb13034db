"""Settings of :mod:`.graph`."""

import math
from dataclasses import dataclass, field
from enum import Enum

from .. import wording
from ..errors import MotionGraphError
from .contacts import ContactSettings
from .distance import CostSettings

HIGHEST_RATE = 1000.0
"""Frames per second: motion that is compared at more of them is not compared any better."""


class ThresholdMode(Enum):
    """Ways to find the cost up to which frames are linked."""

    COST = "cost"
    """It is ``max_cost``."""
    LINKS = "links"
    """As many links as possible, at most ``max_links``, none of them dearer than ``max_cost``."""
    COVERAGE = "coverage"
    """As low as possible, so that at least ``min_coverage`` of the motion is kept; not above ``max_cost``."""


@dataclass(frozen=True)
class MotionGraphSettings:
    """Settings by which clips are cut and linked.

    Attributes
    ----------
    frame_rate : float
        Samples per second at which motion is compared and cut; at most ``HIGHEST_RATE``.
    min_segment_duration : float
        Seconds that every segment lasts at least, rounded to whole frames.
    max_cost : float
        Transition cost D (rad^2) above which frames are not linked. Neighbouring frames of a walk at 30
        frames per second differ by 0.1 (slow) to 0.3 (fast). In the threshold modes other than COST the
        highest cost that is considered.
    sigma : float, optional
        Cost (rad^2) at which the goodness exp(-D / sigma) of a link has fallen to 37 %; a third of the
        threshold if not given. Smaller values prefer smooth links and more segments, larger ones many
        links.
    cost : CostSettings
        What counts, and how much, in the transition cost.
    contacts : ContactSettings
        When a foot counts as planted; frames are only linked if the same feet are.
    n_starts : int
        How many times the search for cuts begins anew; the best outcome is kept.
    seed : int
        Of the random beginnings: the same seed, the same graph.
    threshold_mode : ThresholdMode
        How the threshold is found.
    max_links : int
        Most links that the graph may have; heeded in mode LINKS.
    min_coverage : float
        Share (0 to 1) of the motion given that the graph must keep at least; heeded in mode COVERAGE.
    memory_limit : float
        Bytes that the frames may take, and the pairs of them; above it ``build_motion_graph`` refuses before it reads
        or compares them.
    """

    frame_rate: float = 30.0
    min_segment_duration: float = 0.9
    max_cost: float = 0.3
    sigma: float | None = None
    cost: CostSettings = field(default_factory=CostSettings)
    contacts: ContactSettings = field(default_factory=ContactSettings)
    n_starts: int = 8
    seed: int = 0
    threshold_mode: ThresholdMode = ThresholdMode.COST
    max_links: int = 500
    min_coverage: float = 0.5
    memory_limit: float = 4e9

    def __post_init__(self):
        for name in ("frame_rate", "min_segment_duration", "max_cost"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise MotionGraphError(f"The setting {name.replace('_', ' ')} is {value}; it must be positive.")
        if self.frame_rate > HIGHEST_RATE:
            raise MotionGraphError(
                f"The setting frame rate is {wording.exact(self.frame_rate)}; use {wording.exact(HIGHEST_RATE)} frames "
                "per second or less."
            )
        if self.sigma is not None and not self.sigma > 0:
            raise MotionGraphError(f"The setting sigma is {self.sigma}; it must be positive.")
        if self.n_starts < 1:
            raise MotionGraphError("The search for cuts needs at least one start.")
        if self.max_links < 1:
            raise MotionGraphError(f"A motion graph of at most {self.max_links} links is none; allow at least one.")
        if not 0 < self.min_coverage <= 1:
            raise MotionGraphError(
                f"The setting min coverage is {self.min_coverage}; it must be a share of the motion between 0 and 1."
            )

    @property
    def min_gap(self) -> int:
        """Frames from one cut to the next at least."""
        return max(1, round(self.min_segment_duration * self.frame_rate))

    def goodness_width(self, threshold: float) -> float:
        """Return ``sigma``, or what stands for it at a threshold (rad^2)."""
        return threshold / 3 if self.sigma is None else self.sigma
