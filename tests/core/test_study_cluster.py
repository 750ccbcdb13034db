"""Studies on real clusters: Dask's scheduler and two worker processes on the loopback address."""

import contextlib
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from core.errors import StudyError
from core.study.geometry import save_scene
from core.study.run import run_study_steps
from core.study.tasks import measure_case
from core.study.version import core_version

from .studies import lay_out, plan, region, room, rows_of, run_study

distributed = pytest.importorskip("distributed", reason="Dask is not installed")

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = {"radius": [0.2, 0.25, 0.3], "k": ["all", 2]}


def test_two_workers_find_what_one_process_finds(client, tmp_path):
    study = lay_out(tmp_path, settings=SETTINGS)
    here = run_study(study, tmp_path / "here")
    there = run_study(study, tmp_path / "there", client.get_executor(pure=False))
    assert rows_of(here) == rows_of(there) and here.n_failed == 0
    assert run_study(study, tmp_path / "there", client.get_executor(pure=False)).n_known == 12


def test_a_worker_that_is_killed_is_made_up_for(client, tmp_path):
    study = lay_out(tmp_path, settings={**SETTINGS, "n_headings": [6, 8]})
    here = run_study(study, tmp_path / "here")
    steps, killed = run_study_steps(study, tmp_path / "out", client.get_executor(pure=False)), False
    while True:
        try:
            progress = next(steps)
        except StopIteration as stop:
            found = stop.value
            break
        if not killed and progress.fraction > 0:
            # Without a word, as a machine that is switched off.
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
            killed = True
    assert killed
    assert rows_of(found) == rows_of(here)


def die(*_):
    """A case that no worker survives, as one that takes more memory than there is."""
    os.kill(os.getpid(), signal.SIGKILL)


class Poisoned:
    """An executor on which the cases with one radius kill their worker."""

    def __init__(self, executor, radius):
        self._executor, self._radius = executor, radius

    def submit(self, task, *arguments):
        deadly = task is measure_case and arguments[2]["radius"] == self._radius
        return self._executor.submit(die if deadly else task, *arguments)


def test_a_case_that_kills_its_workers_is_reported(client, tmp_path):
    study = lay_out(tmp_path, scenes={"open": "open.npz"}, settings={"radius": [0.2, 0.25, 0.3]})

    def allow(dask_scheduler, n):
        dask_scheduler.allowed_failures = n

    client.run_on_scheduler(allow, n=0)
    try:
        outcome = run_study(study, tmp_path / "out", Poisoned(client.get_executor(pure=False), 0.25))
    finally:
        client.run_on_scheduler(allow, n=3)
    assert [entry.result is None for entry in outcome.outcomes] == [False, True, False]
    assert "workers died of it" in outcome.outcomes[1].problem
    assert run_study(study, tmp_path / "out").n_known == 2


def test_a_ground_in_parcels_is_worked_on_together(client, tmp_path):
    lay_out(tmp_path)
    save_scene(room(width=12.0, regions=[region()]), tmp_path / "long.npz")
    study = plan(tmp_path, scenes={"long": "long.npz"}, settings={"parcel_size": [0.0, 4.0]})
    outcome = run_study(study, tmp_path / "out", client.get_executor(pure=False))
    whole, parcels = (entry.result for entry in outcome.outcomes)
    assert dict(whole.numbers) == dict(parcels.numbers) and whole.numbers["nodes"] > 0
    assert np.array_equal(whole.picture.levels, parcels.picture.levels, equal_nan=True)


def drain(steps):
    until = time.monotonic() + 300
    for _ in steps:
        assert time.monotonic() < until


def small_cluster():
    return distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        host="127.0.0.1",
        dashboard_address=":0",
    )


