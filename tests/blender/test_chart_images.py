"""Charts of the core as images of Blender."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.render.raster import rasterize, show_image
from bl_ext.user_default.wayfarer.core.report.chart import Series, line_chart
from bl_ext.user_default.wayfarer.core.report.drawing import Anchor, Box, Drawing, Label, Line, Picture

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def ink_box(pixels):
    """Left, top, right, bottom of what is not white, in the drawing's pixels from the top left."""
    rows, columns = np.nonzero((pixels[::-1, :, :3] < 0.7).any(axis=2))
    return columns.min() / 2, rows.min() / 2, (columns.max() + 1) / 2, (rows.max() + 1) / 2


def test_marks_are_where_they_belong():
    picture = Picture(60, 10, 20, 20, np.array([[[255, 0, 0], [0, 0, 255]]], dtype=np.uint8))
    drawing = Drawing(100, 50, (Box(10, 5, 20, 10, RED), Line(np.array([[10, 40], [50, 40]]), BLUE, 4.0), picture))
    pixels = rasterize(drawing)[::-1]
    assert pixels.shape == (100, 200, 4) and np.all(pixels[..., 3] == 1)
    assert np.all(pixels[10:30, 20:60, :3] == RED) and np.all(pixels[9, 20:60, :3] == 1)
    assert np.allclose(pixels[79:81, 24:96, :3], BLUE) and np.all(pixels[70, 24:96, :3] == 1)
    assert np.all(pixels[20:60, 120:140, :3] == RED) and np.all(pixels[20:60, 140:160, :3] == BLUE)


@pytest.mark.parametrize("anchor", Anchor)
def test_texts_are_anchored(anchor):
    left, top, right, bottom = ink_box(rasterize(Drawing(200, 60, (Label(100, 40, "HHHH", 20, anchor=anchor),))))
    place = {Anchor.START: left, Anchor.MIDDLE: (left + right) / 2, Anchor.END: right}[anchor]
    assert abs(place - 100) < 3 and abs(bottom - 40) < 1.5 and 10 < bottom - top < 20
    # Upright, the same text runs upwards from its place.
    box = ink_box(rasterize(Drawing(60, 200, (Label(40, 100, "HHHH", 20, anchor=anchor, upright=True),))))
    place = {Anchor.START: box[3], Anchor.MIDDLE: (box[1] + box[3]) / 2, Anchor.END: box[1]}[anchor]
    assert abs(place - 100) < 3 and abs(box[2] - 40) < 1.5 and abs((box[3] - box[1]) - (right - left)) < 2


def test_texts_have_their_colour():
    pixels = rasterize(Drawing(80, 30, (Label(5, 20, "HHH", 16, RED),)))
    darkest = pixels[np.unravel_index(pixels[..., 1].argmin(), pixels.shape[:2])]
    assert np.allclose(darkest[:3], RED, atol=0.02)


def test_an_image_is_made_once_and_follows_its_chart():
    curve = [Series("a", np.arange(4), np.arange(4) ** 2)]
    first = show_image("Wayfarer Chart", line_chart("One", "k", "n", curve))
    size, n_images = tuple(first.size), len(bpy.data.images)
    again = show_image("Wayfarer Chart", line_chart("Two", "k", "n", curve, width=300))
    assert again == first and len(bpy.data.images) == n_images
    assert tuple(first.size) == (600, size[1]) and first.packed_file is not None
