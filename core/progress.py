"""Progress of long work: generators that yield how far they are and return what they made."""

import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

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


class ProgressLines:
    """Progress as lines for a terminal: a new phase at once, the same phase at most once in two seconds.

    ``write`` gets each line, or is None to say nothing; ``phase_of`` gives what is equal as long as a phase lasts.
    """

    def __init__(self, write: Callable[[str], Any] | None, phase_of: Callable[[Progress], Any]):
        self._write, self._phase_of = write, phase_of
        self._last: tuple[Any, str] = (None, "")
        self._time = 0.0

    def say(self, line: str) -> None:
        if self._write is not None:
            self._write(f"{line}\n")

    def __call__(self, progress: Progress) -> None:
        now, said = time.monotonic(), (self._phase_of(progress), progress.message)
        if not progress.message or said == self._last or (said[0] == self._last[0] and now - self._time < 2.0):
            return
        self._last, self._time = said, now
        self.say(f"{progress.fraction:4.0%}  {progress.message}")
