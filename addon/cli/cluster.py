"""Runs a study's cases, outside Blender: python cluster.py STUDY.toml --out FOLDER [--scheduler ...] [--workers N].

A program of its own, because workers must not start Blender and know the core by its own name only. What .blend files
hold has been read into FOLDER before (``study.py``). Dask is imported only if it is used. Exit codes: 0 if every case
has a result, 1 with a sentence if the study cannot go on, 3 if cases failed, 130 if it was stopped (Ctrl-C), 143 if it
was terminated (SIGTERM); its workers end with it.
"""

import argparse
import contextlib
import importlib
import logging
import os
import signal
import sys
import threading
import time
import uuid
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context, resource_tracker
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Workers of a local cluster import this file again, under another name: they need the core's place, and nothing else.
if str(ROOT) not in sys.path:
    sys.path[:] = [str(ROOT), *(place for place in sys.path if Path(place) != ROOT / "addon" / "cli")]
StudyError = importlib.import_module("core.errors").StudyError

LOCAL, PROCESSES = "local", "processes"

_NO_DASK = (
    "Dask is not installed in '{}'. Install it there (pip install distributed), or say --scheduler processes for a "
    "study on this machine without Dask."
)
_NO_TLS = (
    "A Dask cluster on this machine is encrypted, so that no other user can reach it, which needs the package "
    "'cryptography'. Install it in '{}' (pip install cryptography), or say --scheduler processes."
)
_NOTED = ".shared-"
"""What the name of a file begins with that every worker must see in the study's folder, for a moment."""

_PATIENCE = 15
"""Seconds to wait for a scheduler to answer."""

_QUIET = 5
"""Seconds without any worker after which that is said."""

_WAIT_FOR_WORKERS = 1800
"""Seconds to wait for new workers when all are gone."""


def core(name: str):
    """A module of the core, by the name that workers know it by."""
    return importlib.import_module(f"core.{name}")


def parse(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="cluster.py", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--scheduler", default=PROCESSES)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--quiet", action="store_true")
    return parser.parse_args(words)


@contextlib.contextmanager
def open_executor(scheduler: str, n_workers: int | None, folder: Path):
    """An executor, of a Dask cluster on this machine, of the scheduler at an address, or of plain processes, and what
    to call now and then, so that missing workers are said."""
    if scheduler == PROCESSES:
        with Processes(n_workers, get_context("spawn"), core("study.tasks").end_with, (os.getpid(),)) as executor:
            try:
                yield executor, lambda: None
            except BaseException:
                executor.end_now()
                raise
        return
    try:
        distributed = importlib.import_module("distributed")
    except ImportError:
        raise StudyError(_NO_DASK.format(sys.executable)) from None
    # What it has to say is said by the study: which case failed, and why.
    for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    security = None
    if scheduler == LOCAL:
        # Whoever reaches a scheduler can run anything: nobody does without these credentials, made for this study.
        try:
            security = distributed.Security.temporary()
        except ImportError:
            raise StudyError(_NO_TLS.format(sys.executable)) from None
    with contextlib.ExitStack() as stack:
        if scheduler == LOCAL:
            address = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=n_workers or os.cpu_count() or 1,
                    threads_per_worker=1,
                    processes=True,
                    protocol="tls",
                    security=security,
                    host="tls://127.0.0.1",
                    dashboard_address=None,
                )
            )
        else:
            address = scheduler
        try:
            client = stack.enter_context(distributed.Client(address, timeout=_PATIENCE, security=security))
        except (OSError, TimeoutError, ValueError) as error:
            raise StudyError(f"No scheduler answers at '{scheduler}'; start it, or correct the address.") from error
        check_workers(client, folder)
        roll_call = RollCall(client, scheduler)
        stack.callback(roll_call.end)
        # Every task is its own: one that failed is tried again, not looked up.
        yield client.get_executor(pure=False), roll_call


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Hold Ctrl-C off; where the system can, what came meanwhile comes afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
        return
    # Starting that process of Python's own lets the signal through again.
    resource_tracker.ensure_running()
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


class Processes(ProcessPoolExecutor):
    """Processes on this machine, which hear of Ctrl-C from us only, and end when we do."""

    def submit(self, *args, **kwargs):
        # A process is started here, and goes on holding off what is held off now.
        with _without_interrupts():
            return super().submit(*args, **kwargs)

    def end_now(self) -> None:
        """End all processes, whatever they are doing."""
        processes = list((self._processes or {}).values())
        self.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()


class Terminated(BaseException):
    """SIGTERM has come."""


def _terminated(*_) -> None:
    # Once is enough: nothing interrupts the end.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise Terminated


