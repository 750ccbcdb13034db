"""Running a study: which cases are known, handing out the others, and what became of them all."""

import hashlib
import json
import logging
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path

from ..errors import MotionGraphError, StorageError, StudyError
from ..files import check_marked, from_json, full_path, read_regular
from ..parcels.embedding import embed_parcels_steps
from ..parcels.work import Serial
from ..progress import Progress
from ..wording import counted
from . import tasks
from .case import CaseResult, result_from_json
from .plan import Case, StudyPlan
from .settings import Stage, of_stage
from .sources import Input, check_study_folder, gather
from .version import core_version

_WAIT = 0.2
"""Seconds between two reports of progress while no task ends."""

_LABEL = 60
"""Characters of a case's label in the name of its maps' folder, which must not exceed 255 bytes."""

_GONE = (
    "The workers are gone{}. What is finished is kept: see that the scheduler and its workers run, and start the "
    "same study again."
)


@dataclass(frozen=True)
class CaseOutcome:
    """A case and what came of it: a result, or the reason why there is none.

    Attributes
    ----------
    case : Case
    result : CaseResult, optional
    problem : str
    maps : str
        Where the maps of a ground in parcels are written, from the study's folder.
    """

    case: Case
    result: CaseResult | None
    problem: str = ""
    maps: str = ""


@dataclass(frozen=True)
class StudyOutcome:
    """All cases of a study.

    Attributes
    ----------
    plan : StudyPlan
    outcomes : tuple of CaseOutcome
        In the order of the plan.
    n_known : int
        Cases that were finished before, and not run again.
    n_outdated : int
        Cases that another version of Wayfarer had finished before: they were run again.
    """

    plan: StudyPlan
    outcomes: tuple[CaseOutcome, ...]
    n_known: int
    n_outdated: int = 0

    @property
    def n_failed(self) -> int:
        return sum(outcome.result is None for outcome in self.outcomes)


@dataclass
class _Job:
    """A task in the making.

    Attributes
    ----------
    task, arguments
        What a worker is to do; it returns what is wrong, or nothing.
    finish : callable
        Told what was wrong, gives the jobs that can be done now.
    """

    task: Callable[..., str]
    arguments: tuple
    finish: Callable[[str], list["_Job"]]
    failed_before: bool = False


def run_study_steps(
    plan: StudyPlan, folder: Path, executor: Executor | None = None
) -> Generator[Progress, None, StudyOutcome]:
    """Run the cases of a study that the folder does not know yet, as a generator that yields progress.

    A case that fails does not stop the others: its outcome tells why. One whose worker dies is tried once more when
    the others are done, by itself.

    Parameters
    ----------
    folder : Path
        All workers must find it under this path. What .blend files hold must have been read into it: :mod:`.sources`.
    executor : Executor, optional
        This process by default.

    Raises
    ------
    StudyError
        The study cannot go on: the folder cannot be written, or the workers are gone. Start it again, and it goes on.
    """
    try:
        check_study_folder(full_path(folder))
        return (yield from _Study(plan, full_path(folder), executor or Serial()).steps())
    except StorageError as error:
        raise StudyError(f"{error} What is finished is kept.") from None


