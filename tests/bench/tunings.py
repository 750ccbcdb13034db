"""Benchmarks of pruning."""

import numpy as np
from scipy.sparse.csgraph import connected_components

from core.embedding.embedding import Embedding, embed
from core.progress import finish
from core.tuning.budget import BudgetSettings, prune_to_budget_steps
from core.tuning.global_pruning import prune_global_steps
from core.tuning.local_pruning import prune_local_steps
from core.tuning.pruning_curve import pruning_curve_steps
from tests.bench import problems
from tests.bench.benchmark import Benchmark

#: Segments that local pruning keeps at each place.
KEPT = 5


def _room() -> Embedding:
    embedding = embed(problems.graph(0.12), problems.room())
    # Counted and packed once, as wherever an embedding is at hand.
    assert embedding.n_links and embedding.nodes
    return embedding


def local() -> Benchmark:
    """The five best segments at each place, and the largest component of what is left."""
    embedding = _room()

    def by_links():
        nodes, links = embedding.to_csr()
        ways = np.diff(links.indptr).astype(np.int64) * np.bincount(links.indices, minlength=len(nodes))
        x, y, heading, segment = nodes.T
        place = np.ravel_multi_index((x, y, heading), embedding.shape[:3])
        order = np.lexsort((segment, -ways, place))
        first = np.flatnonzero(np.diff(place[order], prepend=-1))
        rank = np.arange(len(order)) - np.repeat(first, np.diff(np.append(first, len(order))))
        kept = np.sort(order[rank < KEPT])
        inside = links[kept][:, kept]
        _, label = connected_components(inside, connection="strong")
        largest = label == np.bincount(label).argmax()
        return int(largest.sum()), int(inside[largest][:, largest].nnz)

    return Benchmark(
        run=lambda: finish(prune_local_steps(embedding, KEPT)),
        counts=lambda pruned: {"nodes": pruned.n_nodes, "links": pruned.n_links},
        reference=by_links,
        reference_counts=lambda result: dict(zip(("nodes", "links"), result, strict=True)),
        reference_name="explicit links, sorted, SciPy's strong components",
        reference_repeats=1,
    )


def global_() -> Benchmark:
    """Global pruning to a third of the segments, counting variability anew after each drop."""
    embedding = _room()
    n_segments = embedding.shape[3] // 3
    return Benchmark(
        run=lambda: finish(prune_global_steps(embedding, n_segments)),
        counts=lambda pruned: {"dropped": len(pruned.dropped), "links": pruned.embedding.n_links},
        repeats=3,
    )


def curve() -> Benchmark:
    """Local pruning for every k; the reference ranks and searches anew each time."""
    embedding = _room()
    largest = int(embedding.node_mask().sum(axis=3).max())

    def one_by_one():
        return [finish(prune_local_steps(embedding, k)).n_links for k in range(1, largest + 1)]

    return Benchmark(
        run=lambda: finish(pruning_curve_steps(embedding)),
        counts=lambda curve: {"k": len(curve.k), "links": int(curve.n_links.sum())},
        reference=one_by_one,
        reference_counts=lambda links: {"k": len(links), "links": sum(links)},
        reference_name="local pruning for each k",
        repeats=3,
        reference_repeats=1,
    )


def budget() -> Benchmark:
    """As many links as local pruning to five would keep, without losing a cell."""
    embedding = _room()
    settings = BudgetSettings(budget=finish(prune_local_steps(embedding, KEPT)).n_links)
    return Benchmark(
        run=lambda: finish(prune_to_budget_steps(embedding, settings)),
        counts=lambda pruned: {"links": pruned.cost, "cells": pruned.places, "of": pruned.places_before},
        repeats=3,
    )


BENCHMARKS = {"prune-local": local, "prune-global": global_, "prune-curve": curve, "prune-budget": budget}
