"""Runs a study's cases, outside Blender: python cluster.py STUDY.toml --out FOLDER [--scheduler ...] [--workers N].

A program of its own, because workers must not start Blender and know the core by its own name only. What .blend files
hold has been read into FOLDER before (``study.py``). Dask is imported only if it is used. Exit codes: 0 if every case
has a result, 1 with a sentence if the study cannot go on, 3 if cases failed, 130 if it was stopped.
"""

import argparse
import contextlib
import importlib
import logging
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCAL, PROCESSES = "local", "processes"

_NO_DASK = (
    "Dask is not installed in '{}'. Install it there (pip install distributed), or say --scheduler processes for a "
    "study on this machine without Dask."
)
_NOTED = "shared.txt"
"""A file in the study's folder that every worker must see."""

_PATIENCE = 15
"""Seconds to wait for a scheduler to answer."""


class ClusterError(Exception):
    """What stops a study, as a sentence for the person at the keyboard."""


def core(name: str):
    """A module of the core, by the name that workers know it by."""
    return importlib.import_module(f"core.{name}")


def parse(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="cluster.py", description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--scheduler", default=LOCAL)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--quiet", action="store_true")
    return parser.parse_args(words)


@contextlib.contextmanager
def open_executor(scheduler: str, n_workers: int | None, folder: Path):
    """An executor: of a Dask cluster on this machine, of the scheduler at an address, or of plain processes."""
    if scheduler == PROCESSES:
        with ProcessPoolExecutor(n_workers, get_context("spawn")) as executor:
            yield executor
        return
    try:
        distributed = importlib.import_module("distributed")
    except ImportError:
        raise ClusterError(_NO_DASK.format(sys.executable)) from None
    # What it has to say is said by the study: which case failed, and why.
    for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with contextlib.ExitStack() as stack:
        if scheduler == LOCAL:
            address = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=n_workers or os.cpu_count() or 1,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0",
                )
            )
        else:
            address = scheduler
        try:
            client = stack.enter_context(distributed.Client(address, timeout=_PATIENCE))
        except (OSError, TimeoutError, ValueError) as error:
            reason = str(error).strip().split("\n")[0] or type(error).__name__
            raise ClusterError(f"No scheduler answers at '{scheduler}' ({reason}); start it, or correct it.") from None
        check_workers(client, folder)
        # Every task is its own: one that failed is tried again, not looked up.
        yield client.get_executor(pure=False)


def check_workers(client, folder: Path) -> None:
    """ClusterError unless there are workers, all see the study's folder, and they and the scheduler know the core."""
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError:
        raise ClusterError("The scheduler has no workers; start some: dask worker ADDRESS.") from None
    note = folder / _NOTED
    text = str(time.time_ns())
    core("expanse.set_file").write_whole(note, text.encode())
    try:
        found = {f"worker at {address}": looked for address, looked in client.run(_look, str(note)).items()}
        # It unpacks what it hands on, but never looks into the folder.
        found["scheduler"] = (client.run_on_scheduler(_look, str(note))[0], text)
    finally:
        note.unlink(missing_ok=True)
    for who, (knows_core, seen) in found.items():
        if not knows_core:
            raise ClusterError(
                f"The {who} cannot import Wayfarer's core: copy the folder '{ROOT}' to its machine, and "
                "start it with PYTHONPATH set to that folder."
            )
        if seen != text:
            raise ClusterError(
                f"The {who} does not see the folder '{folder}'; choose one with --out that all "
                "machines share under the same path."
            )


def _look(note: str) -> tuple[bool, str]:
    """On another machine: whether the core can be imported, and what stands in a file."""
    import importlib
    from pathlib import Path

    try:
        importlib.import_module("core.study.tasks")
    except ImportError:
        return False, ""
    path = Path(note)
    return True, path.read_text() if path.exists() else ""


class Teller:
    """Progress lines on standard error; not more than one in two seconds while no case ends."""

    def __init__(self, quiet: bool):
        self._quiet = quiet
        self._last = ("", -1.0)
        self._time = 0.0

    def __call__(self, progress) -> None:
        now, said = time.monotonic(), (progress.message, progress.fraction)
        if self._quiet or not progress.message or said == self._last:
            return
        if progress.fraction == self._last[1] and now - self._time < 2.0:
            return
        self._last, self._time = said, now
        print(f"{progress.fraction:4.0%}  {progress.message}", file=sys.stderr, flush=True)


def main(words: list[str]) -> int:
    options = parse(words)
    errors, set_file = core("errors"), core("expanse.set_file")
    try:
        plan = core("study.plan").read_plan(options.file)
        folder = options.out.resolve()
        with open_executor(options.scheduler, options.workers, folder) as executor:
            steps = core("study.run").run_study_steps(plan, folder, executor)
            outcome = core("progress").finish(steps, Teller(options.quiet))
        csv, page = folder / "results.csv", folder / "results.html"
        set_file.write_whole(csv, core("study.results").results_table(outcome).csv().encode())
        set_file.write_whole(page, core("study.report").study_page(outcome).encode())
    except (ClusterError, errors.MotionGraphError) as error:
        print(f"study: {error}", file=sys.stderr, flush=True)
        return 1
    except KeyboardInterrupt:
        print("study: stopped; start it again to go on.", file=sys.stderr, flush=True)
        return 130
    for sentence in core("study.results").failures(outcome):
        print(f"Failed: {sentence}", file=sys.stderr, flush=True)
    print(
        f"{len(outcome.outcomes)} cases: {len(outcome.outcomes) - outcome.n_failed} with results, "
        f"{outcome.n_known} of them from before; {outcome.n_failed} failed.\n  {csv}\n  {page}",
        flush=True,
    )
    return 3 if outcome.n_failed else 0


# Workers of a local cluster import this file again, under another name: they need the core's place, and nothing else.
if str(ROOT) not in sys.path:
    sys.path[:] = [str(ROOT), *(place for place in sys.path if Path(place) != ROOT / "addon")]

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
