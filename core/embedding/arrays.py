"""The fields of an embedding as plain arrays and a header, and back to the last bit.

The one-step links are stored too, though they follow from the rest: another processor may round a cosine differently,
and a walk must find the links that the nodes were made with.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..archive import ArchiveFormat, require
from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION, Grid
from ..environment.regions import RegionMask, RegionRule
from ..errors import EmbeddingError
from ..motion.graph import MotionGraph
from ..motion.graph_archive import graph_from_arrays, graph_to_arrays
from .bitplane import PlaneLayout
from .footprint import FootprintRule, FootprintSettings
from .settings import EmbeddingSettings
from .stencil import Stencils
from .sweep import Sweep
from .unroll import Unrolling

EMBEDDING_FORMAT = ArchiveFormat("embedding", 2, EmbeddingError)

#: Graph, environment, settings, unrolling, planes and second bound, as an Embedding takes them.
EmbeddingFields = tuple[MotionGraph, Environment, EmbeddingSettings, Unrolling, tuple[int, ...], int | None]

#: Planes read from a file take at most this much memory, whatever layout the file asks for.
_MAX_PLANE_BYTES = 4e9


def fields_to_arrays(
    graph: MotionGraph,
    environment: Environment,
    settings: EmbeddingSettings,
    unrolling: Unrolling,
    planes: Sequence[int],
    second_bound: int | None,
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return all fields of an embedding: what JSON can hold, and arrays by name."""
    graph_content, graph_arrays = graph_to_arrays(graph)
    grid, sweep, stencils, layout = environment.grid, unrolling.sweep, unrolling.stencils, unrolling.layout
    content = {
        "graph": graph_content,
        "grid": {
            "shape": [int(n) for n in grid.shape],
            "cell_size": float(grid.cell_size),
            "origin": [float(x) for x in grid.origin],
            "tiled": bool(grid.tiled),
        },
        "regions": [[region.name, region.rule.value, region.tag] for region in environment.regions],
        "settings": {
            "footprint": {**asdict(settings.footprint), "rule": settings.footprint.rule.value},
            "memory_limit": float(settings.memory_limit),
        },
        "reach": [layout.reach_x, layout.reach_y],
        "classes": [sorted(tags) for tags in sweep.classes],
        "second_bound": second_bound,
    }
    arrays = {
        **{f"graph_{name}": array for name, array in graph_arrays.items()},
        "blocked": environment.blocked,
        "region_masks": np.array([region.mask for region in environment.regions], dtype=bool),
        "stencil_segment": np.asarray(stencils.segment, dtype=np.int64),
        "stencil_heading": np.asarray(stencils.heading, dtype=np.int64),
        "stencil_dx": np.asarray(stencils.dx, dtype=np.int64),
        "stencil_dy": np.asarray(stencils.dy, dtype=np.int64),
        "stencil_turn": np.asarray(stencils.turn, dtype=np.int64),
        "stencil_position_error": stencils.position_error,
        "stencil_heading_error": stencils.heading_error,
        "sweep_path": np.array(sweep.path, dtype=np.int64),
        "sweep_bounds": np.array(sweep.bounds, dtype=np.int64),
        "sweep_tag_class": np.array(sweep.tag_class, dtype=np.int64),
        "sweep_part": np.array(sweep.part, dtype=np.int64),
        "sweep_shift": np.array(sweep.shift, dtype=np.int64),
        "valid": _plane_bytes(unrolling.valid, layout),
        "planes": _plane_bytes(planes, layout),
    }
    if environment.off_ground is not None:
        arrays["off_ground"] = environment.off_ground
    return content, arrays


