"""The floor that counts: what coverage is a share of, and where weak spots are sought.

Reitsma & Pollard count the grid elements at which a standing character would not be in collision. A region that
requires a tag stands for something that only that motion clears, such as a low obstacle to step over: there, a
character that just stands would be in collision too. Such a place counts where a walk stands on it all the same (in a
tunnel to crouch through), and is otherwise there to be crossed: neither reached nor missing.
"""

from collections.abc import Collection

import numpy as np

from ..embedding.embedding import Embedding
from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION
from ..environment.regions import RegionRule


def ruled_cells(environment: Environment, classes: Collection[frozenset[str]] = ()) -> np.ndarray:
    """(nx, ny) bool: free cells at whose centre a region requires a tag, or forbids all that there is to play.

    ``classes`` are the combinations of tags that frames carry (``embedding.unrolling.sweep.classes``); without any,
    only what is required counts.
    """
    middle = slice(SUBDIVISION // 2, None, SUBDIVISION)
    ruled = np.zeros(environment.grid.shape[:2], dtype=bool)
    for region in environment.regions:
        if region.rule is RegionRule.REQUIRE:
            ruled |= region.mask[middle, middle]
    if classes and environment.regions:
        ruled |= ~allowed_cells(environment, classes)
    return ruled & environment.free_cells()


def allowed_cells(environment: Environment, classes: Collection[frozenset[str]]) -> np.ndarray:
    """(nx, ny) bool: cells at whose centre frames of any of some combinations of tags may be played."""
    middle = slice(SUBDIVISION // 2, None, SUBDIVISION)
    allowed = np.zeros(environment.grid.shape[:2], dtype=bool)
    for tags in classes:
        allowed |= environment.free_samples(tags)[middle, middle]
    return allowed


def floor_cells(embedding: Embedding) -> np.ndarray:
    """(nx, ny) bool: the free floor. Cells at whose centre the character may stand, but for those under a region's
    rule (:func:`ruled_cells`) in which the embedding has no node."""
    environment = embedding.environment
    free = environment.free_cells()
    if not environment.regions:
        return free
    ruled = ruled_cells(environment, embedding.unrolling.sweep.classes)
    return free & ~(ruled & ~embedding.covered().any(axis=2))
