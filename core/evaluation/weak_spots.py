"""Weak spots: connected areas that cannot be reached, or where there are few ways through (paper, section 4.1)."""

from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .. import wording
from ..embedding.embedding import Embedding
from ..environment.grid import Grid
from ..errors import EmbeddingError
from ..progress import Progress, portion
from .floor import floor_cells, ruled_cells
from .variability import variability_steps
from .why_not import Reason, why_not_steps

#: What stands in a sentence for each reason.
_PHRASE = {
    Reason.EMBEDDED: "reached",
    Reason.BLOCKED: "blocked",
    Reason.RULE: "only crossed, under a rule",
    Reason.FORBIDDEN: "forbidden",
    Reason.NO_WAY_OUT: "no way out",
    Reason.NO_WAY_IN: "no way in",
    Reason.NO_MATCH: "ways in and out do not match",
    Reason.OTHER_COMPONENT: "cut off from the rest",
    Reason.UNREACHABLE: "nothing fits there",
    Reason.NO_GROUND: "no ground here",
}


class Weakness(Enum):
    """The two ways to be a weak spot."""

    UNREACHED = "Not Reached"
    """Variability is 0: nothing passes."""
    FEW_WAYS = "Few Ways"
    """Variability is positive, but under the threshold."""


class Domain(Enum):
    """The space in which areas are sought."""

    FLOOR = "Floor"
    """Cells (x, y); their variability is summed over headings."""
    HEADINGS = "Floor and Headings"
    """Grid elements (x, y, heading): also a cell that is passed, but never in this heading."""


@dataclass(frozen=True)
class WeakSpotSettings:
    """The limits of what counts as a weak spot.

    Attributes
    ----------
    domain : Domain
    threshold : int
        Variability under which a place that is reached counts as weak; with 0 only places that are not reached do.
    min_area : float
        Square metres that an area needs to be listed; on ``HEADINGS`` as in :attr:`WeakSpot.area`.
    diagonal : bool
        Whether cells that touch only at a corner (and, with headings, at an edge) belong together.
    """

    domain: Domain = Domain.FLOOR
    threshold: int = 0
    min_area: float = 0.1
    diagonal: bool = False

    def __post_init__(self):
        if not self.threshold >= 0:
            raise EmbeddingError(f"Weak spots have a variability under {self.threshold}: use a threshold of 0 or more.")
        if not self.min_area >= 0:
            raise EmbeddingError(f"Weak spots of at least {self.min_area} square metres: use an area of 0 or more.")


@dataclass(frozen=True)
class WeakSpot:
    """One connected area of free floor that is weak.

    Attributes
    ----------
    weakness : Weakness
    domain : Domain
    n_elements : int
        Cells, or grid elements (x, y, heading).
    floor_area : float
        Square metres of the cells that it touches.
    heading_share : float
        Share of the headings that belong to it, on average over those cells; 1 on the floor.
    position : (x, y)
        World position in metres of the cell of the area that is nearest to its middle.
    heading : float or None
        Radians: the heading of that element; None on the floor.
    low, high : (x, y)
        Bounding box of its cells in metres. On a tiled ground it may stretch past the edge.
    mean_variability : float
        Over its elements; of the floor map or of single headings, as the domain says.
    lowest_variability : int
    reason : Reason
        What most of its grid elements (all headings) that are not in the embedding suffer from; EMBEDDED if all are.
    reason_share : float
        Share of its grid elements that this is true of.
    """

    weakness: Weakness
    domain: Domain
    n_elements: int
    floor_area: float
    heading_share: float
    position: tuple[float, float]
    heading: float | None
    low: tuple[float, float]
    high: tuple[float, float]
    mean_variability: float
    lowest_variability: int
    reason: Reason
    reason_share: float

    @property
    def area(self) -> float:
        """Square metres; with headings, each cell counts for the share of its headings that belong to the area."""
        return self.floor_area * self.heading_share

    def describe(self) -> str:
        """The weak spot in a sentence with units."""
        headings = "" if self.heading is None else f", in {wording.share(self.heading_share)} of the headings,"
        place = f"{wording.area(self.floor_area)} around {wording.place(*self.position)}{headings}"
        why = _PHRASE[self.reason]
        if self.weakness is Weakness.UNREACHED:
            mainly = "" if self.reason_share > 0.995 else "mainly "
            return f"{place} cannot be reached: {mainly}{why}"
        mean = wording.amount(self.mean_variability)
        lowest = wording.number(self.lowest_variability)
        ways = f"{place} has a variability of only {mean} on average, {lowest} at the lowest"
        if self.reason is Reason.EMBEDDED:
            return ways
        return f"{ways}: {why} in {wording.share(self.reason_share)} of the cells and headings"


