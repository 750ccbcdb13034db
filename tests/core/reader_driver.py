"""Runs the reference reader of the engine format over some folders, in a process that knows NumPy and nothing else.

python reader_driver.py READER_FOLDER FOLDER ...: writes what it finds to FOLDER/found.npz.
"""

import sys
from pathlib import Path

sys.path.insert(0, sys.argv[1])

import numpy as np
import wayfarer_reader


def look(folder):
    embedding = wayfarer_reader.Embedding(folder)
    nodes = embedding.all_nodes()
    order = np.lexsort(nodes.T[::-1])
    nodes = nodes[order]
    shape = (embedding.nx, embedding.ny, embedding.n_headings, len(embedding.segments))
    here = [tuple(node) for node in nodes.tolist()]

    def number(node):
        return int(np.ravel_multi_index((node[0] % shape[0], node[1] % shape[1], node[2], node[3]), shape))

    leaving = [(number(node), k, number(end)) for node in here for k, end in embedding.links_from(node)]
    arriving = [(number(start), k, number(node)) for node in here for k, start in embedding.links_to(node)]
    rng = np.random.default_rng(1)
    goal = [here[rng.integers(len(here))][:2] for _ in range(2)]
    times = embedding.times_to(goal)
    start = embedding.any_node(rng)
    walk = embedding.random_walk(start, 60.0, rng)
    ways = []
    for _ in range(20):
        whence = here[rng.integers(len(here))]
        way = embedding.shortest_walk(whence, times)
        last = way[-1][1] if way else whence
        frames = sum(embedding.n_frames[node[3]] for _, node in way)
        at_goal = (last[0] % shape[0], last[1] % shape[1]) in goal
        ways.append((frames, times[whence], at_goal))
    table = wayfarer_reader.read_table(folder)
    np.savez(
        Path(folder) / "found.npz",
        nodes=nodes,
        leaving=np.array(leaving).reshape(-1, 3),
        arriving=np.array(arriving).reshape(-1, 3),
        goal=np.array(goal),
        times=np.array([times[node] for node in here]),
        states=np.array([start, *(node for _, node in walk)]),
        stencils=np.array([k for k, _ in walk]),
        path=embedding.root_path(start, walk),
        ways=np.array(ways, dtype=int),
        **{f"table_{name}": array for name, array in zip(("nodes", "first", "links"), table)},
    )


for name in sys.argv[2:]:
    look(name)
sys.stdout.write(f"{sorted({'core', 'scipy', 'bpy'} & set(sys.modules))}\n")
