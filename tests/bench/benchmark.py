"""What a benchmark is, and how it is measured."""

import statistics
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass
class Benchmark:
    """What is timed, the obvious way to do the same (None where there is none to compare with), and their results.

    ``counts`` turns a result into numbers for the record; both ways must agree on those of the same name. What is
    started in a process of its own is run once, and tells its ``peak_mb`` among the counts.
    """

    run: Callable[[], object]
    counts: Callable[[object], dict] = field(default=lambda _: {})
    reference: Callable[[], object] | None = None
    reference_counts: Callable[[object], dict] = field(default=lambda _: {})
    reference_name: str | None = None
    repeats: int = 5
    reference_repeats: int = 3
    own_process: bool = False


def measure(name: str, benchmark: Benchmark) -> dict:
    """One record of the results file: medians, with the reference run in turn; memory in a run of its own."""
    if benchmark.own_process:
        start = time.perf_counter()
        counts = benchmark.counts(benchmark.run())
        alone = {"reference": None, "reference_seconds": None, "ratio": None}
        return {"name": name, "seconds": time.perf_counter() - start, **alone, **counts}
    seconds, reference_seconds = [], []
    record = {"name": name, **benchmark.counts(benchmark.run())}
    for turn in range(benchmark.repeats):
        seconds.append(_timed(benchmark.run))
        if benchmark.reference and turn < benchmark.reference_repeats:
            start = time.perf_counter()
            result = benchmark.reference()
            reference_seconds.append(time.perf_counter() - start)
            for key, value in benchmark.reference_counts(result).items():
                if record.setdefault(key, value) != value:
                    raise SystemExit(f"{name}: {key} is {record[key]}, but the reference says {value}.")
    tracemalloc.start()
    benchmark.run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    record["seconds"] = statistics.median(seconds)
    record["peak_mb"] = peak / 1e6
    record["reference"] = benchmark.reference_name
    record["reference_seconds"] = statistics.median(reference_seconds) if reference_seconds else None
    record["ratio"] = record["reference_seconds"] / record["seconds"] if reference_seconds else None
    return record


def _timed(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def line(record: dict) -> str:
    """The record for the terminal."""
    figures = f"{record['name']:15s}{record['seconds']:8.3f} s {record['peak_mb']:8.1f} MB"
    if record["ratio"]:
        figures += (
            f"   {record['ratio']:5.1f} times faster than {record['reference']} ({record['reference_seconds']:.2f} s)"
        )
    known = ("name", "seconds", "peak_mb", "reference", "reference_seconds", "ratio")
    told = {key: value if isinstance(value, str) else f"{value:,}" for key, value in record.items() if key not in known}
    counts = ", ".join(f"{value} {key}" for key, value in told.items())
    return f"{figures}   {counts}"