class _Study:
    def __init__(self, plan: StudyPlan, folder: Path, executor: Executor):
        self.plan, self.folder, self.executor = plan, folder, executor
        self.scenes, self.clips = gather(plan, folder)
        ready = frozenset(name for name, source in self.clips.items() if source.is_graph)
        self.cases = list(plan.cases(ready))
        self.key = {id(case): self._case_key(case) for case in self.cases}
        self.problem: dict[int, str] = {}
        self.is_open = {id(case) for case in self.cases}
        self.n_done = 0
        self.message = ""

    def steps(self) -> Generator[Progress, None, StudyOutcome]:
        n_known = n_outdated = 0
        waiting: dict[str, list[Case]] = {}
        large: list[Case] = []
        for case in self.cases:
            scene, clips = self.scenes[case.scene], self.clips[case.clips]
            if scene.problem or clips.problem:
                self._settle(case, scene.problem or clips.problem)
            elif _known(self._result_file(case)) is not None:
                n_known += 1
                self.n_done += 1
                self.is_open.remove(id(case))
            elif case.values.get("parcel_size"):
                large.append(case)
                waiting.setdefault(self._graph_key(case), [])
            else:
                waiting.setdefault(self._graph_key(case), []).append(case)
            if id(case) in self.is_open:
                check_marked(self._result_file(case), tasks.CASE_MARK)
            n_outdated += id(case) in self.is_open and _known(self._result_file(case), any_version=True) is not None
        if n_known:
            self.message = f"{n_known} of {counted(len(self.cases), 'case')} had been finished before"
            yield self._progress()
        if n_outdated:
            self.message = (
                f"{counted(n_outdated, 'case')} that another version of Wayfarer had finished will be run again"
            )
            yield self._progress()
        jobs = []
        graph_of = {self._graph_key(case): case for case in self.cases}
        for key, cases in waiting.items():
            jobs += self._graph_jobs(graph_of[key], cases)
        yield from self._jobs_steps(jobs)
        for case in large:
            yield from self._large_steps(case)
        outcomes = []
        for case in self.cases:
            problem = self.problem.get(id(case), "")
            result = None if problem else _known(self._result_file(case))
            if result is None and not problem:
                problem = f"'{self._result_file(case)}' cannot be read; delete it and start the study again."
                if _known(self._result_file(case), any_version=True) is not None:
                    problem = (
                        "A worker has another version of Wayfarer; give all machines the same one, and start again."
                    )
            outcomes.append(CaseOutcome(case, result, problem, self._maps(case)))
        return StudyOutcome(self.plan, tuple(outcomes), n_known, n_outdated)

    # ------------------------------------------------------------------------------------------------- keys

    def _graph_key(self, case: Case) -> str:
        clips = self.clips[case.clips]
        return clips.digest if clips.is_graph else _digest([clips.digest, of_stage(case.values, Stage.GRAPH)])

    def _case_key(self, case: Case) -> str:
        measures = [[m.name, m.quantity, dict(m.options)] for m in self.plan.measures]
        scene = self.scenes[case.scene].digest
        return _digest([tasks.CASE_FORMAT, scene, self._graph_key(case), dict(case.values), measures])

    def _result_file(self, case: Case) -> Path:
        return self.folder / "cases" / f"{self.key[id(case)]}.json"

    def _graph_file(self, case: Case) -> Path:
        clips = self.clips[case.clips]
        if clips.is_graph:
            return clips.file
        # Results of another version wait for their successors; a graph of one must not be used on the way there.
        return self.folder / "graphs" / f"{_digest([self._graph_key(case), core_version()])}.npz"

    def _large_folder(self, case: Case) -> Path:
        return self.folder / "large" / _digest([self.key[id(case)], core_version()])

    def _maps(self, case: Case) -> str:
        """Name the folder of a ground's maps, from that of the study: its label for people, its key to tell it from all
        others - also from the same case as it was with other settings that do not vary."""
        return f"maps/{case.label(self.plan.varied)[:_LABEL]} {self.key[id(case)][:12]}"

    # ------------------------------------------------------------------------------------------------- jobs

    def _graph_jobs(self, case: Case, cases: list[Case]) -> list[_Job]:
        """Return the jobs of the cases that share a graph: first the graph itself, if it is not there."""
        file = self._graph_file(case)
        if file.exists():
            return [self._case_job(case) for case in cases]
        source: Input = self.clips[case.clips]

        def built(problem: str) -> list[_Job]:
            self.message = f"{case.clips}: {problem or 'motion graph is built'}"
            if problem:
                for waiting in self._cases_of(self._graph_key(case)):
                    self._settle(waiting, problem)
                return []
            return [self._case_job(waiting) for waiting in cases]

        values = of_stage(case.values, Stage.GRAPH)
        return [_Job(tasks.build_graph, (str(source.file), values, str(file)), built)]

    def _cases_of(self, graph_key: str) -> Iterable[Case]:
        return [case for case in self.cases if self._graph_key(case) == graph_key and id(case) in self.is_open]

    def _case_job(self, case: Case) -> _Job:
        arguments = (
            str(self.scenes[case.scene].file),
            str(self._graph_file(case)),
            dict(case.values),
            self.plan.measures,
            str(self._result_file(case)),
        )
        return _Job(tasks.measure_case, arguments, lambda problem: self._settle(case, problem))

    def _settle(self, case: Case, problem: str) -> list[_Job]:
        self.n_done += 1
        self.is_open.remove(id(case))
        if problem:
            self.problem[id(case)] = problem
        self.message = f"{case.label(self.plan.varied)}: {problem or 'done'}"
        return []

    def _jobs_steps(self, jobs: list[_Job]) -> Generator[Progress, None, None]:
        waiting, again = deque(jobs), deque[_Job]()
        running: dict[Future, _Job] = {}
        try:
            while waiting or running or again:
                if not waiting and not running:
                    waiting.append(again.popleft())
                while waiting:
                    job = waiting.popleft()
                    future = self._submit(job)
                    running[future] = job
                    if future.done():  # an executor that works in this process
                        break
                done, _ = wait(list(running), timeout=_WAIT, return_when=FIRST_COMPLETED)
                for future in done:
                    job = running.pop(future)
                    problem, fault = _problem(future)
                    if fault and not job.failed_before:
                        job.failed_before = True
                        again.append(job)
                        continue
                    waiting.extend(job.finish(problem))
                    yield self._progress()
                yield self._progress()
        finally:
            for future in running:
                future.cancel()

    def _submit(self, job: _Job) -> Future:
        try:
            return self.executor.submit(job.task, *job.arguments)
        except BrokenExecutor as error:
            raise StudyError(_GONE.format(_reason(error))) from None

    def _large_steps(self, case: Case) -> Generator[Progress, None, None]:
        """Measure a ground in parcels, with all workers together."""
        if id(case) not in self.is_open:
            return
        folder, start = self._large_folder(case), time.perf_counter()
        if not (folder / "problem.json").exists():
            files = str(self.scenes[case.scene].file), str(self._graph_file(case))
            wrong = []
            laid_out = _Job(
                tasks.lay_out, (*files, dict(case.values), str(folder)), lambda problem: wrong.append(problem) or []
            )
            yield from self._jobs_steps([laid_out])
            if wrong[0]:
                self._settle(case, wrong[0])
                return
        try:
            steps = embed_parcels_steps(folder, self.executor)
            while True:
                try:
                    progress = next(steps)
                except StopIteration as stop:
                    summary = stop.value
                    break
                yield Progress(self.n_done / len(self.cases), f"{case.label(self.plan.varied)}: {progress.message}")
        except (StorageError, GeneratorExit):
            raise
        except (BrokenExecutor, CancelledError) as error:
            raise StudyError(_GONE.format(_reason(error))) from None
        except Exception as error:
            self._settle(case, str(error) if isinstance(error, MotionGraphError) else _fault(error))
            return
        arguments = (
            str(folder),
            summary,
            self.plan.measures,
            time.perf_counter() - start,
            str(self.folder / self._maps(case)),
            str(self._result_file(case)),
        )
        measured = _Job(tasks.measure_parcels, arguments, lambda problem: self._settle(case, problem))
        yield from self._jobs_steps([measured])

    def _progress(self) -> Progress:
        return Progress(self.n_done / max(len(self.cases), 1), self.message)


