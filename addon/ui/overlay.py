"""The legend of the map and the environment, drawn over the 3D viewport.

Draw handlers run at every redraw: they compute nothing, hold no reference to Blender's data, and never raise.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from ...core.maps.legend import MapLegend
from ..live.environment import EnvironmentView, environment_view, is_in_sight, look_soon
from ..render.environment_lines import Lines, body_lines
from ..render.floor import find_floor, floor_legend
from ..render.screen_box import Box, BoxTheme, draw_box, guarded, text_width
from ..results.shown import find_painted
from ..results.staleness import map_is_stale
from ..results.store import has_pending
from ..session import SESSION

_BAR_WIDTH = 150.0
_SWATCH = 11.0
_FROM_EDGE = 14.0
"""Pixels at the interface's usual size."""


def legend_box(legend: MapLegend, scale: float, stale: bool = False) -> Box:
    """Lay out the legend; ``stale`` if the scene has changed since the floor was painted."""
    box = Box(scale)
    box.text(legend.title, size=1.15)
    if stale:
        box.text("Out of date", warning=True)
    if legend.bar is not None:
        box.gap(0.15)
        width, height = _BAR_WIDTH * scale, 12.0 * scale
        stops = legend.bar.stops
        for k, (left, right) in enumerate(pairwise(stops)):
            piece = width / (len(stops) - 1)
            box.patch(k * piece, piece, height, left, right)
        box.gap(1.0)
        for at, text in legend.bar.ticks:
            # In the middle under its place, but never over the ends of the bar.
            wide = text_width(text, 11.0 * 0.9 * scale)
            box.text_at(text, min(max(at * width - wide / 2, 0.0), width - wide), 0.9, faint=True)
        if legend.unit:
            box.text_at(legend.unit, width + 8.0 * scale, 0.9, faint=True)
        box.gap(1.0)
    if legend.swatches:
        box.gap(0.2)
    values = max((text_width(s.value, 11.0 * scale) for s in legend.swatches), default=0.0)
    names = max((text_width(s.text, 11.0 * scale) for s in legend.swatches), default=0.0)
    for entry in legend.swatches:
        box.patch(0.0, _SWATCH * scale, _SWATCH * scale, entry.color, framed=True)
        start = (_SWATCH + 7.0) * scale
        if entry.value:
            end = start + names + 12.0 * scale + values
            box.text_at(entry.value, end - text_width(entry.value, 11.0 * scale), faint=True)
        box.text(entry.text, start)
    return box.done()


def is_outdated(scene) -> bool:
    """Return True if the painted floor shows something else than it should, or nobody knows what it shows."""
    # Results that were saved are not read for this: they are as soon as fingerprints have been taken.
    return not has_pending(scene) and (find_painted(scene) is None or map_is_stale(scene))


def draw_legend() -> None:
    context = bpy.context
    scene, space, region = context.scene, context.space_data, context.region
    if scene is None or not space.overlay.show_overlays or not scene.wayfarer.overlay.show_legend:
        return
    floor = find_floor(scene)
    if floor is None or not floor.visible_get():
        return
    legend = floor_legend(floor)
    if legend is None:
        return
    scale = context.preferences.system.ui_scale
    box = legend_box(legend, scale, is_outdated(scene))
    edge = _FROM_EDGE * scale
    left = region.width - _covered(context.area, "UI") - box.width - edge
    low = edge + _redo_height(context.area, region, left)
    if left < 0 or low + box.height + edge > region.height:
        return
    draw_box(box, left, low, BoxTheme.of(context.preferences))


def _redo_height(area, region, left: float) -> float:
    """Pixels at the lower edge that the panel of the last operation takes up, if it reaches as far as ``left``."""
    for other in area.regions:
        if other.type == "HUD" and other.width > 1 and other.x - region.x + other.width > left:
            return float(other.y - region.y + other.height)
    return 0.0


def _covered(area, kind: str) -> float:
    """Pixels of the viewport that lie under its sidebar."""
    if not bpy.context.preferences.system.use_region_overlap:
        return 0.0
    return next((region.width for region in area.regions if region.type == kind and region.width > 1), 0.0)


_WIDTH = 2.0
"""Pixels at the interface's usual size."""


@dataclass
class _Drawn:
    """The view of a scene that was drawn last, as the GPU keeps it."""

    view: EnvironmentView | None = None
    batches: list[tuple] = field(default_factory=list)


def draw_environment() -> None:
    context = bpy.context
    scene, region = context.scene, context.region
    if not is_in_sight(scene, context.area):
        return
    look_soon()
    view, settings = environment_view(scene), scene.wayfarer
    drawn = SESSION.of(scene, _Drawn)
    if drawn.view is not view:
        drawn.view, drawn.batches = view, [line_batch(lines) for lines in view.lines]
    cursor = scene.cursor.location
    heading = settings.map.heading if settings.map.use_heading else None
    body = body_lines(cursor.x, cursor.y, view.ground_height, settings.environment.radius, heading)
    draw_lines([*drawn.batches, line_batch(body)], (region.width, region.height), context.preferences.system.ui_scale)


def line_batch(lines: Lines) -> tuple:
    """Lines as the GPU keeps them, and their colour."""
    points: Any = lines.points  # arrays are buffers; NumPy 1 cannot say so
    return batch_for_shader(_shader(), "LINES", {"pos": points}), lines.color


def draw_lines(batches: list[tuple], size: tuple[int, int], scale: float) -> None:
    """Draw batches in a region of ``size`` pixels, where its matrices put them, with an interface of this scale."""
    shader = _shader()
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    try:
        shader.uniform_float("viewportSize", size)
        shader.uniform_float("lineWidth", _WIDTH * scale)
        for batch, color in batches:
            shader.uniform_float("color", color)
            batch.draw(shader)
    finally:
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def _shader():
    return gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")


_handles = []


def register():
    # Without a window nothing is drawn, and there is nothing to draw with.
    if bpy.app.background:
        return
    for draw, region, moment in (
        (draw_legend, "WINDOW", "POST_PIXEL"),
        (draw_environment, "WINDOW", "POST_VIEW"),
    ):
        handle = bpy.types.SpaceView3D.draw_handler_add(guarded(draw), (), region, moment)
        _handles.append((handle, region))


def unregister():
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(*_handles.pop())
