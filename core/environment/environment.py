"""The environment: ground grid, blocked samples and region masks."""

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..errors import SceneError
from ..progress import Progress, finish
from .grid import SUBDIVISION, Grid
from .obstacle_masks import ObstacleCache
from .obstacles import MAX_SAMPLES, SAMPLE_BYTES, clip_to_heights, samples_within, solid_strips
from .pieces import Piece, Shape, solid_triangles
from .regions import Region, RegionMask, RegionRule, rasterise_regions, samples_inside


@dataclass(frozen=True)
class EnvironmentSettings:
    """The body that must fit through the scene.

    Attributes
    ----------
    radius : float
        Metres that the root keeps from every obstacle, measured on the ground plane.
    step_height : float
        Metres above the ground below which geometry is walked on, not around.
    head_height : float
        Metres above the ground above which geometry is walked under.
    ground_height : float
        World z of the ground in metres.
    """

    radius: float = 0.25
    step_height: float = 0.05
    head_height: float = 1.9
    ground_height: float = 0.0


@dataclass(frozen=True)
class Environment:
    """The places where the root may be, for each combination of tags.

    Attributes
    ----------
    grid : Grid
    blocked : (4 nx, 4 ny) bool array
        Samples with any point closer to an obstacle than the character's radius, or off the ground.
    regions : tuple of RegionMask
    off_ground : (4 nx, 4 ny) bool array, optional
        The blocked samples that an outlined ground does not cover wholly; None where the ground is the whole grid.
    """

    grid: Grid
    blocked: np.ndarray
    regions: tuple[RegionMask, ...] = ()
    off_ground: np.ndarray | None = None

    def __post_init__(self):
        expected = (self.grid.shape[0] * SUBDIVISION, self.grid.shape[1] * SUBDIVISION)
        own = [("blocked", self.blocked)] + ([] if self.off_ground is None else [("off_ground", self.off_ground)])
        for name, mask in [*own, *((r.name, r.mask) for r in self.regions)]:
            if mask.shape != expected or mask.dtype != bool:
                raise SceneError(
                    f"The mask '{name}' has {mask.shape} {mask.dtype} samples; the grid needs {expected} bool."
                )

    @property
    def tags(self) -> frozenset[str]:
        """The tags that any region speaks of; all others make no difference."""
        return frozenset(region.tag for region in self.regions)

    def free_samples(self, tags: Iterable[str]) -> np.ndarray:
        """Return (4 nx, 4 ny) bool: where a frame that carries exactly ``tags`` may be played."""
        tags = frozenset(tags)
        free = ~self.blocked
        for region in self.regions:
            if (region.rule is RegionRule.REQUIRE and region.tag not in tags) or (
                region.rule is RegionRule.FORBID and region.tag in tags
            ):
                free = free & ~region.mask
        for tag in sorted(tags):
            confining = [r.mask for r in self.regions if r.rule is RegionRule.CONFINE and r.tag == tag]
            if confining:
                free = free & np.logical_or.reduce(confining)
        return free

    def bare_cells(self) -> np.ndarray:
        """Return (nx, ny) bool: cells at whose centre there is no ground."""
        if self.off_ground is None:
            return np.zeros(self.grid.shape[:2], dtype=bool)
        corner = SUBDIVISION // 2
        return self.off_ground[corner::SUBDIVISION, corner::SUBDIVISION]

    def free_cells(self) -> np.ndarray:
        """Return (nx, ny) bool: cells at whose centre a character may stand, whatever it is doing there."""
        corner = SUBDIVISION // 2
        return ~self.blocked[corner::SUBDIVISION, corner::SUBDIVISION]


