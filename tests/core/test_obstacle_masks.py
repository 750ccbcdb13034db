"""Obstacles whose masks are remembered give the environment that all their triangles give at once, to the bit."""

import gc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.environment import obstacle_masks
from core.environment.environment import EnvironmentSettings, build_environment, build_environment_steps
from core.environment.grid import Grid
from core.environment.obstacle_masks import ObstacleCache
from core.environment.pieces import Piece, Shape, all_triangles
from core.errors import SceneError
from core.progress import finish

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(faces=range(6)) -> Shape:
    """Some sides of a unit cube, turned outwards."""
    triangles = [
        [a, b, c] for side in faces for a, b, c in (np.array(SIDES[side])[[0, 1, 2]], np.array(SIDES[side])[[0, 2, 3]])
    ]
    return Shape(CORNERS[np.array(triangles)])


# A whole box; a lid and a bottom without sides, which enclose what is between only together; one that is open above.
SHAPES = [box(), box([5]), box([4]), box(range(5)), Shape(np.random.default_rng(5).uniform(-0.5, 0.5, (30, 3, 3)))]


def placed(rng: np.random.Generator) -> Piece:
    matrix = np.eye(4)
    angle = rng.choice([0.0, rng.uniform(0, 2 * np.pi)])
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    matrix[:3, :3] = turn * rng.choice([0.25, 0.5, 1.0, 4.0], size=3)
    # On the borders of samples as well as anywhere.
    matrix[:3, 3] = rng.choice([rng.uniform(-1, 4, 3), rng.integers(-8, 30, 3) * 0.125])
    matrix[2, 3] = rng.choice([-3.0, 0.0, 1.0])
    return Piece(SHAPES[rng.integers(len(SHAPES))], matrix)


def test_an_outlined_ground_is_looked_at_once():
    memory, kept = ObstacleCache(), []
    bend = box([5]).triangles * [4.0, 3.0, 0.0]
    outline = Shape(np.concatenate([bend, bend[:, :, [1, 0, 2]]]))
    grids = [Grid((8, 8, 4), 0.5), Grid((8, 8, 4), 0.5, (0.1, 0.0)), Grid((7, 8, 4), 0.5), Grid((8, 8, 4), 0.45)]
    for grid in grids:
        for ground in (Piece(outline, np.eye(4)), Piece(outline, np.diag([1.0, 0.9, 1.0, 1.0]))):
            for shift in range(3):
                obstacle = Piece(SHAPES[0], np.diag([0.5, 0.5 + 0.2 * shift, 2.0, 1.0]))
                found = build_environment(grid, [obstacle], memory=memory, ground=ground)
                expected = build_environment(grid, [obstacle], ground=ground.triangles())
                np.testing.assert_array_equal(found.blocked, expected.blocked)
                assert found.blocked.any() and not found.blocked.all()
                kept.append(memory.ground(grid, ground))
    # The very same mask while only an obstacle moves.
    assert len({id(mask) for mask in kept}) == len(kept) / 3


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), tiled=st.booleans(), together=st.sampled_from([1, 20, 5_000]))
def test_what_has_moved_is_all_that_changes(seed, tiled, together):
    rng, memory = np.random.default_rng(seed), ObstacleCache()
    grid = Grid((6, 7, 4), 0.5, (0.125, -0.2), tiled)
    body = EnvironmentSettings(radius=float(rng.choice([0.0, 0.3, 0.6])), head_height=float(rng.choice([0.9, 1.9])))
    pieces = [placed(rng) for _ in range(rng.integers(0, 7))]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(obstacle_masks, "_TRIANGLES_TOGETHER", together)
        for _ in range(4):
            expected = build_environment(grid, all_triangles(pieces), settings=body)
            without = build_environment(grid, pieces, settings=body)
            found = build_environment(grid, pieces, settings=body, memory=memory)
            np.testing.assert_array_equal(without.blocked, expected.blocked)
            np.testing.assert_array_equal(found.blocked, expected.blocked)
            # One moves, one goes, one comes, or the ground or the body changes.
            change = rng.integers(5)
            if change < 2 and pieces:
                pieces[rng.integers(len(pieces))] = placed(rng)
            elif change == 2 and pieces:
                pieces.pop(rng.integers(len(pieces)))
            elif change == 3:
                pieces.insert(rng.integers(len(pieces) + 1), placed(rng))
            else:
                grid = Grid((6, 7, 4), 0.5, (0.125, float(rng.uniform(-1, 1))), tiled)


