"""One-step unrolling: for every stencil, the plane of start cells from which its edited path is free."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION
from ..motion.graph import MotionSegment
from ..progress import Progress
from .bitplane import PlaneLayout
from .stencil import Stencils, SweptSamples, swept_samples, tag_classes


@dataclass(frozen=True)
class Unrolling:
    """All one-step links of the embedding, free of obstacles and allowed by the regions.

    Attributes
    ----------
    layout : PlaneLayout
    stencils : Stencils
    valid : tuple of K int
        For each stencil the bit-plane of the start cells from which it may be played.
    """

    layout: PlaneLayout
    stencils: Stencils
    valid: tuple[int, ...]


def unroll_steps(
    segments: Sequence[MotionSegment], stencils: Stencils, environment: Environment
) -> Generator[Progress, None, Unrolling]:
    """Check every stencil against the environment; yields progress, returns the :class:`Unrolling`."""
    grid = environment.grid
    classes, frame_classes = tag_classes(segments, environment.tags)
    first = np.searchsorted(stencils.segment, np.arange(len(segments) + 1))
    swept = []
    for index, segment in enumerate(segments):
        yield Progress(0.4 * index / len(segments), "Sweeping paths")
        chosen = np.arange(first[index], first[index + 1])
        if len(chosen):
            swept.append(swept_samples(stencils, chosen, segment, frame_classes[index], grid))

    layout = PlaneLayout(
        grid.shape[0],
        grid.shape[1],
        max((int(np.abs(s.x // SUBDIVISION).max()) for s in swept), default=0),
        max((int(np.abs(s.y // SUBDIVISION).max()) for s in swept), default=0),
        grid.tiled,
    )
    free = [_phase_planes(environment.free_samples(tags), layout) for tags in classes]
    valid = [0] * len(stencils)
    for done, samples in enumerate(swept):
        yield Progress(0.4 + 0.6 * done / len(swept), "Checking paths")
        _check(samples, free, layout, valid)
    return Unrolling(layout, stencils, tuple(valid))


def _phase_planes(free: np.ndarray, layout: PlaneLayout) -> list[int]:
    """The (4 nx, 4 ny) mask as one plane for each place of a sample within its cell, x first."""
    return [
        layout.extend(layout.pack(free[x::SUBDIVISION, y::SUBDIVISION]))
        for x in range(SUBDIVISION)
        for y in range(SUBDIVISION)
    ]


def _check(samples: SweptSamples, free: list[list[int]], layout: PlaneLayout, valid: list[int]) -> None:
    """Set ``valid`` for the stencils of ``samples``: an AND of free-space planes, one for each sample on the way."""
    phase = (samples.x % SUBDIVISION) * SUBDIVISION + samples.y % SUBDIVISION
    shift = layout.shift(samples.x // SUBDIVISION, samples.y // SUBDIVISION)
    shown = np.unique(samples.stencil, return_index=True)
    bounds = [*shown[1].tolist(), len(phase)]
    checks = list(zip(samples.tag_class.tolist(), phase.tolist(), shift.tolist(), strict=True))
    for stencil, start, stop in zip(shown[0].tolist(), bounds, bounds[1:], strict=False):
        plane = layout.ground
        for tag_class, place, moved in checks[start:stop]:
            space = free[tag_class][place]
            plane &= space >> moved if moved >= 0 else space << -moved
            if not plane:
                break
        valid[stencil] = plane
