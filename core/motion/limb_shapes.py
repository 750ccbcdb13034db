"""Legs and arms by the shape of the rest pose: pairs of alike chains, where no names say which they are."""

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

import numpy as np

from .kinematics import ancestors

_APART = 0.01
"""Share of the skeleton's size: joints nearer to each other than this are one."""
_ALIKE = 0.12
"""Relative difference up to which two bones are a left and a right one."""
_LOW = 0.15
"""Share of the height up to which a chain that ends there ends on the ground."""
_LEG = 0.25
"""Share of the height that a leg spans at least."""
_TIP = 0.45
"""Share of a limb's length that foot or hand have at most."""

_ABOVE_HIPS = 0.15
"""Share of the legs' length that shoulders are above the hips, at least."""

Limb = tuple[int, ...]
_UP = np.array([0.0, 0.0, 1.0])


def find_legs(
    parents: np.ndarray, positions: np.ndarray, sides: Sequence[str], left: np.ndarray | None = None
) -> tuple[Limb, Limb] | None:
    """Find the left and the right leg of a rest pose that stands upright: (thigh, shin, foot), and toes if there are.

    Two chains that part at the hips, end on the ground and are of the same lengths. ``sides`` holds the side that each
    joint's name speaks of; ``left`` (3,) decides where none does, and toes show where left is if that is not given.
    None if there are no such two.

    Parameters
    ----------
    parents, positions : (J,) int, (J, 3) float array
        One or several trees, and where the joints are in metres.
    """
    heights, size = positions[:, 2], float(np.ptp(positions, axis=0).max())
    height = float(np.ptp(heights))
    if height < 0.3 * size or size == 0:
        return None
    best, result = 0.0, None
    leaves = [leaf for leaf in _leaves(parents) if heights[leaf] < heights.min() + _LOW * height]
    for limbs in _alike_limbs(parents, positions, leaves):
        drop = min(heights[limb[0]] - heights[limb[2]] for limb in limbs)
        upper = min(heights[limb[0]] - heights[limb[1]] for limb in limbs)
        if drop > max(_LEG * height, best + 1e-3 * size) and upper > 0.2 * drop:
            best, result = drop, limbs
    return None if result is None else _left_first(positions, sides, left, *result)


def find_arms(
    parents: np.ndarray, positions: np.ndarray, sides: Sequence[str], leg_left: Limb, leg_right: Limb
) -> tuple[Limb, Limb] | None:
    """Find the left and the right arm, (upper arm, lower arm, hand), of a skeleton whose legs are known.

    Two alike chains that begin above the hips (a skirt begins at them), and have a hand below them. None if there are
    no such two. Legs are (thigh, ..., foot).
    """
    size = float(np.ptp(positions, axis=0).max())
    thighs = {leg_left[0], leg_right[0]}
    across = positions[leg_left[0]] - positions[leg_right[0]]
    hips = 0.5 * (positions[leg_left[0]] + positions[leg_right[0]])
    up = hips - 0.5 * (positions[leg_left[-1]] + positions[leg_right[-1]])
    leaves = [leaf for leaf in _leaves(parents) if not thighs & {leaf, *ancestors(parents, leaf)}]
    best, result = 0.1 * size, None
    for a, b in _alike_limbs(parents, positions, leaves):
        apart = abs((positions[a[0]] - positions[b[0]]) @ across)
        length = float(np.linalg.norm(positions[a[0]] - positions[a[2]]))
        begins = min((positions[limb[0]] - hips) @ up for limb in (a, b))
        if begins < _ABOVE_HIPS * (up @ up):
            continue
        if length > best + 1e-3 * size and apart > 0.02 * size * np.linalg.norm(across):
            best, result = length, (a[:3], b[:3])
    return None if result is None else _left_first(positions, sides, across, *result)


def toes_direction(positions: np.ndarray, legs: Sequence[Limb]) -> np.ndarray | None:
    """Return the (..., 3) horizontal unit vectors that the feet of poses (..., J, 3) point along.

    Zeros where they point nowhere; None if they do so in all poses, or have no toes.
    """
    if any(len(leg) < 4 for leg in legs):
        return None
    foot = sum(positions[..., leg[3], :] - positions[..., leg[2], :] for leg in legs) * [1.0, 1.0, 0.0]
    length = np.linalg.norm(foot, axis=-1, keepdims=True)
    leg = np.linalg.norm(positions[..., legs[0][0], :] - positions[..., legs[0][2], :], axis=-1, keepdims=True)
    points = length > 0.05 * leg
    return np.where(points, foot / np.where(points, length, 1.0), 0.0) if points.any() else None