def check_workers(client, folder: Path) -> None:
    """StudyError unless there are workers, all see the study's folder, and they and the scheduler know the core."""
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError:
        raise StudyError("The scheduler has no workers; start some: dask worker ADDRESS.") from None
    note = folder / f"{_NOTED}{uuid.uuid4().hex}"
    text = str(time.time_ns())
    core("files").write_whole(note, text.encode())
    try:
        found = {f"worker at {address}": looked for address, looked in client.run(_look, str(note)).items()}
        # It unpacks what it hands on, but never looks into the folder.
        found["scheduler"] = (client.run_on_scheduler(_look, str(note))[0], text)
    finally:
        note.unlink(missing_ok=True)
    for who, (version, seen) in found.items():
        if not version:
            raise StudyError(
                f"The {who} cannot import Wayfarer's core: copy the folder '{ROOT}' to its machine, and "
                "start it with PYTHONPATH set to that folder."
            )
        if version != core("study.version").core_version():
            raise StudyError(
                f"The {who} has another version of Wayfarer: copy the folder '{ROOT}' to its machine, and restart it."
            )
        if seen != text:
            raise StudyError(
                f"The {who} does not see the folder '{folder}'; choose one with --out that all "
                "machines share under the same path."
            )


def _look(note: str) -> tuple[str, str]:
    """Return, on another machine, the version of the core that can be imported, if any, and the text of a file."""
    import importlib
    from pathlib import Path

    try:
        importlib.import_module("core.study.tasks")
        version = importlib.import_module("core.study.version").core_version()
    except ImportError:
        return "", ""
    path = Path(note)
    return version, path.read_text() if path.exists() else ""


class RollCall:
    """Reports, when called, that a cluster has no worker left, how long it has been waited for one, and that one came.

    The scheduler is asked in a thread of its own: it may not answer, which is for the study to find out.
    """

    def __init__(self, client, scheduler: str):
        self._client, self._scheduler = client, scheduler
        self._n_workers, self._ended = 1, threading.Event()
        self._gone_since: float | None = None
        self._told = 0.0
        threading.Thread(target=self._ask, daemon=True).start()

    def end(self) -> None:
        self._ended.set()

    def _ask(self) -> None:
        while not self._ended.wait(1.0):
            # Whatever the cluster's trouble is, the study hears of it by its tasks.
            with contextlib.suppress(Exception):
                self._n_workers = len(self._client.nthreads())

    def __call__(self) -> None:
        """StudyError if nobody came for too long."""
        now = time.monotonic()
        if self._n_workers:
            if self._gone_since is not None and self._told:
                print("A worker is back; the study goes on.", file=sys.stderr, flush=True)
            self._gone_since, self._told = None, 0.0
            return
        if self._gone_since is None:
            self._gone_since = now
        waited = now - self._gone_since
        if waited > _WAIT_FOR_WORKERS:
            raise StudyError(
                f"No worker came in {_spoken(waited)}. What is finished is kept: start workers, then the same study "
                "again."
            )
        # At first, and then once a minute.
        if waited > _QUIET and (not self._told or now - self._told > 60):
            self._told = now
            print(
                f"No worker is left since {_spoken(waited)}; waiting for new ones for {_spoken(_WAIT_FOR_WORKERS)} at "
                f"most. Start some: dask worker {self._scheduler}. Ctrl-C stops the study; what is finished is kept.",
                file=sys.stderr,
                flush=True,
            )


def _spoken(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


def main(words: list[str]) -> int:
    options = parse(words)
    signal.signal(signal.SIGTERM, _terminated)
    # Workers find no modules in the current folder, where anything may lie.
    os.environ["PYTHONSAFEPATH"] = "1"
    sources = core("study.sources")
    try:
        plan = core("study.plan").read_plan(options.file)
        folder = core("files").full_path(options.out)
        place = open_executor(options.scheduler, options.workers, folder)
        sources.check_study_folder(folder)
        with core("study.lock").only_one(folder), place as (executor, roll_call):
            write = None if options.quiet else sys.stderr.write
            lines = core("progress").ProgressLines(write, lambda progress: progress.fraction)

            def report(progress):
                roll_call()
                lines(progress)

            steps = core("study.run").run_study_steps(plan, folder, executor)
            outcome = core("progress").finish(steps, report)
        files = {
            sources.TABLE_FILE: core("study.results").results_table(outcome).csv().encode(),
            sources.PAGE_FILE: core("study.report").study_page(outcome).encode(),
        }
        core("files").write_files(folder, files)
    except core("errors").MotionGraphError as error:
        print(f"study: {error}", file=sys.stderr, flush=True)
        return 1
    except KeyboardInterrupt:
        print("study: stopped; start it again to go on.", file=sys.stderr, flush=True)
        return 130
    except Terminated:
        print("study: terminated; start it again to go on.", file=sys.stderr, flush=True)
        return 143
    for sentence in core("study.results").failures(outcome):
        print(f"Failed: {sentence}", file=sys.stderr, flush=True)
    print(
        f"{len(outcome.outcomes)} cases: {len(outcome.outcomes) - outcome.n_failed} with results, "
        f"{outcome.n_known} of them from before; {outcome.n_failed} failed.\n  "
        + "\n  ".join(str(folder / name) for name in files),
        flush=True,
    )
    if outcome.n_outdated:
        print(f"{outcome.n_outdated} results of another version of Wayfarer were replaced.", flush=True)
    return 3 if outcome.n_failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
