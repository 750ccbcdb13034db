"""Large grounds on real clusters: Dask's scheduler and two worker processes on the loopback address."""

import os
import signal

import numpy as np
import pytest

from core.embedding.embedding import EmbeddingSettings, embed
from core.parcels.embedding import embed_parcels_steps
from core.parcels.problem import create_problem
from core.progress import finish

from .test_parcels import assembled, larger_problem


@pytest.fixture
def ground(tmp_path):
    """A problem of several parcels in a folder, and its embedding in one piece."""
    graph, environment = larger_problem(4, True)
    create_problem(tmp_path, graph, environment, EmbeddingSettings(), 8 * environment.grid.cell_size)
    return tmp_path, embed(graph, environment)


def test_two_workers_agree_with_one_process(client, ground):
    folder, whole = ground
    found = finish(embed_parcels_steps(folder, client.get_executor()))
    assert found.n_parcels > 1
    assert (found.n_nodes, found.n_links) == (whole.n_nodes, whole.n_links)
    assert np.array_equal(assembled(folder, whole), whole.node_mask())


def test_a_worker_that_is_killed_is_made_up_for(client, ground):
    folder, whole = ground
    steps = embed_parcels_steps(folder, client.get_executor())
    killed = False
    while True:
        try:
            progress = next(steps)
        except StopIteration as stop:
            found = stop.value
            break
        if not killed and progress.message.startswith(("reached", "component")):
            # Without a word, as a machine that is switched off.
            victim = next(iter(client.run(os.getpid).values()))
            os.kill(victim, signal.SIGKILL)
            killed = True
    assert killed
    assert (found.n_nodes, found.n_links) == (whole.n_nodes, whole.n_links)
    assert np.array_equal(assembled(folder, whole), whole.node_mask())