def _left_first(
    positions: np.ndarray, sides: Sequence[str], left: np.ndarray | None, a: Limb, b: Limb
) -> tuple[Limb, Limb]:
    votes = [sum((sides[joint] == "left") - (sides[joint] == "right") for joint in limb) for limb in (a, b)]
    if votes[0] != votes[1]:
        return (a, b) if votes[0] > votes[1] else (b, a)
    if left is None:
        forward = toes_direction(positions, (a, b))
        left = np.cross(_UP, [0.0, -1.0, 0.0] if forward is None else forward)
    across = sum(positions[a[i]] - positions[b[i]] for i in range(3))
    return (a, b) if across @ left >= 0 else (b, a)


def _alike_limbs(parents: np.ndarray, positions: np.ndarray, leaves: Sequence[int]) -> Iterator[tuple[Limb, Limb]]:
    """Yield each two limbs that end at ``leaves``, part somewhere, and are alike."""
    size = float(np.ptp(positions, axis=0).max())
    known: dict[tuple[int, int], Limb | None] = {}
    for pair in combinations(leaves, 2):
        chains = _chains(parents, *pair)
        n_shared = min(map(len, chains))
        # What one hand holds makes its chain longer than the other.
        for a, b in (chains, (chains[0][:n_shared], chains[1][:n_shared])):
            for chain in (a, b):
                if chain and (chain[0], chain[-1]) not in known:
                    known[chain[0], chain[-1]] = _limb(chain, positions, size)
            limbs = [known[chain[0], chain[-1]] if chain else None for chain in (a, b)]
            if limbs[0] and limbs[1] and _are_alike(positions, limbs[0], limbs[1]):
                yield limbs[0], limbs[1]
                break


def _leaves(parents: np.ndarray) -> list[int]:
    return np.setdiff1d(np.arange(len(parents)), parents).tolist()


def _chains(parents: np.ndarray, a: int, b: int) -> tuple[list[int], list[int]]:
    """The joints from where two leaves part, that one left out, to each leaf."""
    up_a, up_b = [a, *ancestors(parents, a)], [b, *ancestors(parents, b)]
    shared = next((joint for joint in up_a if joint in up_b), None)
    if shared is None:
        return up_a[::-1], up_b[::-1]  # two trees: legs that hang from nothing
    return up_a[: up_a.index(shared)][::-1], up_b[: up_b.index(shared)][::-1]


def _limb(chain: list[int], positions: np.ndarray, size: float) -> Limb | None:
    """Choose the joints of a two-bone limb from a chain, and the next one after them.

    Upper and lower bone are about as long, joints in between (twist bones) lie on them, what comes before is left out
    only if it leads elsewhere, and what comes after is short.
    """
    # Of several at one place the first turns what lies below.
    kept = [chain[0]]
    kept += [b for a, b in pairwise(chain) if np.linalg.norm(positions[a] - positions[b]) > _APART * size]
    if not 3 <= len(kept) <= 16:
        return None
    points = positions[kept]
    best, result = np.inf, None
    for i, j, k in combinations(range(len(kept)), 3):
        upper, lower = points[j] - points[i], points[k] - points[j]
        lengths = float(np.linalg.norm(upper)), float(np.linalg.norm(lower))
        if min(lengths) < 0.03 * size or not 0.45 < lengths[0] / lengths[1] < 2.2:
            continue
        limb = sum(lengths)
        before = np.linalg.norm(np.diff(points[: i + 1], axis=0), axis=1).sum()
        after = np.linalg.norm(np.diff(points[k:], axis=0), axis=1).sum()
        if after > _TIP * limb:
            continue
        stray = sum(_off_line(points[m], points[i], upper) for m in range(i + 1, j))
        stray += sum(_off_line(points[m], points[j], lower) for m in range(j + 1, k))
        cost = (
            8 * stray / limb + abs(np.log(lengths[0] / lengths[1])) + 0.5 * (before + after) / limb + 0.1 * (k - i - 2)
        )
        if cost < best:
            best, result = cost, tuple(kept[m] for m in (i, j, k, *range(k + 1, min(k + 2, len(kept)))))
    return result


def _off_line(point: np.ndarray, start: np.ndarray, along: np.ndarray) -> float:
    """Metres from a point to the line through ``start`` along a vector."""
    return float(np.linalg.norm(np.cross(point - start, along)) / np.linalg.norm(along))


def _are_alike(positions: np.ndarray, a: Limb, b: Limb) -> bool:
    """Test whether two limbs have bones of the same lengths and begin at the same height."""
    lengths = np.array(
        [[np.linalg.norm(positions[limb[i + 1]] - positions[limb[i]]) for i in (0, 1)] for limb in (a, b)]
    )
    return bool(np.abs(lengths[0] - lengths[1]).max() < _ALIKE * lengths.max())
