"""Turn balance: does the character turn left as easily as right? For every place, and in total.

Each link counts with the angle that it turns by, the heading that it arrives in less the one that it starts from.
"""

from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding


@dataclass(frozen=True)
class TurnBalance:
    """Turns to the left and to the right over the links that start at each place.

    Attributes
    ----------
    left, right : (nx, ny) float array
        Radians that all links that start in a cell turn by, in each direction.
    balance : (nx, ny) float array
        (left - right) / (left + right): 1 where all turns go left, -1 where all go right, 0 where both weigh the same;
        not a number where no link turns.
    n_left, n_right, n_straight : int
        Links of each direction.
    total : float
        The balance of all links together, -1 to 1; 0 if none turns.
    """

    left: np.ndarray
    right: np.ndarray
    balance: np.ndarray
    n_left: int
    n_right: int
    n_straight: int
    total: float

    def describe(self) -> str:
        n_links = self.n_left + self.n_right + self.n_straight
        if not n_links:
            return "There are no links, so nothing turns."
        tendency = (
            "to neither side more" if abs(self.total) < 0.05 else "more " + ("left" if self.total > 0 else "right")
        )
        leaning = np.count_nonzero(np.abs(self.balance) > 0.5)
        places = np.count_nonzero(self.left + self.right)
        return (
            f"{wording.share(self.n_left / n_links)} of the links turn left, {wording.share(self.n_right / n_links)} "
            f"right and {wording.share(self.n_straight / n_links)} not at all; by angle the character turns {tendency} "
            f"(balance {wording.balance(self.total)}), and {wording.share_of(leaning, places)} of the places lean "
            "clearly to one side."
        )


def turn_balance(embedding: Embedding) -> TurnBalance:
    """Left and right turns of the links of an embedding."""
    network, stencils = embedding.network, embedding.unrolling.stencils
    nx, ny, n_headings, _ = embedding.shape
    unpack = network.layout.unpack
    # starting[heading][entry group]: the turn and start cells of each stencil that is played from there.
    starting: list[dict[int, list[tuple[int, int]]]] = [{} for _ in range(n_headings)]
    rows = zip(stencils.segment.tolist(), stencils.heading.tolist(), stencils.turn.tolist(), embedding.able_starts())
    for segment, heading, turn, able in rows:
        if able:
            starting[heading].setdefault(network.entry_group_of[segment], []).append((turn, able))
    radians = {1: np.zeros((nx, ny)), -1: np.zeros((nx, ny))}
    n_links = {1: 0, -1: 0, 0: 0}
    step = embedding.environment.grid.heading_step
    for heading, entry_groups in enumerate(starting):
        standing = np.stack([unpack(plane) for plane in embedding.planes[heading::n_headings]])
        for entry_group, moves in entry_groups.items():
            # How many nodes stand in each cell that any of these links may start from.
            alive = standing[network.parents[network.entry_groups[entry_group][0]]].sum(axis=0, dtype=np.int32)
            for turn, able in moves:
                links = alive * unpack(able)
                side = (turn > 0) - (turn < 0)
                n_links[side] += int(links.sum())
                if side:
                    radians[side] += links * (abs(turn) * step)
    left, right = radians[1], radians[-1]
    both = left + right
    balance = np.divide(left - right, both, out=np.full((nx, ny), np.nan), where=both > 0)
    total = float((left.sum() - right.sum()) / both.sum()) if both.any() else 0.0
    return TurnBalance(left, right, balance, n_links[1], n_links[-1], n_links[0], total)
