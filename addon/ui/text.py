"""Sentences in panels: Blender's labels do not wrap."""

import blf

_FONT, _POINTS = 0, 11
_FALLBACK_WIDTH = 260
"""Pixels, where there is no region to draw in."""


def draw_wrapped(context, layout, text: str, margin: float = 70.0) -> None:
    """Draw ``text`` on as many lines as the region's width asks for, ``margin`` (units of 1x) being taken up."""
    scale = context.preferences.system.ui_scale
    width = context.region.width if context.region else _FALLBACK_WIDTH
    column = layout.column(align=True)
    column.scale_y = 0.75
    for line in wrapped(text, max(width - margin * scale, 80 * scale), _POINTS * scale):
        column.label(text=line, translate=False)


def wrapped(text: str, width: float, points: float) -> list[str]:
    """The text in lines no wider than ``width`` pixels; a single word may be."""
    blf.size(_FONT, points)
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and blf.dimensions(_FONT, longer)[0] <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
