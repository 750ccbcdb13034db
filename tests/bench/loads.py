"""Loads beyond any everyday scene: 500 clips, a rig of 300 bones, two million triangles, a hundred embeddings.

``python3 dev.py bench load_clips load_bones load_triangles load_again load_actions``. There is nothing to compare them
with but for ``import_bvh``; what counts is that they end, and what they take.
"""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from core.embedding.embedding import Embedding, embed
from core.environment.environment import Environment, build_environment
from core.environment.grid import Grid
from core.motion.clip import MotionClip
from core.motion.graph import MotionGraph, MotionGraphSettings, build_motion_graph
from core.motion.repertoire import sample_repertoire
from core.motion.skeleton import Skeleton
from tests.bench.benchmark import Benchmark


def _graph_counts(graph: MotionGraph) -> dict:
    return {"clips": len(graph.clips), "segments": len(graph.segments), "links": len(graph.links)}


def _noisy(clip: MotionClip, rng: np.random.Generator, name: str) -> MotionClip:
    """The same motion, differently performed: every joint holds itself a little differently."""
    rotations = clip.rotations + rng.normal(0, 0.02, (1, *clip.rotations.shape[1:]))
    rotations /= np.linalg.norm(rotations, axis=2, keepdims=True)
    return replace(clip, name=name, rotations=rotations)


def five_hundred_clips() -> Benchmark:
    rng, sample = np.random.default_rng(0), sample_repertoire()
    clips = [_noisy(sample[i % len(sample)], rng, f"clip {i}") for i in range(500)]
    settings = MotionGraphSettings(max_cost=0.1, n_starts=1)
    return Benchmark(lambda: build_motion_graph(clips, settings), counts=_graph_counts, repeats=1)


def three_hundred_bones() -> Benchmark:
    """The sample's clips on a rig with many more bones: tails of straps and cloth at its joints."""
    rng, sample = np.random.default_rng(0), sample_repertoire()
    skeleton = sample[0].skeleton
    n_more = 300 - skeleton.n_joints
    more = np.tile([1.0, 0, 0, 0], (n_more, 1))
    parents = np.concatenate([skeleton.parents, rng.integers(0, skeleton.n_joints, n_more)])
    rig = Skeleton(
        (*skeleton.names, *(f"strap.{i:03}" for i in range(n_more))),
        parents,
        np.concatenate([skeleton.rest_rotations, more]),
        np.concatenate([skeleton.rest_translations, rng.normal(0, 0.05, (n_more, 3))]),
        skeleton.forward,
    )
    clips = []
    for clip in sample:
        tails = np.tile(more, (clip.n_frames, 1, 1))
        places = np.tile(rig.rest_translations[skeleton.n_joints :], (clip.n_frames, 1, 1))
        rotations = np.concatenate([clip.rotations, tails], axis=1)
        clips.append(
            replace(
                clip, skeleton=rig, rotations=rotations, translations=np.concatenate([clip.translations, places], 1)
            )
        )
    return Benchmark(lambda: build_motion_graph(clips), counts=_graph_counts, repeats=1)


def two_million_triangles() -> Benchmark:
    """A terrain to walk on, with a tower."""
    x, y = np.meshgrid(np.linspace(-50, 50, 1001), np.linspace(-50, 50, 1001), indexing="ij")
    z = 0.01 * np.sin(x) + 3.0 * (np.hypot(x - 2, y + 2) < 4)
    points = np.stack([x, y, z], axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    triangles = np.concatenate([np.stack(corners, axis=-2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])
    grid = Grid.over_rectangle((-50, -50), (50, 50), 0.125, 24)
    return Benchmark(
        lambda: build_environment(grid, triangles),
        counts=lambda made: {"triangles": len(triangles), "free_cells": int(made.free_cells().sum())},
        repeats=1,
    )


def a_hundred_embeddings() -> Benchmark:
    """A pillar that is moved a hundred times, each time embedded on what was known before."""
    graph = build_motion_graph(sample_repertoire()[:12])
    grid = Grid.over_rectangle((0, 0), (8, 8), 0.2, 16)

    def run() -> Embedding | None:
        embedding = None
        for k in range(100):
            blocked = np.zeros((grid.shape[0] * 4, grid.shape[1] * 4), dtype=bool)
            blocked[k : k + 20, 60:80] = True
            embedding = embed(graph, Environment(grid, blocked), previous=embedding)
        return embedding

    return Benchmark(run, counts=lambda made: {"nodes": made.n_nodes}, repeats=1)


def five_hundred_actions() -> Benchmark:
    """The same through the add-on: actions listed, read, examined and made a graph of, in Blender."""
    return _in_blender("actions", 500)


def hundred_bvh_files() -> Benchmark:
    """A folder of BVH files becomes the actions of one armature; beside it Blender's own importer."""
    return _in_blender("files", 100)


def _in_blender(load: str, size: int) -> Benchmark:
    def run() -> str:
        command = [sys.executable, str(Path(__file__).with_name("blender_loads.py")), load, str(size)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    return Benchmark(run, counts=lambda told: json.loads(told.rpartition("RECORD ")[2]), own_process=True)


BENCHMARKS = {
    "import_bvh": hundred_bvh_files,
    "load_actions": five_hundred_actions,
    "load_clips": five_hundred_clips,
    "load_bones": three_hundred_bones,
    "load_triangles": two_million_triangles,
    "load_again": a_hundred_embeddings,
}
