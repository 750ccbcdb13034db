"""Legends of painted floors: kept with the floor, shown in the panel and in the viewport."""

import json
from dataclasses import asdict, dataclass

from ..files import from_json
from .scales import Color


@dataclass(frozen=True)
class ColorBar:
    """A scale from the least to the most.

    Attributes
    ----------
    stops : tuple of sRGB colours, evenly spaced
    ticks : tuple of (position from 0 to 1, text)
    """

    stops: tuple[Color, ...]
    ticks: tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class Swatch:
    """A single colour (sRGB), what it stands for, and how much of it there is ("12%"; empty if nobody counted)."""

    color: Color
    text: str
    value: str = ""


@dataclass(frozen=True)
class MapLegend:
    """The legend of a painted floor.

    Attributes
    ----------
    title : str
    unit : str
        Of what the bar shows; empty if it has none.
    bar : ColorBar or None
    swatches : tuple of Swatch
    numbers : tuple of (name, text)
        What else there is to say, for the panel.
    """

    title: str
    unit: str = ""
    bar: ColorBar | None = None
    swatches: tuple[Swatch, ...] = ()
    numbers: tuple[tuple[str, str], ...] = ()

    def to_json(self) -> str:
        """Return the legend as text, to be kept with an object."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> "MapLegend":
        """Read the text of :meth:`to_json`; ValueError, LookupError, TypeError or ArithmeticError for anything else."""
        read = from_json(text)
        bar = read["bar"]
        return cls(
            title=str(read["title"]),
            unit=str(read["unit"]),
            bar=bar
            and ColorBar(
                tuple(_color(stop) for stop in bar["stops"]),
                tuple((float(at), str(text)) for at, text in bar["ticks"]),
            ),
            swatches=tuple(Swatch(_color(s["color"]), str(s["text"]), str(s["value"])) for s in read["swatches"]),
            numbers=tuple((str(name), str(value)) for name, value in read["numbers"]),
        )


def _color(values) -> Color:
    red, green, blue = (float(value) for value in values)
    return red, green, blue