def build_environment(
    grid: Grid,
    obstacles: np.ndarray | Sequence[Piece],
    regions: Sequence[Region] = (),
    settings: EnvironmentSettings | None = None,
    memory: ObstacleCache | None = None,
    ground: np.ndarray | Piece | None = None,
) -> Environment:
    """Rasterise obstacles and regions, see :func:`build_environment_steps`.

    >>> wall = np.array([[[1.6, 0.0, 0.0], [1.6, 3.0, 0.0], [1.6, 0.0, 1.0]]])  # a triangle that stands on its edge
    >>> environment = build_environment(Grid((3, 3, 4), 1.0), wall, settings=EnvironmentSettings(radius=0.25))
    >>> environment.free_cells().astype(int)
    array([[1, 1, 1],
           [0, 0, 0],
           [1, 1, 1]])
    """
    return finish(build_environment_steps(grid, obstacles, regions, settings, memory, ground))


def build_environment_steps(
    grid: Grid,
    obstacles: np.ndarray | Sequence[Piece],
    regions: Sequence[Region] = (),
    settings: EnvironmentSettings | None = None,
    memory: ObstacleCache | None = None,
    ground: np.ndarray | Piece | None = None,
) -> Generator[Progress, None, Environment]:
    """Rasterise obstacles and regions. Yields progress.

    Parameters
    ----------
    obstacles : (T, 3, 3) float array, or sequence of Piece
        World-space triangles in metres. Only what lies between step height and head height above the ground counts.
    regions : sequence of Region
    memory : ObstacleCache, optional
        What the pieces and the ground left when they were last rasterised: those that it knows are not looked at
        again, and the others in several steps. The environment is the same with it and without.
    ground : (T, 3, 3) float array or Piece, optional
        World-space triangles in metres of what can be stood on, seen from above: the root keeps to samples that they
        cover wholly. By default that is the whole grid.

    Raises
    ------
    SceneError
        A coordinate is not a number or absurdly large, a radius is negative or would take too much memory, or a region
        lies wholly outside the ground.
    """
    settings = settings or EnvironmentSettings()
    n_samples = grid.shape[0] * grid.shape[1] * SUBDIVISION**2
    if n_samples > MAX_SAMPLES:
        raise SceneError(
            f"The ground of {wording.amount(grid.size[0])} x {wording.amount(grid.size[1])} m in cells of "
            f"{wording.exact(grid.cell_size)} m would need about {wording.memory(n_samples * SAMPLE_BYTES)} for its "
            "obstacles; use a larger Cell Size or a smaller ground."
        )
    if not (np.isfinite(settings.radius) and settings.radius >= 0):
        raise SceneError(f"The character's Radius is {settings.radius}; it must be zero or more.")
    if not settings.step_height < settings.head_height:
        raise SceneError("Step Height must be below Head Height.")
    if not np.isfinite(settings.ground_height):
        raise SceneError("The height of the ground is not a number; check the ground object.")
    low, high = settings.ground_height + settings.step_height, settings.ground_height + settings.head_height
    if isinstance(obstacles, np.ndarray):
        triangles = np.asarray(obstacles, dtype=float)
        if triangles.size and triangles.shape[1:] != (3, 3):
            raise SceneError(f"Obstacles are triangles of shape (T, 3, 3), not {triangles.shape}.")
        obstacles = (Piece(Shape(triangles.reshape(-1, 3, 3)), np.eye(4)),)
    memory = memory if memory is not None and memory.serves(grid) else None
    if memory is not None:
        blocked = yield from memory.blocked_steps(grid, obstacles, settings.radius, low, high)
    else:
        blocked = _blocked(grid, solid_triangles(obstacles, grid.corners, (low, high)), settings.radius, low, high)
    off_ground = None
    if ground is not None:
        yield Progress(1.0, "Outlining the ground")
        if isinstance(ground, np.ndarray):
            ground = Piece(Shape(ground), np.eye(4))
        off_ground = ~(samples_inside(ground.triangles(), grid) if memory is None else memory.ground(grid, ground))
        blocked |= off_ground
    return Environment(grid, blocked, rasterise_regions(regions, grid), off_ground)


def _blocked(grid: Grid, triangles: np.ndarray, radius: float, low: float, high: float) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples nearer than ``radius`` (m) to what lies between the heights, or inside of it."""
    blocked = samples_within(grid, clip_to_heights(triangles, low, high), radius)
    for (first, last), solid in solid_strips(grid, triangles, low, high):
        blocked[first:last] |= solid
    return blocked
