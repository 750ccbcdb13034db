"""The geometry of a scene: shapes, not masks, because radius and cell size are settings of a study."""

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from ..archive import ArchiveFormat, archive_from_bytes, archive_to_bytes, load_archive, require, save_archive
from ..embedding.footprint import FootprintRule, FootprintSettings
from ..environment.environment import Environment, EnvironmentSettings, build_environment
from ..environment.grid import Grid
from ..environment.regions import Region, RegionRule
from ..errors import StudyError
from .settings import Value

SCENE_FORMAT = ArchiveFormat("scene", 2, StudyError)


@dataclass(frozen=True)
class SceneGeometry:
    """Obstacles and regions of a scene, and its settings when it was read.

    Attributes
    ----------
    obstacles : (T, 3, 3) float array
        World-space triangles in metres.
    low, high : (x, y)
        Corners of the ground rectangle in metres.
    ground : (T, 3, 3) float array, optional
        World-space triangles of what can be stood on, seen from above; by default the whole rectangle.
    regions : tuple of Region
    body : EnvironmentSettings
    footprint : FootprintSettings
    cell_size : float
        Metres.
    n_headings : int
    tiled : bool
    """

    obstacles: np.ndarray
    low: tuple[float, float]
    high: tuple[float, float]
    regions: tuple[Region, ...] = ()
    body: EnvironmentSettings = field(default_factory=EnvironmentSettings)
    footprint: FootprintSettings = field(default_factory=FootprintSettings)
    cell_size: float = 0.1
    n_headings: int = 24
    tiled: bool = False
    ground: np.ndarray | None = None


def grid_of(geometry: SceneGeometry, values: Mapping[str, Value]) -> Grid:
    """Lay a grid over a scene; settings that are not named are those of the scene.

    Raises SceneError if none fits.
    """
    own = {"cell_size": geometry.cell_size, "n_headings": geometry.n_headings, "tiled": geometry.tiled}
    cell_size, n_headings, tiled = (values.get(name, own[name]) for name in own)
    return Grid.over_rectangle(geometry.low, geometry.high, float(cell_size), int(n_headings), bool(tiled))


def environment_of(geometry: SceneGeometry, values: Mapping[str, Value]) -> Environment:
    """Build the environment of a scene; settings that are not named are those of the scene.

    Raises SceneError if they make none.
    """
    given: dict[str, Any] = {n: values[n] for n in ("radius", "step_height", "head_height") if n in values}
    grid, body = grid_of(geometry, values), replace(geometry.body, **given)
    return build_environment(grid, geometry.obstacles, geometry.regions, body, ground=geometry.ground)


def scene_to_bytes(geometry: SceneGeometry) -> bytes:
    """Write the geometry to an .npz in memory; the same geometry always makes the same bytes."""
    content = {
        "low": [float(x) for x in geometry.low],
        "high": [float(x) for x in geometry.high],
        "regions": [
            [region.name, region.rule.value, region.tag, float(region.margin), len(region.triangles)]
            for region in geometry.regions
        ],
        "body": {name: float(value) for name, value in asdict(geometry.body).items()},
        "footprint": {**asdict(geometry.footprint), "rule": geometry.footprint.rule.value},
        "cell_size": float(geometry.cell_size),
        "n_headings": int(geometry.n_headings),
        "tiled": bool(geometry.tiled),
    }
    triangles = [np.empty((0, 3, 3)), *(np.asarray(r.triangles, dtype=float) for r in geometry.regions)]
    arrays = {
        "obstacles": np.asarray(geometry.obstacles, dtype=float).reshape(-1, 3, 3),
        "regions": np.concatenate(triangles),
    }
    if geometry.ground is not None:
        arrays["ground"] = np.asarray(geometry.ground, dtype=float).reshape(-1, 3, 3)
    return archive_to_bytes(SCENE_FORMAT, content, arrays)


def save_scene(geometry: SceneGeometry, path: str | os.PathLike) -> None:
    """Write the geometry to a file; StudyError if that cannot be done."""
    save_archive(path, scene_to_bytes(geometry), SCENE_FORMAT)


def load_scene(path: str | os.PathLike) -> SceneGeometry:
    """Read the geometry of :func:`save_scene`; StudyError names the file if it cannot be read."""
    return archive_from_bytes(SCENE_FORMAT, load_archive(path, SCENE_FORMAT), os.fspath(path), _scene)


def _scene(content: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> SceneGeometry:
    obstacles, joined, ground = arrays["obstacles"], arrays["regions"], arrays.get("ground")
    require(all(a.shape == (len(a), 3, 3) for a in (obstacles, joined, ground) if a is not None))
    regions, start = [], 0
    for name, rule, tag, margin, n_triangles in content["regions"]:
        require(0 <= n_triangles <= len(joined) - start)
        part = joined[start : start + n_triangles]
        regions.append(Region(str(name), RegionRule(rule), str(tag), part, float(margin)))
        start += n_triangles
    footprint = {**content["footprint"], "rule": FootprintRule(content["footprint"]["rule"])}
    (x0, y0), (x1, y1) = content["low"], content["high"]
    return SceneGeometry(
        obstacles=obstacles,
        low=(float(x0), float(y0)),
        high=(float(x1), float(y1)),
        regions=tuple(regions),
        body=EnvironmentSettings(**content["body"]),
        footprint=FootprintSettings(**footprint),
        cell_size=float(content["cell_size"]),
        n_headings=int(content["n_headings"]),
        tiled=bool(content["tiled"]),
        ground=ground,
    )
