"""The capture director: motions that are missing, ranked by what they would open."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...progress import Progress, portion
from ..size import EmbeddingSize, Objective, embedding_size
from .candidate import Candidate, candidates
from .trial import trials_steps


@dataclass(frozen=True)
class Gain:
    """The ground that one more motion would open.

    Attributes
    ----------
    candidate : Candidate
    before, after : EmbeddingSize
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
    before: EmbeddingSize
    after: EmbeddingSize
    opened: np.ndarray
    floor: float
    places: int
    grows: bool

    @property
    def objective(self) -> float | None:
        """The fall of the objective; None if none was asked for."""
        if self.before.objective is None or self.after.objective is None:
            return None
        # An endless time that becomes finite is worth more than anything else; two endless ones are the same.
        return 0.0 if self.before.objective == self.after.objective else self.before.objective - self.after.objective

    def describe(self, objective: Objective | None = None) -> str:
        """ "A 60 degree left turn over 0.9 m would open 11.2 m²."."""
        words = self.candidate.words
        subject = words[0].upper() + words[1:]
        said = []
        if self.floor > 0:
            said.append(f"open {wording.area(self.floor)}")
        elif self.places > 0:
            places = wording.counted(self.places, "position and heading", "positions and headings")
            said.append(f"open {places}, but no new floor")
        before, after = self.before.objective, self.after.objective
        if objective is not None and before is not None and after is not None and before > after:
            said.append(
                f"shorten the {objective.name} from {wording.short(before)} to {wording.short(after)} {objective.unit}"
            )
        if not said:
            return f"{subject} would open nothing."
        return f"{subject} would {' and '.join(said)}."


@dataclass(frozen=True)
class CaptureAdvice:
    """Motions to capture next.

    Attributes
    ----------
    before : EmbeddingSize
    gains : tuple of Gain
        Ranked: by floor opened, then positions + headings, then how much the objective falls.
    objective : Objective or None
    """

    before: EmbeddingSize
    gains: tuple[Gain, ...]
    objective: Objective | None = None

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
            rows.append([*row, *([] if self.objective is None else [gain.objective])])
        if self.objective is not None:
            columns.append(f"{self.objective.name}, fall ({self.objective.unit})")
        return columns, rows

    def describe(self, n: int = 5) -> list[str]:
        """Sentences on the first ``n`` motions that would open anything."""
        useful = [
            gain
            for gain in self.gains
            if gain.floor > 0 or gain.places > 0 or (gain.objective is not None and gain.objective > 0)
        ]
        if not useful:
            return [
                f"None of {wording.counted(len(self.gains), 'motion')} would open anything: what is not reached lacks "
                "something other than these."
            ]
        return [gain.describe(self.objective) for gain in useful[:n]]


def direct_capture_steps(
    embedding: Embedding, tried: Sequence[Candidate] | None = None, objective: Objective | None = None
) -> Generator[Progress, None, CaptureAdvice]:
    """Rank motions by how much of the ground that is not reached they would open if they were captured.

    Each candidate is added to the motion graph alone. What it opens is exactly what embedding the larger graph would
    cover beyond the old embedding: all of it is free floor. If the old embedding is empty, or another component becomes
    the largest, that is what is compared, and ``Gain.grows`` tells.

    Parameters
    ----------
    tried : sequence of Candidate, optional
        :func:`candidates` of the embedding by default, retimed ones among them if there is an objective.
    objective : Objective, optional
        Ranks what opens as much.

    Raises
    ------
    EmbeddingError
        The embedding was pruned.
    """
    if tried is None:
        tried = candidates(embedding, retimed=objective is not None)
    trials = yield from portion(trials_steps(embedding, tried), 0.0, 0.05)
    before, covered = embedding_size(embedding, objective), embedding.covered()
    gains = []
    for index, candidate in enumerate(tried):
        yield Progress(0.05 + 0.95 * index / len(tried), f"Trying {candidate.words}")
        steps = trials.try_steps(candidate, index)
        grown = yield from portion(steps, 0.05 + 0.95 * index / len(tried), 0.05 + 0.95 * (index + 1) / len(tried))
        new = grown.covered()
        opened = new.any(axis=2) & ~covered.any(axis=2)
        gains.append(
            Gain(
                candidate=candidate,
                before=before,
                after=embedding_size(grown, objective),
                opened=opened,
                floor=int(np.count_nonzero(opened)) * embedding.environment.grid.cell_size**2,
                places=int(np.count_nonzero(new & ~covered)),
                grows=all(not old & ~plane for old, plane in zip(trials.embedding.planes, grown.planes, strict=False)),
            )
        )
    gains.sort(key=lambda gain: (-gain.floor, -gain.places, -(gain.objective or 0.0)))
    return CaptureAdvice(before, tuple(gains), objective)
