"""The floor map as a picture, seen from above, with a legend."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy

from ...core.maps.colors import BLOCKED, OBSTACLE, RULED, STEP, UNREACHED, WALK
from .legend import Legend
from .picture_scene import opaque, picture_scene

_BACKGROUND = (0.065, 0.07, 0.08)
_PIXELS = 1200
"""Height of the picture."""


@dataclass(frozen=True)
class MapScene:
    """Contents of the pictures. Objects may be None; ``low`` and ``high`` are the ground's corners (x, y) in metres."""

    floor: bpy.types.Object
    obstacles: tuple
    regions: tuple
    walk: bpy.types.Object | None
    low: tuple[float, float]
    high: tuple[float, float]
    ground_height: float


def draw_map(path: Path, shown: MapScene, title: str, notes: list[str], highest: str, regions: str, walk: str) -> None:
    """Write ``path`` as PNG.

    ``notes`` are lines under the title, ``highest`` labels the light end of the scale, ``regions`` and ``walk``
    say what the regions ask for and what the green line is.
    """
    with picture_scene("Wayfarer Map Picture") as picture:
        scene = picture.scene
        scene.render.engine = "BLENDER_WORKBENCH"
        scene.render.film_transparent = False
        display: Any = scene.display
        display.render_aa, display.shading.light, display.shading.color_type = "16", "FLAT", "VERTEX"
        display.shading.show_object_outline = False
        display.shading.background_type = "VIEWPORT"
        display.shading.background_color = opaque(_BACKGROUND)[:3]
        scene.world = bpy.data.worlds.new("Wayfarer Picture")
        scene.world.color = opaque(_BACKGROUND)[:3]
        picture.show([shown.floor, *shown.obstacles, *shown.regions, shown.walk])

        width, depth = shown.high[0] - shown.low[0], shown.high[1] - shown.low[1]
        size = max(depth, 0.6 * width) / 30
        border, legend_width = 1.6 * size, 13.0 * size
        top = shown.ground_height + 100.0
        legend = Legend(picture, shown.high[0] + 2.2 * size, shown.high[1] - 0.6 * size, top - 1.0, size)
        legend.title(title)
        for note in notes:
            legend.note(note)
        legend.gap()
        legend.ramp("few ways", highest)
        legend.gap(0.6)
        legend.entry(UNREACHED, "cannot go here")
        legend.entry(BLOCKED, "too near an obstacle")
        legend.entry(OBSTACLE, "obstacle")
        if shown.regions:
            legend.entry(STEP, "region")
            legend.entry(RULED, regions)
        if shown.walk is not None:
            legend.entry(WALK, walk, thin=True)
        legend.gap(1.2)
        legend.scale_bar()

        camera = picture.camera()
        lens = cast(bpy.types.Camera, camera.data)
        lens.type, lens.clip_end = "ORTHO", 1000.0
        full_width, full_depth = width + legend_width + 2 * border, depth + 2 * border
        aspect = full_width / full_depth
        lens.ortho_scale = max(full_width, full_depth)
        camera.location = (
            shown.low[0] - border + full_width / 2,
            shown.low[1] - border + full_depth / 2,
            top,
        )
        picture.render(path, round(_PIXELS * aspect), _PIXELS)