@dataclass(frozen=True)
class WeakSpots:
    """All weak spots of an embedding.

    Attributes
    ----------
    settings : WeakSpotSettings
    spots : tuple of WeakSpot
        Largest area first; of equal ones, the one whose first cell comes first in order of x, y (and heading).
    labels : (nx, ny) or (nx, ny, n_headings) int32 array
        For each cell or element 1 + the index of its spot; 0 where there is none.
    """

    settings: WeakSpotSettings
    spots: tuple[WeakSpot, ...]
    labels: np.ndarray

    @property
    def area(self) -> float:
        """Square metres of all spots together, as :attr:`WeakSpot.area` counts them."""
        return sum(spot.area for spot in self.spots)

    def describe(self) -> str:
        """One line for each spot."""
        return "\n".join(spot.describe() for spot in self.spots) or "There are no weak spots."


def weak_spots_steps(
    embedding: Embedding, settings: WeakSpotSettings | None = None
) -> Generator[Progress, None, WeakSpots]:
    """Find connected areas of the free floor that the embedding does not reach, or reaches in few ways (paper, 4.1).

    Areas that are not reached and areas with few ways are separate spots, also where they touch. What lies under a
    region's rule (:func:`.floor.ruled_cells`) is neither. An empty embedding
    reaches nothing: all its free floor is weak.
    """
    settings = settings or WeakSpotSettings()
    ways = yield from portion(variability_steps(embedding), 0.0, 0.3)
    reasons = yield from portion(why_not_steps(embedding), 0.3, 0.9)
    yield Progress(0.9, "Listing weak spots")
    grid = embedding.environment.grid
    # Where a rule must be kept to cross, nobody expects many ways.
    free = floor_cells(embedding) & ~ruled_cells(embedding.environment, embedding.unrolling.sweep.classes)
    if settings.domain is Domain.FLOOR:
        values, allowed = ways.sum(axis=2), free
    else:
        values, allowed = ways, np.repeat(free[:, :, None], grid.n_headings, axis=2)
    found: list[tuple[WeakSpot, np.ndarray]] = []
    for weakness, mask in (
        (Weakness.UNREACHED, allowed & (values == 0)),
        (Weakness.FEW_WAYS, allowed & (values > 0) & (values < settings.threshold)),
    ):
        for area in connected_areas(mask, grid.tiled, settings.diagonal):
            spot = _spot(weakness, settings.domain, area, values, reasons, grid)
            # An area of exactly the minimum must not fail by rounding.
            if spot.area >= settings.min_area * (1 - 1e-9):
                found.append((spot, area))
    found.sort(key=lambda pair: (-pair[0].n_elements, pair[1][:, 0].tolist()))
    labels = np.zeros(values.shape, dtype=np.int32)
    for number, (_, area) in enumerate(found, 1):
        labels[tuple(area)] = number
    return WeakSpots(settings, tuple(spot for spot, _ in found), labels)


