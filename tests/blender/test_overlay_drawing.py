"""What is drawn over the viewport, pixel by pixel: a render engine has what a window would bring, a GPU's context."""

from typing import ClassVar

import bpy
import gpu
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.live import environment as environment_view
from bl_ext.user_default.wayfarer.addon.render.environment_lines import BLOCKED, BODY, GROUND, RULES, body_lines
from bl_ext.user_default.wayfarer.addon.render.screen_box import BoxTheme, draw_box
from bl_ext.user_default.wayfarer.addon.ui.overlay import draw_lines, legend_box, line_batch
from bl_ext.user_default.wayfarer.core.environment.regions import RegionRule
from bl_ext.user_default.wayfarer.core.maps.legend import ColorBar, MapLegend, Swatch

LEGEND = MapLegend(
    title="Variability",
    unit="ways",
    bar=ColorBar(((0.1, 0.1, 0.1), (0.9, 0.9, 0.9)), ((0.0, "1"), (1.0, "4.3 M"))),
    swatches=(Swatch((0.5, 0.1, 0.1), "Cannot Go Here"), Swatch((0.0, 0.2, 0.6), "Too Near an Obstacle")),
)


class Canvas(bpy.types.RenderEngine):
    """What it is asked to ``paint`` on an empty picture of ``size`` pixels under the matrix ``view``, as ``pixels``."""

    bl_idname = "WAYFARER_TEST_CANVAS"
    bl_label = "Canvas"
    bl_use_gpu_context = True

    asked: ClassVar[dict] = {}

    def render(self, depsgraph):
        asked = Canvas.asked
        width, height = asked["size"]
        try:
            picture = gpu.types.GPUOffScreen(width, height)
            with picture.bind(), gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                gpu.matrix.load_identity()
                gpu.matrix.load_projection_matrix(asked["view"])
                buffer = gpu.state.active_framebuffer_get()
                buffer.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
                asked["paint"]()
                read = buffer.read_color(0, 0, width, height, 4, 0, "FLOAT")
            read.dimensions = width * height * 4
            asked["pixels"] = np.array(read, dtype=np.float32).reshape(height, width, 4)
            picture.free()
        except Exception as error:  # Blender would only print it
            asked["error"] = error


def scaled(low, high) -> Matrix:
    """What lies between two corners (x, y) fills the picture."""
    (left, bottom), (right, top) = low, high
    matrix = Matrix.Diagonal((2 / (right - left), 2 / (top - bottom), -0.01, 1.0))
    matrix[0][3], matrix[1][3] = -(right + left) / (right - left), -(top + bottom) / (top - bottom)
    return matrix


@pytest.fixture
def drawn():
    """paint, lower and upper corner, size -> (height, width, 4) sRGB pixels from the bottom up."""
    bpy.utils.register_class(Canvas)

    def pixels(paint, low, high, size):
        Canvas.asked = asked = {"paint": paint, "view": scaled(low, high), "size": size}
        scene, render = bpy.context.scene, bpy.context.scene.render
        scene.camera = scene.camera or bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        render.engine = Canvas.bl_idname
        render.resolution_x = render.resolution_y = 8
        bpy.ops.render.render()
        if "error" in asked:
            raise asked["error"]
        return asked["pixels"]

    yield pixels
    bpy.utils.unregister_class(Canvas)


def test_a_legend_shows_what_it_was_given(drawn):
    box, theme = legend_box(LEGEND, 1.0), BoxTheme.of(bpy.context.preferences)
    size = round(box.width) + 20, round(box.height) + 20
    picture = drawn(lambda: draw_box(box, 10, 10, theme), (0, 0), size, size)

    def at(x, y):
        return picture[int(10 + y), int(10 + x), :3]

    np.testing.assert_array_equal(picture[:8], 0)
    np.testing.assert_allclose(at(3, box.height / 2), np.array(theme.background[:3]) * theme.background[3], atol=0.02)
    bar, *swatches = box.patches
    middle = bar.y + bar.height / 2
    for share in (0.02, 0.5, 0.98):
        expected = (1 - share) * np.array(bar.left) + share * np.array(bar.right)
        np.testing.assert_allclose(at(bar.x + share * bar.width, middle), expected, atol=0.03)
    for patch, swatch in zip(swatches, LEGEND.swatches, strict=True):
        np.testing.assert_allclose(at(patch.x + 5, patch.y + 5), swatch.color, atol=0.01)
    # Letters, each beside the place where it starts.
    for text in box.texts:
        x, y = int(10 + text.x), int(10 + text.y)
        letters = np.abs(picture[y : y + 8, x : x + 12, :3] - theme.background[:3]).max(axis=2)
        assert letters.max() > 0.3, text.text


def test_the_environment_is_drawn_in_its_place(drawn, sample_settings):
    scene = bpy.context.scene
    assert environment_view.look(scene, bpy.context.evaluated_depsgraph_get())
    view, radius, size = environment_view.environment_view(scene), sample_settings.environment.radius, (640, 720)
    lines = [*view.lines, body_lines(-2.0, -3.0, view.ground_height, radius, None)]
    picture = drawn(lambda: draw_lines([line_batch(found) for found in lines], size, 1.0), (-4, -4.5), (4, 4.5), size)

    def has(color, x, y):
        """Whether a line of the colour runs within three pixels of x, y in metres."""
        column, row = int((x + 4) * 80), int((y + 4.5) * 80)
        near = picture[max(row - 3, 0) : row + 4, max(column - 3, 0) : column + 4, :3].reshape(-1, 3)
        return bool((np.abs(near - np.array(color[:3]) * color[3]).max(axis=1) < 0.1).any())

    for x, y in ((-3.5, 0), (3.5, 1), (0, -4), (1, 4)):
        assert has(GROUND, x, y), (x, y)
    points = {found.color: found.points for found in lines}
    for color in (BLOCKED, RULES[RegionRule.REQUIRE]):
        for a, b in points[color].reshape(-1, 2, 3)[::5]:
            assert has(color, *((a + b) / 2)[:2]), color
    for angle in np.linspace(0, 6, 9):
        assert has(BODY, -2 + radius * np.cos(angle), -3 + radius * np.sin(angle))
    assert not has(GROUND, 2, 2) and picture[..., 3].mean() < 0.2
