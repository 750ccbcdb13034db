"""The transition costs of all pairs of frames at once, which the core's search for close pairs must agree with."""

import numpy as np

from core.motion.distance import BLOCK_ELEMENTS, PoseFeatures, squared_angles


def transition_costs(features_a: PoseFeatures, features_b: PoseFeatures) -> np.ndarray:
    """Return the (A, B) float32 cost of switching from each frame of ``features_a`` to each of ``features_b``.

    See :func:`core.motion.distance.pair_costs`. Needs A x B x 4 bytes and a little more.
    """
    costs = np.empty((features_a.n_frames, features_b.n_frames), dtype=np.float32)
    rotations_a, rotations_b = (
        np.ascontiguousarray(features.rotations.transpose(1, 0, 2), dtype=np.float32)
        for features in (features_a, features_b)
    )
    centre = features_b.vectors.mean(axis=0)
    vectors_a, vectors_b = features_a.vectors - centre, features_b.vectors - centre
    squares_b = np.einsum("fm,fm->f", vectors_b, vectors_b)
    height = max(1, BLOCK_ELEMENTS // max(1, features_b.n_frames))
    for top in range(0, features_a.n_frames, height):
        rows = slice(top, top + height)
        # Velocities may be large and nearly equal: their difference needs double precision, angles do not.
        block = vectors_a[rows] @ vectors_b.T
        block *= -2
        block += np.einsum("fm,fm->f", vectors_a[rows], vectors_a[rows])[:, None]
        block += squares_b
        total = np.maximum(block, 0).astype(np.float32)
        for weight, of_a, of_b in zip(features_a.weights, rotations_a, rotations_b, strict=True):
            angles = squared_angles(of_a[rows] @ of_b.T)
            angles *= np.float32(weight)
            total += angles
        costs[rows] = total
    return costs