def _problem(future: Future) -> tuple[str, bool]:
    """Return what is wrong with a task, and True if another try may go better.

    Raises StorageError and StudyError for what stops everything.
    """
    try:
        return future.result(), False
    except StorageError:
        raise
    except (BrokenExecutor, CancelledError) as error:
        raise StudyError(_GONE.format(_reason(error))) from None
    except Exception as error:
        return _fault(error), True


def _reason(error: BaseException) -> str:
    return " (the scheduler does not answer any more)" if isinstance(error, CancelledError) else ""


def _fault(error: BaseException) -> str:
    """Put a fault into a sentence; what Python says of it goes to the log."""
    if isinstance(error, MemoryError):
        return "It needs more memory than there is."
    if type(error).__name__ == "KilledWorker":  # of a library that not everybody has
        return "Its workers died of it, one after another; give them more memory, or it a smaller ground."
    logging.getLogger(__name__).error("A case failed.", exc_info=error)
    return "It failed, for a reason that was not foreseen; the log of the run has the details, please report them."


def _known(path: Path, any_version: bool = False) -> CaseResult | None:
    """Read the result of a case; None unless its file is whole and was written by this version of Wayfarer."""
    try:
        found = from_json(read_regular(path))
        ours = found["format"] == tasks.CASE_FORMAT and (any_version or found["version"] == core_version())
        return result_from_json(found) if ours else None
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError):
        return None


def _digest(parts: list) -> str:
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]
