"""The core's drawings as pixels, for Blender's Image Editor: lines by NumPy, texts by Blender's own fonts."""

import os
import tempfile
from dataclasses import replace
from itertools import pairwise
from typing import Any

import blf
import bpy
import imbuf
import numpy as np

from ...core.report.drawing import PAPER, Anchor, Box, Drawing, Label, Line, Picture

_FONT = 0
_OVERSAMPLED = 2
"""Pixels of the image per pixel of the drawing, each way: as sharp as a high-resolution screen shows."""


def rasterize(drawing: Drawing) -> np.ndarray:
    """(rows, columns, 4) float32 sRGB pixels of a drawing, the lowest row first, as Blender's images have them."""
    scale = _OVERSAMPLED
    pixels = np.empty((drawing.height * scale, drawing.width * scale, 3), dtype=np.float32)
    pixels[:] = PAPER
    for mark in drawing.marks:
        if isinstance(mark, Box):
            _fill(pixels, mark.x * scale, mark.y * scale, mark.width * scale, mark.height * scale, mark.color)
        elif isinstance(mark, Line):
            points = np.asarray(mark.points, dtype=float) * scale
            for a, b in pairwise(points):
                _stroke(pixels, a, b, mark.width * scale, mark.color)
        elif isinstance(mark, Picture):
            _place(pixels, mark, scale)
    labels = [mark for mark in drawing.marks if isinstance(mark, Label)]
    _write(pixels, [label for label in labels if not label.upright], upright=False)
    _write(pixels, [label for label in labels if label.upright], upright=True)
    return np.concatenate([pixels[::-1], np.ones((*pixels.shape[:2], 1), dtype=np.float32)], axis=2)


def show_image(name: str, drawing: Drawing):
    """:func:`put_in_image` of the drawing."""
    return put_in_image(name, rasterize(drawing))


def put_in_image(name: str, pixels: np.ndarray) -> bpy.types.Image:
    """The image datablock of this name, made or made anew, with (rows, columns, 4) sRGB pixels, the lowest row first;
    packed, so that it is saved with the file.
    """
    rows, columns, _ = pixels.shape
    # One that is linked from another file would be that file's again on reopening.
    image = bpy.data.images.get((name, None))
    if image is None:
        image = bpy.data.images.new(name, columns, rows)
    elif tuple(image.size) != (columns, rows):
        # Not a new one: editors may show this.
        image.scale(columns, rows)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, dtype=np.float32).ravel())
    image.update()
    image.pack()
    return image


def _fill(pixels, x: float, y: float, width: float, height: float, color) -> None:
    rows, columns = slice(round(y), max(round(y + height), round(y))), slice(round(x), max(round(x + width), round(x)))
    pixels[rows, columns] = color


def _stroke(pixels, a: np.ndarray, b: np.ndarray, width: float, color) -> None:
    """A line from a to b, its edges as soft as a pixel is wide."""
    reach = width / 2 + 1
    low = np.maximum(np.floor(np.minimum(a, b) - reach).astype(int), 0)
    high = np.minimum(np.ceil(np.maximum(a, b) + reach).astype(int) + 1, pixels.shape[1::-1])
    if (high <= low).any():
        return
    y, x = np.mgrid[low[1] : high[1], low[0] : high[0]]
    places = np.stack([x, y], axis=-1) + 0.5 - a
    along = b - a
    share = np.clip(places @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    distance = np.linalg.norm(places - share[..., None] * along, axis=-1)
    cover = np.clip(width / 2 + 0.5 - distance, 0.0, 1.0)[..., None]
    part = pixels[low[1] : high[1], low[0] : high[0]]
    part[:] = part * (1 - cover) + np.asarray(color) * cover


def _place(pixels, picture: Picture, scale: int) -> None:
    rows, columns, _ = picture.pixels.shape
    width, height = round(picture.width * scale), round(picture.height * scale)
    x, y = round(picture.x * scale), round(picture.y * scale)
    row = np.arange(height) * rows // height
    column = np.arange(width) * columns // width
    pixels[y : y + height, x : x + width] = picture.pixels[row[:, None], column] / np.float32(255)


def _write(pixels: np.ndarray, labels: list[Label], upright: bool) -> None:
    """Write labels, all of them upright or none."""
    if not labels:
        return
    if upright:
        # A sheet lying on its side: x runs up, y to the right.
        turned = np.rot90(pixels, -1)
        width = pixels.shape[0] / _OVERSAMPLED
        _write(turned, [replace(label, x=width - label.y, y=label.x, upright=False) for label in labels], False)
        return
    rows, columns, _ = pixels.shape
    buffer = imbuf.new((columns, rows))
    inks = np.zeros((rows, columns, 3), dtype=np.float32)
    drawing: Any = blf.bind_imbuf(_FONT, buffer)  # the stubs have it return nothing
    with drawing:
        blf.color(_FONT, 1.0, 1.0, 1.0, 1.0)
        for label in labels:
            blf.size(_FONT, label.size * _OVERSAMPLED)
            width, _ = blf.dimensions(_FONT, label.text)
            before = {Anchor.START: 0.0, Anchor.MIDDLE: width / 2, Anchor.END: width}[label.anchor]
            x, y = label.x * _OVERSAMPLED - before, label.y * _OVERSAMPLED
            # Twice, a pixel apart: Blender's font has no bold face.
            for offset in (0, 1) if label.bold else (0,):
                blf.position(_FONT, x + offset, rows - y, 0)
                blf.draw_buffer(_FONT, label.text)
            size = label.size * _OVERSAMPLED
            top, bottom = max(round(y - size), 0), max(round(y + 0.4 * size), 0)
            inks[top:bottom, max(round(x) - 2, 0) : max(round(x + width) + 4, 0)] = label.color
    cover = _red(buffer)[::-1, :, None]
    pixels[:] = pixels * (1 - cover) + inks * cover


def _red(buffer) -> np.ndarray:
    """(rows, columns) red of an image buffer, whose pixels Python can only get at through a file before 5.2."""
    columns, rows = buffer.size
    with tempfile.TemporaryDirectory(prefix="wayfarer-") as folder:
        path = os.path.join(folder, "ink.png")
        imbuf.write(buffer, filepath=path)
        image = bpy.data.images.load(path)
        try:
            colorspace: Any = image.colorspace_settings
            colorspace.name = "Non-Color"
            pixels = np.empty(rows * columns * 4, dtype=np.float32)
            image.pixels.foreach_get(pixels)
        finally:
            bpy.data.images.remove(image)
    return pixels.reshape(rows, columns, 4)[:, :, 0]
