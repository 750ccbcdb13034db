"""Studies on real clusters: Dask's scheduler and two worker processes on the loopback address."""

import contextlib
import os
import signal
import time

import numpy as np
import pytest

from core.errors import StudyError
from core.study.geometry import save_scene
from core.study.run import run_study, run_study_steps
from core.study.tasks import measure_case

from .studies import lay_out, plan, region, room, rows_of

distributed = pytest.importorskip("distributed", reason="Dask is not installed")

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
    assert "KilledWorker" in outcome.outcomes[1].problem and "died" in outcome.outcomes[1].problem
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
    until = time.monotonic() + 120
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
