"""Progress of long work: generators that yield how far they are and return what they made."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Progress:
    """How far a piece of long work is: a fraction from 0 to 1 and a phrase for the status bar."""

    fraction: float
    message: str


def finish(steps: Generator[Progress, None, Result], report: Callable[[Progress], None] | None = None) -> Result:
    """Run long work to its end and return its result, telling ``report`` of every step."""
    while True:
        try:
            progress = next(steps)
        except StopIteration as stop:
            return stop.value
        if report is not None:
            report(progress)


def portion(steps: Generator[Progress, None, Result], start: float, end: float) -> Generator[Progress, None, Result]:
    """The same work as a part of a longer one: its progress runs from ``start`` to ``end``."""
    while True:
        try:
            progress = next(steps)
        except StopIteration as stop:
            return stop.value
        yield Progress(start + (end - start) * progress.fraction, progress.message)
