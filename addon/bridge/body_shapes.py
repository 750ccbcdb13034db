"""The rounded volumes that a body is put together from: plain arrays, with the share that each bone has in them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

_SIDES = 14
_ROUND = np.sin(np.linspace(0, np.pi / 2, 5))[1:]  # how far the rings of a round end lie from its tip
_TRUNK_PROFILE = np.array(
    # along the trunk, half width, half depth (parts of the height)
    [
        (0.00, 0.030, 0.030),
        (0.04, 0.056, 0.044),
        (0.12, 0.077, 0.056),
        (0.25, 0.081, 0.059),
        (0.46, 0.066, 0.049),
        (0.66, 0.076, 0.058),
        (0.80, 0.084, 0.061),
        (0.88, 0.086, 0.055),
        (0.94, 0.066, 0.044),
        (0.98, 0.042, 0.034),
        (1.00, 0.030, 0.029),
    ]
)


@dataclass(frozen=True)
class Part:
    """A closed tube.

    ``vertices`` is (V, 3), ``faces`` lists vertex indices, ``weights`` gives by bone name a (V,) share of
    each vertex; the shares of all bones sum to 1. ``material`` is a slot.
    """

    vertices: np.ndarray
    faces: list[tuple[int, ...]]
    weights: dict[str, np.ndarray]
    material: int


def joined(parts: Sequence[Part]) -> tuple[np.ndarray, list, np.ndarray, dict[str, np.ndarray]]:
    """All parts as one: vertices (V, 3), faces, material of each face, weights (V,) by bone name."""
    counts = [len(part.vertices) for part in parts]
    offsets = np.concatenate([[0], np.cumsum(counts)])
    faces, materials, weights = [], [], {}
    for part, offset in zip(parts, offsets, strict=False):
        faces += [tuple(int(v) + int(offset) for v in face) for face in part.faces]
        materials += [part.material] * len(part.faces)
        for bone, shares in part.weights.items():
            weights.setdefault(bone, np.zeros(offsets[-1]))[offset : offset + len(shares)] = shares
    return np.concatenate([part.vertices for part in parts]), faces, np.array(materials), weights


def capsule(bone: str, start, end, first: float, last: float, material: int) -> Part:
    """A tapered rod with round ends, from radius ``first`` at ``start`` to ``last`` at ``end``."""
    axis = end - start
    length = max(np.linalg.norm(axis), 1e-6)
    axis = axis / length if np.linalg.norm(axis) > 1e-9 else np.array([0.0, 0.0, 1.0])
    # The ends' rounding reaches half a radius beyond the joint, so that a bent knee stays closed.
    places = np.concatenate(
        [
            -0.8 * first * (1 - _ROUND**2) ** 0.5,
            np.linspace(0, length, 6)[1:-1],
            length + 0.8 * last * (1 - _ROUND[::-1] ** 2) ** 0.5,
        ]
    )
    taper = np.interp(places, np.array([0, 0.35 * length, length]), [first, first + 0.35 * (last - first), last])
    radii = taper * np.concatenate([_ROUND, np.ones(4), _ROUND[::-1]])
    wide = np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [0.0, 1.0, 0.0])
    wide = wide / np.linalg.norm(wide)
    centres = start + places[:, None] * axis
    return _single(bone, _tube(centres, wide, np.cross(axis, wide), radii, radii), material)


def egg(bone: str, centre, left, forward, up, half: tuple[float, float, float], material: int) -> Part:
    """An egg, blunt end up; ``half`` are its half axes to the left, forward and up."""
    angle = np.linspace(0, np.pi, 11)[1:-1]
    rise, spread = -np.cos(angle), np.sin(angle)
    spread = spread * (1 + 0.10 * rise)  # a chin is narrower than a forehead
    centres = centre + half[2] * rise[:, None] * up
    return _single(bone, _tube(centres, left, forward, half[0] * spread, half[1] * spread), material)


def slab(bone, start, end, side, up, half_widths, thicknesses, scale, material, centred=False) -> Part:
    """A flat, rounded box from ``start`` to ``end``: for feet, toes and hands.

    ``half_widths`` and ``thicknesses`` are those at its start and end, times ``scale``. It lies on ``start``
    and ``end`` (on the sole), or has them in the middle of its thickness if ``centred``.
    """
    along = np.array([0.0, 0.04, 0.14, 0.35, 0.6, 0.82, 0.95, 1.0])
    rounding = np.array([0.45, 0.78, 1.0, 1.0, 1.0, 1.0, 0.8, 0.5])
    widths = scale * np.interp(along, [0, 1], half_widths) * rounding
    heights = scale * np.interp(along, [0, 1], thicknesses) * (0.4 + 0.6 * rounding)
    centres = start + along[:, None] * (end - start)
    if not centred:
        centres = centres + heights[:, None] / 2 * up
    return _single(bone, _tube(centres, side, up, widths, heights / 2, squareness=3.0), material)


def trunk(bones: Sequence[str], stations: np.ndarray, left, up, height: float, material: int) -> Part:
    """A tube through ``stations`` (n + 1, 3), whose n stretches follow n bones and bend into each other."""
    steps = np.linalg.norm(np.diff(stations, axis=0), axis=1)
    knots = np.concatenate([[0], np.cumsum(steps)]) / max(steps.sum(), 1e-9)
    fine = np.unique(np.concatenate([_TRUNK_PROFILE[:, 0], np.linspace(0.04, 0.96, 18)]))
    centres = np.column_stack([np.interp(fine, knots, stations[:, k]) for k in range(3)])
    widths = height * _smooth(fine, _TRUNK_PROFILE[:, 0], _TRUNK_PROFILE[:, 1])
    depths = height * _smooth(fine, _TRUNK_PROFILE[:, 0], _TRUNK_PROFILE[:, 2])
    vertices, faces = _tube(centres, left, np.cross(left, up), widths, depths, squareness=2.4)
    # Each ring's place counted in bones; around a joint one bone's share passes into the next one's.
    place = np.interp(fine, knots, np.arange(len(knots)))
    weights = {}
    for k, bone in enumerate(bones):
        rise = 1.0 if k == 0 else np.clip((place - k) / 0.7 + 0.5, 0, 1)
        fall = 1.0 if k == len(bones) - 1 else np.clip((k + 1 - place) / 0.7 + 0.5, 0, 1)
        share = np.round(np.minimum(rise, fall) * np.ones_like(place), 2)
        weights[bone] = weights.get(bone, 0) + np.repeat(share, _SIDES)
    total = sum(weights.values())
    return Part(vertices, faces, {bone: share / total for bone, share in weights.items()}, material)


def _smooth(x, knots, values):
    """Piecewise cubic through the knots that does not overshoot."""
    return PchipInterpolator(knots, values)(x)


def _single(bone: str, tube, material: int) -> Part:
    vertices, faces = tube
    return Part(vertices, faces, {bone: np.ones(len(vertices))}, material)


def _tube(centres, wide, deep, half_widths, half_depths, squareness: float = 2.0):
    """Vertices and faces of a closed tube with rings around ``centres`` (R, 3); a superellipse for squareness > 2."""
    angle = np.linspace(0, 2 * np.pi, _SIDES, endpoint=False)
    cosine, sine = np.cos(angle), np.sin(angle)
    u = np.sign(cosine) * np.abs(cosine) ** (2 / squareness)
    v = np.sign(sine) * np.abs(sine) ** (2 / squareness)
    ring = half_widths[:, None, None] * u[None, :, None] * wide + half_depths[:, None, None] * v[None, :, None] * deep
    vertices = (centres[:, None] + ring).reshape(-1, 3)
    n_rings = len(centres)
    faces = []
    for r in range(n_rings - 1):
        for k in range(_SIDES):
            a, b = r * _SIDES + k, r * _SIDES + (k + 1) % _SIDES
            faces.append((a, b, b + _SIDES, a + _SIDES))
    faces.append(tuple(range(_SIDES - 1, -1, -1)))
    faces.append(tuple(range((n_rings - 1) * _SIDES, n_rings * _SIDES)))
    # Whether faces look outwards depends on which way around the axes were given.
    axis = centres[-1] - centres[0]
    if np.cross(wide, deep) @ axis < 0:
        faces = [face[::-1] for face in faces]
    return vertices, faces
