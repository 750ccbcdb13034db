"""The algebra of rotations agrees with SciPy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.motion import quat
from core.motion.kinematics import local_transforms, world_transforms

from .rotations import as_quaternions, as_rotation

A, B = (Rotation.random(200, rng=seed).as_quat(scalar_first=True) for seed in (1, 2))
VECTORS = np.random.default_rng(3).standard_normal((200, 3))


def same(q, rotation):
    """Both are the same rotations, up to the quaternions' signs."""
    assert np.allclose(np.linalg.norm(q, axis=-1), 1)
    return np.max((as_rotation(q).inv() * rotation).magnitude()) < 1e-7


def test_products_inverses_and_turned_vectors():
    a, b = as_rotation(A), as_rotation(B)
    assert np.allclose(quat.multiply(A, B), as_quaternions(a * b, (200,)), atol=1e-14)
    assert same(quat.multiply(A, B, quat.inverse(A)), a * b * a.inv())
    assert np.allclose(quat.rotate(A, VECTORS), a.apply(VECTORS), atol=1e-14)
    assert np.allclose(quat.rotate(A[0], VECTORS), a[0].apply(VECTORS), atol=1e-14)
    assert np.allclose(quat.rotate(A, VECTORS[0]), a.apply(VECTORS[0]), atol=1e-14)


def test_lengths_do_not_matter():
    scaled = A * np.linspace(0.5, 3, 200)[:, None]
    assert np.allclose(quat.multiply(scaled, B), quat.multiply(A, B), atol=1e-14)
    assert np.allclose(quat.rotate(scaled, VECTORS), quat.rotate(A, VECTORS), atol=1e-14)
    assert np.allclose(quat.to_matrix(scaled), quat.to_matrix(A), atol=1e-14)
    assert np.allclose(quat.to_rotvec(scaled), quat.to_rotvec(A), atol=1e-14)


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e-9, 0.0])
def test_rotation_vectors(scale):
    vectors = VECTORS * scale
    assert same(quat.from_rotvec(vectors), Rotation.from_rotvec(vectors))
    short = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True) / 3, 1)
    assert np.allclose(quat.to_rotvec(quat.from_rotvec(short)), short, rtol=1e-12, atol=1e-15 * scale)
    assert np.allclose(quat.to_rotvec(A), as_rotation(A).as_rotvec(), atol=1e-13)


def test_matrices():
    assert np.allclose(quat.to_matrix(A), as_rotation(A).as_matrix(), atol=1e-14)
    assert same(quat.from_matrix(quat.to_matrix(A).reshape(10, 20, 3, 3)), as_rotation(A))


@pytest.mark.parametrize("order", ["ZXY", "zxy", "xyz", "YXZ"])
def test_euler_angles(order):
    assert same(quat.from_euler(order, VECTORS), Rotation.from_euler(order, VECTORS))
    assert same(quat.from_euler(order, quat.to_euler(order, A)), as_rotation(A))


def test_angles_and_means():
    a, b = as_rotation(A), as_rotation(B)
    assert np.allclose(quat.angle(A), a.magnitude())
    assert np.allclose(quat.angle_between(A, B), (a.inv() * b).magnitude())
    assert same(quat.mean(A[:7])[None], a[:7].mean())
    turns, tilts = np.linspace(-3, 3, 200), quat.from_rotvec(VECTORS * [0.3, 0.3, 0])
    twisted = quat.twist(quat.multiply(quat.about("z", turns), tilts), np.array([0.0, 0.0, 1.0]))
    assert np.allclose(twisted, turns)


def test_the_smallest_turn_between_directions():
    turns, others = quat.between(VECTORS[:100], VECTORS[100:]), VECTORS[100:]
    turned = quat.rotate(turns, VECTORS[:100])
    assert np.allclose(np.cross(turned, others), 0, atol=1e-12) and np.all(np.sum(turned * others, axis=1) > 0)
    assert np.allclose(np.sum(quat.to_rotvec(turns) * others, axis=1), 0, atol=1e-12)


def test_slerp_goes_the_shorter_way_at_a_steady_speed():
    for weight in (0.0, 0.3, 1.0):
        part = as_rotation(A) * Rotation.from_rotvec(weight * (as_rotation(A).inv() * as_rotation(B)).as_rotvec())
        assert same(quat.slerp(A, -B, np.array([weight])), part)


def test_continuous_quaternions_are_the_same_rotations():
    q = quat.continuous(np.stack([A, B], axis=1))
    assert np.all(np.sum(q[1:] * q[:-1], axis=-1) >= 0)
    assert same(q[:, 0], as_rotation(A)) and same(q[:, 1], as_rotation(B))


def test_mirrored_rotations_turn_mirrored_vectors():
    normal = VECTORS[0] / np.linalg.norm(VECTORS[0])
    expected = quat.reflected(quat.rotate(A, quat.reflected(VECTORS, normal)), normal)
    assert np.allclose(quat.rotate(quat.mirrored(A, normal), VECTORS), expected)


def test_rates_of_rotation_vectors():
    omega, step = VECTORS[::-1], 1e-6
    vectors = VECTORS * 0.4
    later = quat.to_rotvec(quat.multiply(quat.from_rotvec(vectors), quat.from_rotvec(omega * step)))
    assert np.allclose(quat.rotvec_rate(vectors, omega), (later - vectors) / step, atol=1e-4)


def test_local_transforms_are_the_way_back_from_the_world():
    parents = np.array([-1, 0, 1, 1, 0])
    rotations, translations = A.reshape(40, 5, 4), VECTORS[:200].reshape(40, 5, 3)
    back = local_transforms(*world_transforms(rotations, translations, parents), parents)
    assert np.allclose(quat.angle_between(back[0], rotations), 0, atol=1e-12)
    assert np.allclose(back[1], translations, atol=1e-12)
