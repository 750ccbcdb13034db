"""Benchmarks: ``python3 dev.py bench [NAME ...] [--json FILE]``.

Each figure stands beside the obvious way to get the same result, measured in the same process, in turn: the machine
may be noisy, the ratio is not. Times are medians of several runs.
"""

import argparse
import json
import statistics
import sys
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.evaluation.variability import floor_variability
from core.motion.graph import MotionGraphSettings, build_motion_graph
from core.playback.synthesis import synthesize
from core.playback.walk import random_walk
from tests.bench import problems
from tests.bench.explicit import embed_explicitly


@dataclass
class Benchmark:
    """What is timed, the obvious way to do the same (None where there is none to compare with), and their results.

    ``counts`` turns a result into numbers for the record; both ways must agree on those of the same name.
    """

    run: Callable[[], object]
    reference: Callable[[], object] | None = None
    counts: Callable[[object], dict] = field(default=lambda _: {})
    reference_counts: Callable[[object], dict] = field(default=lambda _: {})
    repeats: int = 5


def motion_graph() -> Benchmark:
    """Clips to motion graph (resampling, contacts, costs, cutting, component)."""
    clips = list(problems.clips())
    return Benchmark(
        lambda: build_motion_graph(clips, MotionGraphSettings()),
        counts=lambda graph: {"segments": len(graph.segments), "links": len(graph.links)},
    )


def _embedding(max_cost: float, footprint: FootprintSettings, repeats: int) -> Benchmark:
    graph, environment = problems.graph(max_cost), problems.room()
    settings = EmbeddingSettings(footprint)

    def counts(embedding):
        return {"nodes": embedding.n_nodes, "links": embedding.n_links}

    return Benchmark(
        lambda: embed(graph, environment, settings),
        lambda: embed_explicitly(graph, environment, settings),
        counts,
        lambda result: dict(zip(("nodes", "links"), result, strict=True)),
        repeats,
    )


def embed_room() -> Benchmark:
    """The paper's room, 7 x 8 m in cells of 12.5 cm and 24 headings, with a tight motion graph."""
    return _embedding(0.12, FootprintSettings(), 5)


def embed_room_default() -> Benchmark:
    """The same room with the default threshold, and so several times the links."""
    return _embedding(MotionGraphSettings().max_cost, FootprintSettings(), 3)


def variability_map() -> Benchmark:
    """From an embedding to the floor map of variability."""
    embedding = embed(problems.graph(0.12), problems.room())

    def run():
        # A fresh object, because an embedding remembers its degrees.
        fresh = type(embedding)(**{name: getattr(embedding, name) for name in embedding.__dataclass_fields__})
        return floor_variability(fresh)

    def by_links():
        _, links = embedding.to_csr()
        return np.diff(links.indptr) * np.diff(links.tocsc().indptr)

    return Benchmark(
        run,
        by_links,
        lambda floor: {"total": int(floor.sum())},
        # The matrix keeps one entry for links between the same two nodes, so that its total may be lower.
        lambda _: {},
    )


def minute_of_walking() -> Benchmark:
    """A random walk of 60 s and its poses."""
    embedding = embed(problems.graph(0.12), problems.room())
    _ = embedding.network
    return Benchmark(
        lambda: synthesize(random_walk(embedding, np.random.default_rng(0), 60.0)),
        counts=lambda clip: {"frames": clip.n_frames},
    )


BENCHMARKS = {
    "graph": motion_graph,
    "embed": embed_room,
    "embed-default": embed_room_default,
    "variability": variability_map,
    "walk": minute_of_walking,
}


def measure(name: str, benchmark: Benchmark) -> dict:
    """One record of the results file."""
    seconds, reference_seconds = [], []
    result = benchmark.run()
    record = {"name": name, **benchmark.counts(result)}
    for turn in range(benchmark.repeats):
        seconds.append(_timed(benchmark.run))
        if benchmark.reference and turn < 3:
            start = time.perf_counter()
            expected = benchmark.reference_counts(benchmark.reference())
            reference_seconds.append(time.perf_counter() - start)
            for key, value in expected.items():
                if record[key] != value:
                    raise SystemExit(f"{name}: {key} is {record[key]}, but the reference says {value}.")
    del result
    tracemalloc.start()
    benchmark.run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    record["seconds"] = statistics.median(seconds)
    record["peak_mb"] = peak / 1e6
    record["reference"] = benchmark.reference.__name__ if benchmark.reference else None
    record["reference_seconds"] = statistics.median(reference_seconds) if reference_seconds else None
    record["ratio"] = record["reference_seconds"] / record["seconds"] if reference_seconds else None
    return record


def _timed(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(prog="dev.py bench", description=__doc__)
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"which to run: {', '.join(BENCHMARKS)}; all by default"
    )
    parser.add_argument("--json", type=Path, help="write the records to this file")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in BENCHMARKS]
    if unknown:
        parser.error(f"no benchmark called {', '.join(unknown)}; there are {', '.join(BENCHMARKS)}")
    records = []
    for name in arguments.names or BENCHMARKS:
        record = measure(name, BENCHMARKS[name]())
        records.append(record)
        figures = f"{record['seconds']:8.3f} s {record['peak_mb']:8.1f} MB"
        if record["ratio"]:
            figures += f"   reference {record['reference_seconds']:7.2f} s, {record['ratio']:.1f} times as long"
        known = ("name", "seconds", "peak_mb", "reference", "reference_seconds", "ratio")
        counts = ", ".join(f"{value:,} {key}" for key, value in record.items() if key not in known)
        print(f"{name:15s}{figures}   {counts}", flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(records, indent=2) + "\n")


if __name__ == "__main__":
    main()
