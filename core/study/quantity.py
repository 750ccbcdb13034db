"""What a kind of number is: how it is found, and what may be asked for besides."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..evaluation.segment_groups import Grouping
from .subject import Subject, WholeGround

Options = Mapping[str, Any]


def is_number(value: object) -> bool:
    """Whether a value is a finite number; TOML knows nan and inf, too."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


@dataclass(frozen=True)
class Option:
    """What may be asked for besides: a name's values.

    Attributes
    ----------
    meaning : str
        Ends the sentence "it is ...".
    fits : callable
        Whether a value can be understood.
    """

    meaning: str
    fits: Callable[[Any], bool]


TEXT = Option("a name", lambda value: isinstance(value, str))
KIND = Option(
    " or ".join(repr(kind.value) for kind in Grouping), lambda value: value in [kind.value for kind in Grouping]
)
AMOUNT = Option("a number, 0 or more", lambda value: is_number(value) and value >= 0)
SHARE = Option("a number from 0 to 1", lambda value: is_number(value) and 0 <= value <= 1)
ANGLE = Option("an angle in radians", is_number)
LENGTH = Option("a number, more than 0", lambda value: is_number(value) and value > 0)
COUNT = Option("a whole number, 1 or more", lambda value: type(value) is int and value >= 1)
NATURAL = Option("a whole number, 0 or more", lambda value: type(value) is int and value >= 0)
POSITION = Option(
    "two numbers, x and y in metres",
    lambda value: isinstance(value, list | tuple) and len(value) == 2 and all(map(is_number, value)),
)


@dataclass(frozen=True)
class Quantity:
    """A kind of number.

    Attributes
    ----------
    meaning : str
    unit : str
        As it stands behind a column's name; empty for counts and shares.
    of_ground : callable, optional
        Subject -> number, for what maps and counts tell: also on grounds in parcels.
    of_embedding : callable, optional
        (WholeGround, options) -> number, for everything else.
    options : mapping of str to Option
        What may be asked for besides.
    one_of : tuple of str
        Options of which exactly one must be given.
    at_most_one : tuple of str
        Options of which no two may be given.
    details : mapping of str to str
        Options that say nothing without another one, and that one.
    """

    meaning: str
    unit: str = ""
    of_ground: Callable[[Subject], float] | None = None
    of_embedding: Callable[[WholeGround, Options], float] | None = None
    options: Mapping[str, Option] = field(default_factory=dict)
    one_of: tuple[str, ...] = ()
    at_most_one: tuple[str, ...] = ()
    details: Mapping[str, str] = field(default_factory=dict)


def of_whole(meaning: str, of_embedding: Callable[[WholeGround, Options], float], unit: str = "", **more) -> Quantity:
    """A quantity that only a whole embedding tells."""
    return Quantity(meaning, unit, of_embedding=of_embedding, **more)
