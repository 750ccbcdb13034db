"""Benchmarks: ``python3 dev.py bench [NAME ...] [--json FILE]``.

Each figure stands beside the obvious way to get the same result, measured in the same process, in turn: the machine
may be noisy, the ratio is not. Times are medians of several runs.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.bench import (
    ablations,
    embeddings,
    evaluations,
    graphs,
    loads,
    obstacles,
    parcels,
    playbacks,
    reaches,
    studies,
    tunings,
)
from tests.bench.benchmark import line, measure

BENCHMARKS = {
    **graphs.BENCHMARKS,
    **embeddings.BENCHMARKS,
    **parcels.BENCHMARKS,
    **evaluations.BENCHMARKS,
    **reaches.BENCHMARKS,
    **ablations.BENCHMARKS,
    **tunings.BENCHMARKS,
    **playbacks.BENCHMARKS,
    **studies.BENCHMARKS,
    **loads.BENCHMARKS,
    **obstacles.BENCHMARKS,
}


def main() -> None:
    parser = argparse.ArgumentParser(prog="dev.py bench", description=__doc__)
    names = ", ".join(BENCHMARKS)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"which to run: {names}; all by default")
    parser.add_argument("--json", type=Path, help="write the records to this file")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in BENCHMARKS]
    if unknown:
        parser.error(f"no benchmark called {', '.join(unknown)}; there are {names}")
    records = []
    for name in arguments.names or BENCHMARKS:
        benchmark = BENCHMARKS[name]()
        if benchmark is None:
            print(f"{name:15s}left out: its recorded motions are not at hand (WAYFARER_DATA)", flush=True)
            continue
        records.append(measure(name, benchmark))
        print(line(records[-1]), flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(records, indent=2) + "\n")


if __name__ == "__main__":
    main()