def connected_areas(mask: np.ndarray, tiled: bool, diagonal: bool = False) -> list[np.ndarray]:
    """Find the connected parts of an (nx, ny) or (nx, ny, n_headings) bool mask: (2 or 3, n) int arrays of cells.

    >>> row = np.array([[1, 1, 0, 1]], dtype=bool)
    >>> [area.T.tolist() for area in connected_areas(row, tiled=False)]
    [[[0, 0], [0, 1]], [[0, 3]]]
    >>> len(connected_areas(row, tiled=True))
    1

    Neighbours share a side, or with ``diagonal`` at least a corner. Headings join at 360 degrees; x and y join at the
    edges if ``tiled``.
    """
    joined = [axis for axis in range(mask.ndim) if axis == 2 or tiled]
    # One layer more on each side, a copy of the opposite edge: pieces that meet there are one.
    pad = [(1, 1) if axis in joined else (0, 0) for axis in range(mask.ndim)]
    padded = np.pad(mask, pad, mode="wrap")
    structure = ndimage.generate_binary_structure(mask.ndim, mask.ndim if diagonal else 1)
    labels = np.empty(padded.shape, dtype=np.int32)
    ndimage.label(padded, structure, output=labels)
    own = labels[tuple(slice(1, -1) if axis in joined else slice(None) for axis in range(mask.ndim))]
    # Every padded element is a copy of one of our own: the labels of both belong together.
    copies = np.pad(own, pad, mode="wrap")
    pairs = labels[padded], copies[padded]
    group = connected_components(
        coo_array((np.ones(len(pairs[0])), pairs), shape=(int(labels.max(initial=0)) + 1,) * 2)
    )[1]
    place = np.argwhere(mask)
    group = group[own[mask]]
    order = np.argsort(group, kind="stable")
    bounds = np.flatnonzero(np.diff(group[order], prepend=-1))
    return [place[part].T for part in np.split(order, bounds)[1:]]


def _spot(
    weakness: Weakness, domain: Domain, area: np.ndarray, values: np.ndarray, reasons: np.ndarray, grid: Grid
) -> WeakSpot:
    cells = np.unique(area[:2], axis=1)
    n_cells = cells.shape[1]
    there = values[tuple(area)]
    unwrapped = np.stack(
        [_unwrapped(row, n) if grid.tiled else row for row, n in zip(area, grid.shape[:2], strict=False)]
    )
    middle = unwrapped.mean(axis=1, keepdims=True)
    nearest = int(np.argmin(np.square(unwrapped - middle).sum(axis=0)))
    x, y = grid.positions(area[:2, nearest]).tolist()
    low = np.asarray(grid.origin) + unwrapped.min(axis=1) * grid.cell_size
    high = np.asarray(grid.origin) + (unwrapped.max(axis=1) + 1) * grid.cell_size
    counts = np.bincount(reasons[tuple(area)].ravel(), minlength=len(Reason))
    outside = counts.copy()
    outside[Reason.EMBEDDED] = 0
    reason = Reason(int(np.argmax(outside))) if outside.any() else Reason.EMBEDDED
    return WeakSpot(
        weakness=weakness,
        domain=domain,
        n_elements=area.shape[1],
        floor_area=n_cells * grid.cell_size**2,
        heading_share=1.0 if domain is Domain.FLOOR else area.shape[1] / (n_cells * grid.n_headings),
        position=(x, y),
        heading=None if domain is Domain.FLOOR else float(area[2, nearest] * grid.heading_step),
        low=tuple(low.tolist()),
        high=tuple(high.tolist()),
        mean_variability=float(there.mean()),
        lowest_variability=int(there.min()),
        reason=reason,
        reason_share=float(counts[reason] / counts.sum()),
    )


def _unwrapped(cells: np.ndarray, n: int) -> np.ndarray:
    """Coordinates on a ring of ``n`` cells as a stretch without the ring's largest gap: some may be n or more."""
    occupied = np.unique(cells)
    gaps = np.diff(np.append(occupied, occupied[0] + n))
    widest = int(np.argmax(gaps))
    if widest == len(occupied) - 1:
        return cells
    return np.where(cells < occupied[widest + 1], cells + n, cells)
