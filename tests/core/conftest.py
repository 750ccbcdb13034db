"""What all core tests share: the optional motion capture data, and repeatable property tests."""

import os
from pathlib import Path

import hypothesis
import pytest

# The same examples on every run and machine, and no time limits, which noisy machines break.
hypothesis.settings.register_profile("wayfarer", derandomize=True, deadline=None, max_examples=50)
hypothesis.settings.load_profile("wayfarer")


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of recorded motions (cmu16, cmu_locomotion, cmu_obstacle); skips the test without it."""
    beside = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    folder = Path(os.environ.get("WAYFARER_DATA", beside))
    if not folder.is_dir():
        pytest.skip(f"needs the recorded motions, and there is no folder {folder}: set WAYFARER_DATA to theirs")
    return folder


def pytest_collection_modifyitems(items):
    """Run the tests with Dask at the end: its threads live on, and what they allocate would count as others' memory."""
    items.sort(key=lambda item: item.path.stem.endswith("_cluster"))


@pytest.fixture(scope="session")
def dask_client():
    """A client of Dask's scheduler with two worker processes on the loopback address, started once."""
    dask, distributed = (pytest.importorskip(name, reason="Dask is not installed") for name in ("dask", "distributed"))
    # Workers that start on a busy machine take long to be heard.
    with dask.config.set({"distributed.comm.timeouts.connect": "300s"}):
        cluster = distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0"
        )
    with cluster, distributed.Client(cluster) as client:
        yield client


@pytest.fixture
def client(dask_client):
    """The same, with both workers there: an earlier test may have killed one."""
    dask_client.wait_for_workers(2, timeout=300)
    return dask_client
