"""The capture director: motions that are missing, ranked by what they would open."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...progress import Progress, portion
from ..extent import Extent, Measure, extent
from .candidate import Candidate, candidates
from .trial import stage_steps


@dataclass(frozen=True)
class Gain:
    """What one more motion would open.

    Attributes
    ----------
    candidate : Candidate
    before, after : Extent
        Of the embedding without and with it.
    opened : (nx, ny) bool array
        Cells that would be covered and are not.
    floor : float
        Square metres of those.
    places : int
        Positions + headings that would be covered and are not.
    grows : bool
        Whether the old embedding is part of the new one. If not, the new motion makes another component the largest.
    """

    candidate: Candidate
    before: Extent
    after: Extent
    opened: np.ndarray
    floor: float
    places: int
    grows: bool

    @property
    def measure(self) -> float | None:
        """By how much the measure falls; None if none was asked for."""
        if self.before.measure is None or self.after.measure is None:
            return None
        # An endless time that becomes finite is worth more than anything else; two endless ones are the same.
        return 0.0 if self.before.measure == self.after.measure else self.before.measure - self.after.measure

    def describe(self, measure: Measure | None = None) -> str:
        """ "A 60 degree left turn over 0.9 m would open 11.2 m²."."""
        words = self.candidate.words
        subject = words[0].upper() + words[1:]
        said = []
        if self.floor > 0:
            said.append(f"open {wording.area(self.floor)}")
        elif self.places > 0:
            places = wording.counted(self.places, "position and heading", "positions and headings")
            said.append(f"open {places}, but no new floor")
        before, after = self.before.measure, self.after.measure
        if measure is not None and before is not None and after is not None and before > after:
            said.append(
                f"shorten the {measure.name} from {wording.short(before)} to {wording.short(after)} {measure.unit}"
            )
        if not said:
            return f"{subject} would open nothing."
        return f"{subject} would {' and '.join(said)}."


@dataclass(frozen=True)
class CaptureAdvice:
    """What to capture next.

    Attributes
    ----------
    before : Extent
    gains : tuple of Gain
        Ranked: by floor opened, then positions + headings, then how much the measure falls.
    measure : Measure or None
    """

    before: Extent
    gains: tuple[Gain, ...]
    measure: Measure | None = None

    def table(self) -> tuple[list[str], list[list]]:
        """The ranked gains as the names of columns and rows of text and numbers."""
        columns = ["motion", "length (m)", "turn (degrees)", "duration (s)", "opened floor (m2)", "opened places"]
        columns += ["more nodes", "more links"]
        rows = []
        for gain in self.gains:
            segment, before, after = gain.candidate.segment, gain.before, gain.after
            steps = np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1)
            move = [float(steps.sum()), float(np.degrees(segment.path[-1, 2])), segment.duration]
            growth = [gain.floor, gain.places, after.nodes - before.nodes, after.links - before.links]
            row = [gain.candidate.words, *move, *growth]
            rows.append([*row, *([] if self.measure is None else [gain.measure])])
        if self.measure is not None:
            columns.append(f"{self.measure.name}, fall ({self.measure.unit})")
        return columns, rows

    def describe(self, n: int = 5) -> list[str]:
        """Sentences on the first ``n`` motions that would open anything."""
        useful = [
            gain
            for gain in self.gains
            if gain.floor > 0 or gain.places > 0 or (gain.measure is not None and gain.measure > 0)
        ]
        if not useful:
            return [
                f"None of {wording.counted(len(self.gains), 'motion')} would open anything: what is not reached lacks "
                "something other than these."
            ]
        return [gain.describe(self.measure) for gain in useful[:n]]


def direct_capture_steps(
    embedding: Embedding, tried: Sequence[Candidate] | None = None, measure: Measure | None = None
) -> Generator[Progress, None, CaptureAdvice]:
    """Which motion, if it were captured, would open most of the ground that is not reached?

    Each candidate is added to the motion graph alone. What it opens is exactly what embedding the larger graph would
    cover beyond the old embedding: all of it is free floor. If the old embedding is empty, or another component becomes
    the largest, that is what is compared, and ``Gain.grows`` tells.

    Parameters
    ----------
    tried : sequence of Candidate, optional
        :func:`candidates` of the embedding by default, retimed ones among them if there is a measure.
    measure : Measure, optional
        Ranks what opens as much.

    Raises
    ------
    EmbeddingError
        The embedding was pruned.
    """
    if tried is None:
        tried = candidates(embedding, retimed=measure is not None)
    stage = yield from portion(stage_steps(embedding, tried), 0.0, 0.05)
    before, covered = extent(embedding, measure), embedding.covered()
    gains = []
    for index, candidate in enumerate(tried):
        yield Progress(0.05 + 0.95 * index / len(tried), f"Trying {candidate.words}")
        steps = stage.try_steps(candidate, index)
        grown = yield from portion(steps, 0.05 + 0.95 * index / len(tried), 0.05 + 0.95 * (index + 1) / len(tried))
        new = grown.covered()
        opened = new.any(axis=2) & ~covered.any(axis=2)
        gains.append(
            Gain(
                candidate=candidate,
                before=before,
                after=extent(grown, measure),
                opened=opened,
                floor=int(np.count_nonzero(opened)) * embedding.environment.grid.cell_size**2,
                places=int(np.count_nonzero(new & ~covered)),
                grows=all(not old & ~plane for old, plane in zip(stage.embedding.planes, grown.planes, strict=False)),
            )
        )
    gains.sort(key=lambda gain: (-gain.floor, -gain.places, -(gain.measure or 0.0)))
    return CaptureAdvice(before, tuple(gains), measure)