def test_a_scheduler_that_is_restarted_costs_no_finished_case(tmp_path):
    study = lay_out(tmp_path, settings={**SETTINGS, "n_headings": [6, 8, 12]})
    cluster = small_cluster()
    client = distributed.Client(cluster)
    steps = run_study_steps(study, tmp_path / "out", client.get_executor(pure=False))
    while next(steps).fraction == 0:
        pass
    cluster.sync(cluster.scheduler.close)
    with pytest.raises(StudyError, match=r"workers are gone.*start the same study again"):
        drain(steps)
    client.close(timeout=1)
    # What is left of it waits for its scheduler.
    with contextlib.suppress(TimeoutError):
        cluster.close(timeout=1)
    n_done = len(list((tmp_path / "out" / "cases").glob("*.json")))
    assert 0 < n_done < 36
    with small_cluster() as cluster, distributed.Client(cluster) as client:
        outcome = run_study(study, tmp_path / "out", client.get_executor(pure=False))
    assert outcome.n_known >= n_done and outcome.n_failed == 0
    assert rows_of(outcome) == rows_of(run_study(study, tmp_path / "here"))


def machine(folder):
    """A folder with the program and the core, as another machine has it; nobody edits it while the test runs."""
    shutil.copytree(ROOT / "core", folder / "core", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "addon" / "cli").mkdir(parents=True)
    shutil.copy(ROOT / "addon" / "cli" / "cluster.py", folder / "addon" / "cli")
    return folder


@contextlib.contextmanager
def started(root, *words):
    """A Python process that knows the core in a folder; ended with the block."""
    environment = {**os.environ, "PYTHONPATH": str(root)}
    process = subprocess.Popen(
        [sys.executable, *map(str, words)], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def worker(root, address):
    """A worker that nobody restarts when it dies."""
    words = ["-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard"]
    return started(root, *words)


def test_that_all_workers_are_gone_is_said_and_a_new_one_finishes(tmp_path):
    lay_out(tmp_path)
    root = machine(tmp_path / "machine")
    file, out = tmp_path / "study.toml", tmp_path / "out"
    file.write_text(
        'measures = ["nodes", "links"]\n[scenes]\nopen = "open.npz"\ndoor = "door.npz"\n[clips]\ngraph = "graph.npz"\n'
        f"[settings]\nradius = {json.dumps([0.1 + 0.01 * i for i in range(20)])}\nn_headings = [8, 12]"
    )
    with contextlib.ExitStack() as stack:
        cluster = stack.enter_context(
            distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=":0", protocol="tcp")
        )
        address = cluster.scheduler_address
        workers = [stack.enter_context(worker(root, address)) for _ in range(2)]
        words = [root / "addon" / "cli" / "cluster.py", file, "--out", out, "--scheduler", address]
        study = stack.enter_context(started(root, *words))
        until = time.monotonic() + 300
        while len(list(out.glob("cases/*.json"))) < 4:
            assert study.poll() is None and time.monotonic() < until
            time.sleep(0.02)
        for process in workers:
            process.kill()
        n_done = len(list(out.glob("cases/*.json")))
        for line in study.stderr:
            if line.startswith("No worker is left"):
                break
        assert "s; waiting for new ones for 30 min at most" in line and f"dask worker {address}" in line
        assert 4 <= n_done < 80 and study.poll() is None
        stack.enter_context(worker(root, address))
        told, errors = study.communicate(timeout=300)
    assert study.returncode == 0, errors
    assert "A worker is back" in errors and "80 cases: 80 with results" in told


def test_workers_of_another_version_are_refused(client, tmp_path):
    cluster = import_cluster()

    def pretend(version):
        from core.study import version as module

        module.core_version = lambda: version

    ours = core_version()
    cluster.check_workers(client, tmp_path)
    client.run(pretend, "another")
    try:
        with pytest.raises(cluster.StudyError, match=r"worker at .* has another version of Wayfarer"):
            cluster.check_workers(client, tmp_path)
    finally:
        client.run(pretend, ours)


def import_cluster():
    """The program that runs studies, as a module."""
    spec = importlib.util.spec_from_file_location("wayfarer_cluster", ROOT / "addon" / "cli" / "cluster.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
