"""Numbers in words: what people read in panels, legends, charts, pages and on the command line looks the same
everywhere.

Files that programs read (CSV, JSON) hold plain numbers, and units in ASCII: "m2".
"""

import math


def counted(number: int, noun: str, plural: str = "") -> str:
    """ "1 clip", "1,200 clips"; ``plural`` for nouns that do not just take an s."""
    return f"{number:,} {noun if number == 1 else plural or f'{noun}s'}"


def short(value: float) -> str:
    """A number as short as it can be told, in three digits: "0.25", "847", "1.5 k", "44 M". Never with an exponent;
    "endless" and "-" for what is infinite and for no number."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "endless"
    for size, letter in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if abs(value) >= size * 0.9995:
            return f"{_digits(value / size)}{letter}"
    return _digits(value)


def _digits(value: float) -> str:
    if value == 0:
        return "0"
    places = max(2 - math.floor(math.log10(abs(value)) + 1e-12), 0)
    text = f"{value:,.{places}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def amount(value: float) -> str:
    """A measured number with all the digits that can matter: "0.62", "12.3", "1,640"."""
    size = abs(value)
    if size == 0 or size >= 99.95:
        return f"{value:,.0f}"
    return f"{value:,.{2 if size < 9.995 else 1}f}"


def area(square_metres: float) -> str:
    """ "0.62 m²", "12.3 m²", "1,640 m²"."""
    return f"{amount(square_metres)} m²"


def share(part: float) -> str:
    """A share from 0 to 1 as "61.3%": 0% and 100% only for nothing and all of it."""
    if math.isnan(part):
        return "-"
    if part in (0, 1):
        return f"{part:.0%}"
    if 0 < part < 0.0005:
        return "< 0.1%"
    return "> 99.9%" if 0.9995 <= part < 1 else f"{part:.1%}"


def share_of(part: float, whole: float) -> str:
    """The same of two numbers; a dash if the whole is nothing."""
    return share(part / whole) if whole else "-"


def time(seconds: float) -> str:
    """ "0.27 s", "3.4 s", "1,200 s"; "never" if it is endless."""
    if not math.isfinite(seconds):
        return "never"
    size = abs(seconds)
    return f"{seconds:,.{0 if size == 0 or size >= 99.95 else 1 if size >= 0.995 else 2}f} s"


def place(x: float, y: float) -> str:
    """A place on the ground (m): "(1.2, -0.3) m"."""
    # Not a minus before a zero.
    x, y = (round(value, 1) + 0.0 for value in (x, y))
    return f"({x:.1f}, {y:.1f}) m"
