"""Numbers in words: what people read in panels, legends, charts, pages and on the command line looks the same
everywhere. Lengths are in metres, angles come in radians and are told in degrees.

Files that programs read (CSV, JSON) hold plain numbers, and units in ASCII: "m2".
"""

import math

_ENDLESS = 1e15
"""No quantity of a scene comes near it; what does is a slip or damage, and is not told digit by digit."""

_LONGEST = 60
"""Characters of what somebody wrote that are repeated in a sentence."""


def number(count: int) -> str:
    """ "7", "1,200": all digits of what can be counted."""
    return f"{count:,}" if abs(count) < _ENDLESS else _exponent(count)


def of(part: int, whole: int) -> str:
    """ "3 of 1,200"."""
    return f"{number(part)} of {number(whole)}"


def counted(count: int, noun: str, plural: str = "") -> str:
    """ "1 clip", "1,200 clips"; ``plural`` for nouns that do not just take an s."""
    return f"{number(count)} {noun if count == 1 else plural or f'{noun}s'}"


def quoted(value: object) -> str:
    """A value that somebody wrote, as it was written if that is short: "'all'", "-1"; never longer than a line.

    >>> quoted("all"), len(quoted([10**30] * 9))
    ("'all'", 60)
    """
    if isinstance(value, int) and abs(value) >= 10**_LONGEST:
        return "a number of too many digits"
    if isinstance(value, str):
        value = value[: _LONGEST + 1]
    try:
        text = repr(value)
    except (ValueError, RecursionError):
        return "that"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def short(value: float) -> str:
    """A number as short as it can be told, in three digits: "0.25", "847", "1.5 k", "44 M". Never with an exponent;
    "endless" and "-" for what is infinite and for no number."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "endless"
    for size, letter in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if abs(value) >= size * 0.9995:
            return f"{_digits(value / size)}{letter}"
    return _digits(value)


def exact(value: float, digits: int = 6) -> str:
    """A number that somebody has set, as it was set: "0.125", "2", "1,500,000". Never with an exponent."""
    return _digits(value, digits) if math.isfinite(value) else short(value)


def rough(value: float) -> str:
    """A number in two digits, for what need not be told better: "1.5", "0.25", "15"."""
    return exact(value, 2)


def _digits(value: float, digits: int = 3) -> str:
    if value == 0:
        return "0"
    if abs(value) >= _ENDLESS:
        return _exponent(value)
    places = max(digits - 1 - math.floor(math.log10(abs(value)) + 1e-12), 0)
    text = f"{value:,.{places}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def amount(value: float) -> str:
    """A measured number with all the digits that can matter: "0.62", "12.3", "1,640"."""
    size = abs(value)
    if not math.isfinite(value):
        return short(value)
    return _rounded(value, 0 if size == 0 or size >= 99.95 else 1 if size >= 9.995 else 2)


def area(square_metres: float) -> str:
    """ "0.62 m²", "12.3 m²", "1,640 m²"."""
    return f"{amount(square_metres)} m²"


def length(metres: float) -> str:
    """ "0.62 m", "12.3 m", "1,640 m"."""
    return f"{amount(metres)} m"


def small(metres: float) -> str:
    """A length that people think of in centimetres: "0.62 cm", "12.3 cm"."""
    return f"{amount(100 * metres)} cm"


def speed(metres_per_second: float) -> str:
    """ "0.62 m/s", "12.3 m/s"."""
    return f"{amount(metres_per_second)} m/s"


def slide(metres_per_second: float) -> str:
    """The speed of a foot that should stand: "0.62 cm/s", "12.3 cm/s"."""
    return f"{small(metres_per_second)}/s"


def angle(radians: float) -> str:
    """ "0.6°", "12°", "180°", "-90°"."""
    degrees = math.degrees(radians)
    return f"{_rounded(degrees, 0 if degrees == 0 or abs(degrees) >= 9.95 else 1)}°"


def turn(radians: float) -> str:
    """Which way, and how far: "+90°" to the left, "-45°" to the right, "0°"."""
    degrees = round(math.degrees(radians))
    return f"{degrees:+,}°" if degrees else "0°"


def memory(n_bytes: float) -> str:
    """ "847 B", "1.5 kB", "12.3 MB", "4 GB"."""
    text = short(n_bytes)
    if not math.isfinite(n_bytes):
        return text
    return f"{text}B" if text[-1].isalpha() else f"{text} B"


def share(part: float) -> str:
    """A share from 0 to 1 as "61.3%": 0% and 100% only for nothing and all of it."""
    if math.isnan(part):
        return "-"
    if part in (0, 1):
        return f"{part:z.0%}"
    if 0 < part < 0.0005:
        return "< 0.1%"
    return "> 99.9%" if 0.9995 <= part < 1 else f"{part:z.1%}"


def exact_share(part: float, digits: int = 6) -> str:
    """A share that somebody has set, or tells in so many digits: "98%", "99.5%"."""
    return f"{exact(100 * part, digits)}%"


def balance(value: float) -> str:
    """A number from -1 to +1, with its sign: "+0.25"."""
    return f"{value:+z.2f}"


def share_of(part: float, whole: float) -> str:
    """The same of two numbers; a dash if the whole is nothing."""
    return share(part / whole) if whole else "-"


def time(seconds: float) -> str:
    """ "0.27 s", "3.4 s", "1,200 s"; "never" if it is endless."""
    if not math.isfinite(seconds):
        return "never"
    size = abs(seconds)
    return f"{_rounded(seconds, 0 if size == 0 or size >= 99.95 else 1 if size >= 0.995 else 2)} s"


def place(x: float, y: float) -> str:
    """A place on the ground (m): "(1.2, -0.3) m"."""
    return f"({coordinates(x, y)}) m"


def coordinates(x: float, y: float) -> str:
    """The same where a column's head names the unit: "1.2, -0.3"."""
    return f"{_rounded(x, 1)}, {_rounded(y, 1)}"


def _rounded(value: float, places: int) -> str:
    if abs(value) >= _ENDLESS:
        return _exponent(value)
    # With z, there is no minus before a zero.
    return f"{value:z,.{places}f}"


def _exponent(value: float) -> str:
    return f"{value:.1e}" if abs(value) < 1e308 else "more than 1e308" if value > 0 else "less than -1e308"
