"""The environment in the viewport: ground, what is blocked, regions, and the size of the character."""

from dataclasses import dataclass, field
from typing import Any

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from ...live.environment import EnvironmentView, environment_view, is_in_sight, look_soon
from ...render.environment_lines import Lines, body_lines
from ...session import SESSION

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
