"""Benchmarks of studies: what Dask costs for one scene, and what a second worker brings.

The study is that of the paper's room: one case embeds the recorded clips' motion graph and measures variability.
"""

import atexit
import shutil
import tempfile
from functools import cache
from itertools import count
from pathlib import Path

import distributed

from core.embedding.embedding import embed
from core.evaluation.variability import floor_variability
from core.motion.graph_archive import save_motion_graph
from core.progress import finish
from core.study.geometry import SceneGeometry, environment_of, load_scene, save_scene
from core.study.plan import plan_of
from core.study.run import run_study_steps
from tests.bench import problems
from tests.bench.benchmark import Benchmark
from tests.core.geometry import box_triangles

_number = count()


@cache
def _folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="wayfarer-bench-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    save_scene(SceneGeometry(box_triangles((3, 3, 0), (3.5, 4, 2)), (0, 0), (7, 8)), folder / "room.npz")
    save_motion_graph(problems.graph(0.12), folder / "graph.npz")
    return folder


@cache
def _client(n_workers: int):
    cluster = distributed.LocalCluster(
        n_workers=n_workers, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0"
    )
    client = distributed.Client(cluster)
    atexit.register(cluster.close)
    atexit.register(client.close)
    return client


def _study(n_cases: int, executor) -> dict:
    """Run a study of so many cases in a new folder: nothing is known from before."""
    radii = [0.2 + 0.01 * i for i in range(n_cases)]
    table = {
        "scenes": {"room": "room.npz"},
        "clips": {"graph": "graph.npz"},
        "settings": {"radius": radii},
        "measures": ["nodes", "total_variability"],
    }
    steps = run_study_steps(plan_of(table, _folder(), "bench"), _folder() / f"out-{next(_number)}", executor)
    outcome = finish(steps)
    numbers = [entry.result.numbers for entry in outcome.outcomes if entry.result is not None]
    return {"nodes": sum(n["nodes"] for n in numbers), "ways": sum(n["total_variability"] for n in numbers)}


def overhead() -> Benchmark:
    """One scene through Dask, with the files that make it resumable, against embedding and measuring it directly."""

    def directly() -> dict:
        embedding = embed(problems.graph(0.12), environment_of(load_scene(_folder() / "room.npz"), {"radius": 0.2}))
        return {"nodes": embedding.n_nodes, "ways": int(floor_variability(embedding).sum())}

    client = _client(1)
    client.wait_for_workers(1)
    return Benchmark(
        run=lambda: _study(1, client.get_executor(pure=False)),
        counts=dict,
        reference=directly,
        reference_counts=dict,
        reference_name="directly, in this process",
    )


def scaling() -> Benchmark:
    """Sixteen cases on two workers against one."""
    one, two = _client(1), _client(2)
    two.wait_for_workers(2)
    return Benchmark(
        run=lambda: _study(16, two.get_executor(pure=False)),
        counts=dict,
        reference=lambda: _study(16, one.get_executor(pure=False)),
        reference_counts=dict,
        reference_name="one worker",
        repeats=3,
    )


BENCHMARKS = {"study-dask": overhead, "study-workers": scaling}