def test_a_lid_and_a_bottom_are_solid_together():
    memory, grid = ObstacleCache(), Grid((8, 8, 4), 0.25)
    matrix = np.diag([1.0, 1.0, 4.0, 1.0])
    matrix[:3, 3] = 0.5, 0.5, -1.0
    body = EnvironmentSettings(radius=0.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(obstacle_masks, "_TRIANGLES_TOGETHER", 1)
        lid, bottom = Piece(box([5]), matrix), Piece(box([4]), matrix)
        assert not build_environment(grid, [lid], settings=body, memory=memory).blocked.any()
        assert not build_environment(grid, [bottom], settings=body, memory=memory).blocked.any()
        blocked = build_environment(grid, [lid, bottom], settings=body, memory=memory).blocked
    assert blocked[8:24, 8:24].all() and blocked.sum() == 16 * 16


def test_only_what_has_moved_is_rasterised(monkeypatch):
    looked_at, rasterise = [], obstacle_masks.occupied_samples
    monkeypatch.setattr(
        obstacle_masks,
        "occupied_samples",
        lambda grid, polygons, margin: looked_at.append(1) or rasterise(grid, polygons, margin),
    )
    monkeypatch.setattr(obstacle_masks, "_TRIANGLES_TOGETHER", 12)
    rng, memory, grid = np.random.default_rng(0), ObstacleCache(), Grid((8, 8, 4), 0.5)
    pieces = [Piece(box(), placed(rng).matrix) for _ in range(6)]

    def times(**body) -> int:
        looked_at.clear()
        build_environment(grid, pieces, settings=EnvironmentSettings(**body), memory=memory)
        return len(looked_at)

    assert (times(), times()) == (6, 0)
    pieces[2] = placed(rng)
    assert times() == 1
    # Equal, though not the same.
    pieces[3] = Piece(Shape(pieces[3].shape.triangles.copy()), pieces[3].matrix.copy())
    assert times() == 0
    assert (times(head_height=1.0), times(head_height=1.0)) == (6, 0)
    # What was known of the other height is forgotten.
    assert times() == 6


def test_whoever_gives_up_or_is_interrupted_loses_nothing(monkeypatch):
    rng, memory = np.random.default_rng(1), ObstacleCache()
    monkeypatch.setattr(obstacle_masks, "_TRIANGLES_TOGETHER", 12)
    monkeypatch.setattr(obstacle_masks, "_TRIANGLES_AT_ONCE", 10)
    grid, other = Grid((8, 8, 4), 0.5), Grid((8, 8, 4), 0.5, (0.3, 0.0))
    heavy = Piece(Shape(rng.uniform(0, 2, (35, 3, 3))), np.eye(4))
    pieces = [Piece(box(), placed(rng).matrix) for _ in range(3)]

    def steps(ground=grid, n=0):
        """The steps that are left after n of them."""
        running = build_environment_steps(ground, [*pieces, heavy], memory=memory)
        for _ in range(n):
            next(running)
        return running

    # Two for each box, four for the heavy one.
    assert len(list(steps())) == 3 * 2 + 4
    assert list(steps()) == []
    heavy = Piece(heavy.shape, placed(rng).matrix)
    steps(n=2).close()
    assert len(list(steps())) == 4
    # Somebody else looks at another ground in the middle of it.
    heavy = Piece(heavy.shape, placed(rng).matrix)
    running = steps(n=2)
    for ground, found in ((other, finish(steps(other))), (grid, finish(running)), (other, finish(steps(other)))):
        expected = build_environment(ground, all_triangles([*pieces, heavy]))
        np.testing.assert_array_equal(found.blocked, expected.blocked)
    found = finish(steps())
    np.testing.assert_array_equal(found.blocked, build_environment(grid, all_triangles([*pieces, heavy])).blocked)


def living_bytes() -> int:
    """Bytes of all masks that anybody holds."""
    return sum(found.n_bytes for found in gc.get_objects() if isinstance(found, obstacle_masks.ObstacleMask))


@pytest.fixture
def only_new_objects():
    """Hides from the collector what other tests have left: it does not count, and there is a lot of it."""
    gc.freeze()
    yield
    gc.unfreeze()


def test_memory_is_limited(monkeypatch, only_new_objects):
    rng, memory, grid = np.random.default_rng(0), ObstacleCache(), Grid((8, 8, 4), 0.5)
    monkeypatch.setattr(obstacle_masks, "_TRIANGLES_TOGETHER", 1)
    pieces = [Piece(box(), placed(rng).matrix) for _ in range(16)]
    before, largest = living_bytes(), 0
    for piece in pieces:
        alone = ObstacleCache()
        build_environment(grid, [piece], memory=alone)
        largest = max(largest, living_bytes() - before)
        del alone
    limit = 3 * largest
    monkeypatch.setattr(obstacle_masks, "_MAX_BYTES", limit)

    def n_steps() -> int:
        """How many are not known; on the way, no more is held than may be, and the mask that is at work."""
        running, n = build_environment_steps(grid, pieces, memory=memory), 0
        while True:
            try:
                next(running)
            except StopIteration as stop:
                expected = build_environment(grid, all_triangles(pieces))
                np.testing.assert_array_equal(stop.value.blocked, expected.blocked)
                assert 0 < living_bytes() - before <= limit
                return n
            n += 1
            assert living_bytes() - before <= limit + largest

    assert n_steps() == 16
    left = n_steps()
    assert 0 < left < 16 and n_steps() == left
    # What is no longer there makes room for what has come.
    pieces = [Piece(box(), placed(rng).matrix) for _ in range(16)]
    assert n_steps() == 16
    assert 0 < n_steps() < 16
    # Nothing of it is lost count of.
    assert memory._known._n_bytes == living_bytes() - before
    pieces = []
    assert len(list(build_environment_steps(grid, pieces, memory=memory))) == 0
    assert memory._known._n_bytes == living_bytes() - before == 0


def test_pieces_without_triangles_leave_nothing():
    empty, memory, grid = Piece(Shape(np.empty((0, 3, 3))), np.eye(4)), ObstacleCache(), Grid((8, 8, 4), 0.25)
    full = Piece(box(), np.eye(4))
    for pieces in ([empty], [empty, full], [full, empty], [empty, empty, full, full], []):
        expected = build_environment(grid, all_triangles(pieces))
        assert expected.blocked.any() == (full in pieces)
        for _ in range(2):
            found = build_environment(grid, pieces, memory=memory)
            np.testing.assert_array_equal(found.blocked, expected.blocked)
            np.testing.assert_array_equal(build_environment(grid, pieces).blocked, expected.blocked)


def test_pieces_in_the_same_place_count_each(monkeypatch):
    monkeypatch.setattr(obstacle_masks, "_TRIANGLES_TOGETHER", 1)
    memory, grid = ObstacleCache(), Grid((8, 8, 4), 0.25)
    matrix = np.diag([1.0, 1.0, 4.0, 1.0])
    matrix[:3, 3] = 0.5, 0.5, -1.0
    # A lid that is turned over takes away one of two.
    over = Piece(Shape(box([5]).triangles[:, ::-1]), matrix)
    lid, bottom = Piece(box([5]), matrix), Piece(box([4]), matrix)
    for pieces in ([lid, lid, over, bottom], [lid, over, bottom], [lid, bottom, lid, over]):
        expected = build_environment(grid, all_triangles(pieces), settings=EnvironmentSettings(radius=0.0)).blocked
        found = build_environment(grid, pieces, settings=EnvironmentSettings(radius=0.0), memory=memory).blocked
        np.testing.assert_array_equal(found, expected)
        assert found.any() == (len(pieces) == 4)


def test_what_is_no_number_is_told_with_the_memory_too():
    shape = Shape(np.full((1, 3, 3), np.nan))
    assert not shape.is_finite and box().is_finite
    with pytest.raises(SceneError, match="not a number"):
        build_environment(Grid((4, 4, 4), 0.1), [Piece(shape, np.eye(4))], memory=ObstacleCache())


def test_a_piece_is_its_shape_in_the_world():
    matrix = np.array([[0, -2, 0, 1], [2, 0, 0, 5], [0, 0, 3, 0], [0, 0, 0, 1]], dtype=float)
    piece = Piece(box(), matrix)
    homogeneous = np.concatenate([box().triangles.reshape(-1, 3), np.ones((36, 1))], axis=1)
    np.testing.assert_allclose(piece.triangles().reshape(-1, 3), (homogeneous @ matrix.T)[:, :3])
    np.testing.assert_array_equal(piece.bounds, [[-1, 5, 0], [1, 7, 3]])
    assert piece.key == Piece(box(), matrix.copy()).key
    assert piece.key != Piece(box(), np.eye(4)).key and piece.key != Piece(box(range(5)), matrix).key