def fields_from_arrays(content: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> EmbeddingFields:
    """Return the fields of :func:`fields_to_arrays`; ValueError or another exception if they do not fit together."""
    graph = graph_from_arrays(
        content["graph"],
        {name.removeprefix("graph_"): array for name, array in arrays.items() if name.startswith("graph_")},
    )
    given = content["grid"]
    nx, ny, n_headings = map(int, given["shape"])
    x, y = map(float, given["origin"])
    grid = Grid((nx, ny, n_headings), float(given["cell_size"]), (x, y), bool(given["tiled"]))
    masks = arrays["region_masks"]
    require(len(masks) == len(content["regions"]))
    regions = [
        RegionMask(name, RegionRule(rule), tag, mask)
        for (name, rule, tag), mask in zip(content["regions"], masks, strict=True)
    ]
    environment = Environment(grid, arrays["blocked"], tuple(regions), arrays.get("off_ground"))
    footprint = dict(content["settings"]["footprint"])
    footprint["rule"] = FootprintRule(footprint["rule"])
    settings = EmbeddingSettings(FootprintSettings(**footprint), float(content["settings"]["memory_limit"]))

    sweep = _sweep(content, arrays, grid, len(graph.segments))
    unrolling = Unrolling(sweep, _planes(arrays["valid"], len(sweep.stencils), sweep.layout))
    planes = _planes(arrays["planes"], len(graph.segments) * n_headings, sweep.layout)
    second_bound = content["second_bound"]
    require(second_bound is None or (isinstance(second_bound, int) and second_bound >= 0))
    return graph, environment, settings, unrolling, planes, second_bound


def _sweep(content: Mapping[str, Any], arrays: Mapping[str, np.ndarray], grid: Grid, n_segments: int) -> Sweep:
    whole = ("stencil_segment", "stencil_heading", "stencil_dx", "stencil_dy", "stencil_turn")
    whole += ("sweep_path", "sweep_bounds", "sweep_tag_class", "sweep_part", "sweep_shift")
    require(all(arrays[name].dtype == np.int64 for name in whole))
    nx, ny, n_headings = grid.shape
    stencils = Stencils(
        segment=arrays["stencil_segment"],
        heading=arrays["stencil_heading"],
        dx=arrays["stencil_dx"],
        dy=arrays["stencil_dy"],
        turn=arrays["stencil_turn"],
        position_error=arrays["stencil_position_error"],
        heading_error=arrays["stencil_heading_error"],
        n_headings=n_headings,
    )
    n_stencils = len(stencils)
    of_stencil = (stencils.heading, stencils.dx, stencils.dy, stencils.turn, stencils.heading_error)
    require(all(array.shape == (n_stencils,) for array in (stencils.segment, *of_stencil)))
    require(stencils.position_error.shape == (n_stencils, 2))
    start = stencils.segment * n_headings + stencils.heading
    require(np.all((stencils.heading >= 0) & (stencils.heading < n_headings)))
    require(np.all((stencils.segment >= 0) & (stencils.segment < n_segments)) and np.all(np.diff(start) >= 0))

    classes = tuple(frozenset(map(str, tags)) for tags in content["classes"])
    reach_x, reach_y = map(int, content["reach"])
    layout = PlaneLayout(nx, ny, reach_x, reach_y, grid.tiled)
    require(reach_x >= 0 and reach_y >= 0)
    require(_are_within(stencils.dx, reach_x) and _are_within(stencils.dy, reach_y))
    require(n_segments > 0)
    require(layout.n_bits / 8 * (n_stencils + n_segments * n_headings) <= _MAX_PLANE_BYTES)
    path, bounds = arrays["sweep_path"], arrays["sweep_bounds"]
    tag_class, part, shift = arrays["sweep_tag_class"], arrays["sweep_part"], arrays["sweep_shift"]
    n_checks = len(part)
    require(tag_class.shape == shift.shape == (n_checks,) and path.shape == (n_stencils,))
    require(np.all((path >= 0) & (path < len(bounds) - 1)))
    require(len(bounds) and bounds[0] == 0 and bounds[-1] == n_checks and np.all(np.diff(bounds) >= 0))
    require(np.all((tag_class >= 0) & (tag_class < len(classes))))
    require(np.all((part > 0) & (part < 1 << SUBDIVISION**2)))
    require(_are_within(shift, layout.shift(reach_x, reach_y)))
    return Sweep(
        stencils=stencils,
        layout=layout,
        classes=classes,
        path=path.tolist(),
        bounds=bounds.tolist(),
        tag_class=tag_class.tolist(),
        part=part.tolist(),
        shift=shift.tolist(),
    )


def _are_within(values: np.ndarray, reach: int) -> bool:
    # The smallest integer is its own absolute value.
    return bool(np.all((values >= -reach) & (values <= reach)))


def _plane_bytes(planes: Sequence[int], layout: PlaneLayout) -> np.ndarray:
    """Return (n, bytes of a plane) uint8: the bits of each plane, lowest first."""
    size = (layout.n_bits + 7) // 8
    raw = b"".join([plane.to_bytes(size, "little") for plane in planes])
    return np.frombuffer(raw, dtype=np.uint8).reshape(-1, size)


def _planes(rows: np.ndarray, n_planes: int, layout: PlaneLayout) -> tuple[int, ...]:
    require(rows.dtype == np.uint8 and rows.shape == (n_planes, (layout.n_bits + 7) // 8))
    planes = tuple(int.from_bytes(row.tobytes(), "little") for row in rows)
    require(all(plane & layout.ground == plane for plane in planes))
    return planes
