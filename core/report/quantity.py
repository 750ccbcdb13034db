"""Quantities: numbers that studies can measure, how each is found, and the options that it has."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..embedding.embedding import Embedding
from ..evaluation.segment_groups import Grouping

Options = Mapping[str, Any]

#: No number that is asked for makes sense beyond it.
LARGEST_NUMBER = 1e12


def is_number(value: object) -> bool:
    """Test for a finite number; TOML knows nan and inf, too, and integers that no float can hold."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST_NUMBER


@dataclass(frozen=True)
class Option:
    """Values that an option may have.

    Attributes
    ----------
    meaning : str
        Ends the sentence "it is ...".
    fits : callable
        Tests a value.
    """

    meaning: str
    fits: Callable[[Any], bool]


def one_of(values: list[str]) -> Option:
    """Build an option with a few names to choose from.

    >>> one_of(["floor", "headings"]).meaning
    "'floor' or 'headings'"
    """
    said = " or ".join(map(repr, values)) if len(values) < 4 else f"one of {', '.join(values)}"
    return Option(said, lambda value: value in values)


TEXT = Option("a name", lambda value: isinstance(value, str))
KIND = one_of([kind.value for kind in Grouping])
AMOUNT = Option("a number, 0 or more", lambda value: is_number(value) and value >= 0)
SHARE = Option("a number from 0 to 1", lambda value: is_number(value) and 0 <= value <= 1)
ANGLE = Option("an angle in radians", is_number)
LENGTH = Option("a number, more than 0", lambda value: is_number(value) and value > 0)
COUNT = Option("a whole number, 1 or more", lambda value: type(value) is int and 1 <= value <= LARGEST_NUMBER)
NATURAL = Option("a whole number, 0 or more", lambda value: type(value) is int and 0 <= value <= LARGEST_NUMBER)
POSITION = Option(
    "two numbers, x and y in metres",
    lambda value: isinstance(value, list | tuple) and len(value) == 2 and all(map(is_number, value)),
)


@dataclass(frozen=True)
class Quantity:
    """A number of an embedding.

    Attributes
    ----------
    meaning : str
    number : callable
        Reads the number off what was found, with the options in ``own`` as keywords.
    unit : str
        As it stands behind a column's name; empty for counts and shares.
    find : callable, optional
        ``(embedding, options)``, what the number is read off; quantities with the same ``find`` and the same options
        share it. None for what maps and counts tell, also of grounds in parcels: the number is then read off a
        :class:`core.study.subject.Subject`.
    options : mapping of str to Option
    own : tuple of str
        Options that ``number`` takes instead of ``find``.
    one_of : tuple of str
        Options of which exactly one must be given.
    at_most_one : tuple of str
        Options of which no two may be given.
    details : mapping of str to str
        Options that mean nothing without another one, and that one.
    """

    meaning: str
    number: Callable[..., float]
    unit: str = ""
    find: Callable[[Embedding, Options], Any] | None = None
    options: Mapping[str, Option] = field(default_factory=dict)
    own: tuple[str, ...] = ()
    one_of: tuple[str, ...] = ()
    at_most_one: tuple[str, ...] = ()
    details: Mapping[str, str] = field(default_factory=dict)


def chosen_kind(options: Options) -> Grouping:
    """Return the kind of actions that the options name, clips by default."""
    return Grouping(options.get("kind", Grouping.CLIP.value))
