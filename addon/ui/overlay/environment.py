"""The environment in the viewport: ground, what is blocked, regions, and the size of the character."""

from typing import Any

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from ...live.environment import EnvironmentView, environment_view, keep_looking
from ...live.sight import sidebar_is_drawn, viewport_is_drawn
from ...render.environment_lines import Lines, body_lines

_WIDTH = 2.0
"""Pixels at the interface's usual size."""

_batches: dict[int, tuple[EnvironmentView, list]] = {}


def notice_sidebar() -> None:
    """Draws nothing: the sidebar has been drawn, and may show the panel or not show it any more."""
    sidebar_is_drawn(bpy.context)


def draw_environment() -> None:
    context = bpy.context
    scene, region = context.scene, context.region
    if not viewport_is_drawn(context):
        return
    keep_looking()
    view, settings = environment_view(scene), scene.wayfarer
    if scene.session_uid not in _batches or _batches[scene.session_uid][0] is not view:
        _batches.clear()
        _batches[scene.session_uid] = view, [line_batch(lines) for lines in view.lines]
    cursor = scene.cursor.location
    heading = settings.map.heading if settings.map.use_heading else None
    body = body_lines(cursor.x, cursor.y, view.ground_height, settings.environment.radius, heading)
    batches = [*_batches[scene.session_uid][1], line_batch(body)]
    draw_lines(batches, (region.width, region.height), context.preferences.system.ui_scale)


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
