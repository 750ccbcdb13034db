"""Handing out tasks: phase after phase, with a journal of what is done, so that whoever stops can go on."""

import json
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import EmbeddingError
from ..files import from_json, read_regular, write_whole
from ..progress import Progress
from . import tasks
from .problem import Problem
from .set_file import remove_sets
from .tasks import Messages, TaskResult

_WAIT = 0.2
"""Seconds between two reports of progress while no task ends."""


class Serial(Executor):
    """Runs every task at once, in this process."""

    def submit(self, fn, /, *args, **kwargs):
        future: Future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except BaseException as error:
            future.set_exception(error)
        return future


@dataclass(frozen=True)
class Phase:
    """The results of all parcels' tasks of a phase.

    Attributes
    ----------
    n_nodes : list of int
        Nodes that each parcel wrote.
    messages : list of (parcel, path)
        What the parcels sent each other.
    """

    n_nodes: list[int]
    messages: list[tuple[int, str]]

    @property
    def total(self) -> int:
        return sum(self.n_nodes)

    def inboxes(self) -> Messages:
        """Return the messages by the parcels that they are for."""
        messages: Messages = {}
        for parcel, path in self.messages:
            messages.setdefault(parcel, []).append(path)
        return messages


class Work:
    """The phases of one problem, run by an executor.

    Every phase has a name of its own; what it came to is written into a journal in the problem's folder. A phase that
    the journal knows is not run again.
    """

    def __init__(self, problem: Problem, executor: Executor):
        self.problem = problem
        self._folder, self._executor = str(problem.folder), executor
        self._journal_path = problem.folder / "journal.json"
        self._journal: dict[str, Any] = {}
        if self._journal_path.exists():
            self._journal = _read_journal(self._journal_path)
        self.n_parcels = len(problem.plan.parcels)

    def all_steps(self, name: str, task: Callable, *arguments) -> Generator[Progress, None, Phase]:
        """Run a task on each parcel that returns :class:`TaskResult`.

        An argument that is a dict is looked up by the parcel: messages for it, () if there is none.
        """
        if name not in self._journal:
            results: list[TaskResult] = yield from self.results_steps(name, task, *arguments)
            self._write(name, [[r.n_nodes for r in results], [m for r in results for m in r.messages]])
        n_nodes, messages = self._journal[name]
        return Phase(n_nodes, [(parcel, path) for parcel, path in messages])

    def numbers_steps(self, name: str, task: Callable, *arguments) -> Generator[Progress, None, list]:
        """Run tasks that return what JSON can hold, see :meth:`all_steps`."""
        if name not in self._journal:
            self._write(name, (yield from self.results_steps(name, task, *arguments)))
        return self._journal[name]

    def results_steps(self, name: str, task: Callable, *arguments) -> Generator[Progress, None, list]:
        """Run tasks and return their results in the order of the parcels; not written into the journal."""
        futures = [self._submit(task, parcel, arguments) for parcel in range(self.n_parcels)]
        yield from self._finish(name, futures)
        return [future.result() for future in futures]

    def closure_steps(
        self, task: Callable, seed: dict[int, str], within: str | None, out: str
    ) -> Generator[Progress, None, Phase]:
        """Follow links on or back (``tasks.go_on`` or ``tasks.go_back``) until nothing is new.

        ``seed`` are the parcels where it begins, each with the set that it begins from. Parcels work whenever a
        neighbour has sent them something; in which order does not matter.
        """
        if out in self._journal:
            return Phase(self._journal[out], [])
        version = [0] * self.n_parcels
        n_nodes = [0] * self.n_parcels
        inbox: Messages = {}
        running: dict[Future, tuple[int, list[str]]] = {}

        def start(parcel: int, known: str | None, messages: list[str]) -> None:
            version[parcel] += 1
            future = self._submit(task, parcel, (known, messages, within, f"{out}~{version[parcel]}"))
            running[future] = parcel, messages

        for parcel, known in seed.items():
            start(parcel, known, [])
        n_done = 0
        while running:
            done, _ = wait(list(running), timeout=_WAIT, return_when=FIRST_COMPLETED)
            for future in done:
                parcel, messages = running.pop(future)
                result: TaskResult = future.result()
                n_done, n_nodes[parcel] = n_done + 1, result.n_nodes
                for other, path in result.messages:
                    inbox.setdefault(other, []).append(path)
                for path in messages:
                    Path(path).unlink(missing_ok=True)
                if version[parcel] > 1:
                    self.problem.set_path(f"{out}~{version[parcel] - 1}", parcel).unlink(missing_ok=True)
            busy = {parcel for parcel, _ in running.values()}
            for parcel in sorted(set(inbox) - busy):
                known = f"{out}~{version[parcel]}" if version[parcel] else None
                start(parcel, known, inbox.pop(parcel))
            yield Progress(n_done / (n_done + len(running) + len(inbox)), f"{out}: {n_done} parcels visited")
        for parcel in range(self.n_parcels):
            if not version[parcel]:  # nothing ever came there
                tasks.clear(self._folder, parcel, out)
                continue
            final = self.problem.set_path(out, parcel)
            final.parent.mkdir(parents=True, exist_ok=True)
            self.problem.set_path(f"{out}~{version[parcel]}", parcel).replace(final)
        self._write(out, n_nodes)
        return Phase(n_nodes, [])

    def forget(self, *kept: str) -> None:
        """Delete all sets but those kept, and all messages."""
        for group in ("sets", "messages"):
            for folder in sorted((self.problem.folder / group).glob("*")):
                if group == "messages" or folder.name not in kept:
                    remove_sets(folder)

    def known(self, name: str) -> Any | None:
        """Return what the journal holds of a phase; None if it has not been run."""
        return self._journal.get(name)

    def record(self, name: str, result: Any) -> None:
        """Write something of one's own into the journal."""
        self._write(name, result)

    def _submit(self, task: Callable, parcel: int, arguments: Sequence) -> Future:
        values = [list(a.get(parcel, ())) if isinstance(a, dict) else a for a in arguments]
        return self._executor.submit(task, self._folder, parcel, *values)

    def _finish(self, name: str, futures: list[Future]) -> Generator[Progress, None, None]:
        left = set(futures)
        while left:
            done, left = wait(left, timeout=_WAIT, return_when=FIRST_COMPLETED)
            for future in done:
                future.result()
            yield Progress(1 - len(left) / max(len(futures), 1), name)

    def _write(self, name: str, result: Any) -> None:
        self._journal[name] = result
        write_whole(self._journal_path, json.dumps(self._journal).encode())


def _read_journal(path: Path) -> dict[str, Any]:
    try:
        journal = from_json(read_regular(path))
    except (OSError, ValueError):
        journal = None
    if not isinstance(journal, dict):
        raise EmbeddingError(f"'{path}' is damaged; delete the folder it lies in, and run the embedding again.")
    return journal
