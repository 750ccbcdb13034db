"""Grid, obstacles and regions against exact geometry."""

from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from core.environment import obstacles
from core.environment.dilation import samples_near
from core.environment.environment import Environment, EnvironmentSettings, build_environment
from core.environment.grid import SUBDIVISION, Grid
from core.environment.ground import fills_rectangle
from core.environment.obstacle_masks import ObstacleCache
from core.environment.obstacles import clip_to_heights, rasterise, samples_within
from core.environment.pieces import Piece, Shape, solid_triangles
from core.environment.regions import Region, RegionRule, samples_inside
from core.environment.solids import turned_faces
from core.errors import SceneError

from .geometry import box_triangles, distance_to_polygons


def touches(polygon, low, high):
    """Whether a convex polygon and a square share a point: no axis of either separates them."""
    square = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    sides = np.concatenate([np.roll(polygon, -1, axis=0) - polygon, [[1, 0], [0, 1]]])
    for normal in sides[:, ::-1] * [1, -1]:
        a, b = polygon @ normal, square @ normal
        if a.max() < b.min() or b.max() < a.min():
            return False
    return True


@given(st.integers(0, 10**6))
def test_rasterise_sets_exactly_the_touched_samples(seed):
    rng = np.random.default_rng(seed)
    shape = (9, 7)
    triangles = rng.uniform(-3, 11, (3, 1, 2)) + rng.normal(0, rng.choice([0.1, 1, 4]), (3, 3, 2))
    expected = [
        [any(touches(t, (x, y), (x + 1, y + 1)) for t in triangles) for y in range(shape[1])] for x in range(shape[0])
    ]
    assert np.array_equal(rasterise(triangles, shape), expected)


@given(st.integers(0, 10**6))
def test_height_clipping_keeps_exactly_the_part_in_range(seed):
    """A point of a triangle lies in a clipped polygon if and only if its height is in the range."""
    rng = np.random.default_rng(seed)
    triangle = rng.uniform(-1, 1, (3, 3))
    weights = rng.dirichlet(np.ones(3), 200)
    points = weights @ triangle
    polygons = clip_to_heights(triangle[None], -0.2, 0.4)
    found = distance_to_polygons(points[:, :2], polygons) < 1e-9 if len(polygons) else np.zeros(len(points), dtype=bool)
    z = points[:, 2]
    sure = (np.abs(z + 0.2) > 1e-6) & (np.abs(z - 0.4) > 1e-6)
    assert np.array_equal(found[sure], ((z > -0.2) & (z < 0.4))[sure])


@given(st.integers(0, 10**6), st.booleans())
def test_free_samples_keep_their_distance_and_blocked_ones_are_near(seed, tiled):
    rng = np.random.default_rng(seed)
    grid = Grid((8, 10, 4), 0.2, tuple(rng.uniform(-1, 1, 2).tolist()), tiled)
    low = rng.uniform(-0.2, 1.6, 2) + grid.origin
    obstacle = box_triangles((*low, 0), (*(low + rng.uniform(0.02, 0.5, 2)), 2))
    radius = float(rng.uniform(0, 0.5))
    clipped = clip_to_heights(obstacle, 0.1, 1.8)
    # On a tiled ground it makes no difference in which tile something stands.
    near = samples_within(grid, clipped + np.array(grid.size) * rng.integers(-3, 4, 2) * tiled, radius)
    repeats = [(a, b) for a in range(-2, 3) for b in range(-2, 3)] if tiled else [(0, 0)]
    polygons = [p + np.array(r) * grid.size for p in clipped for r in repeats]
    points = rng.uniform(0, 1, (1000, 2)) * grid.size + grid.origin
    sample = np.floor((points - grid.origin) / grid.sample_size).astype(int)
    distance = distance_to_polygons(points, polygons)
    blocked = near[sample[:, 0], sample[:, 1]]
    assert np.all(distance[~blocked] >= radius - 1e-9)
    # Not too careful either: what is blocked is at most two diagonals of a sample farther off than the radius.
    assert np.all(distance[blocked] <= radius + 2 * np.sqrt(2) * grid.sample_size + 1e-9)


@given(st.integers(0, 10**6), st.booleans())
def test_inside_a_solid_nothing_is_free(seed, tiled):
    """Turned boxes that stand in each other, against points in boxes; also where the walls are too far to tell."""
    rng = np.random.default_rng(seed)
    grid = Grid((10, 12, 4), 0.25, (-1.0, 0.5), tiled)
    points = np.stack(np.meshgrid(*(np.arange(0.5, n * SUBDIVISION) for n in grid.shape[:2]), indexing="ij"), axis=-1)
    points = points * grid.sample_size + grid.origin
    boxes, inside, near = [], np.zeros(points.shape[:2], dtype=bool), np.zeros(points.shape[:2], dtype=bool)
    for _ in range(2):
        centre, half, angle = rng.uniform(-1, 3, 2), rng.uniform(0.2, 1.5, 2), rng.uniform(0, np.pi)
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        boxes.append(box_triangles((*-half, 0), (*half, 3)) @ turn.T + [*centre, 0])
        for a, b in [(a, b) for a in range(-3, 4) for b in range(-3, 4)] if tiled else [(0, 0)]:
            away = np.abs((points - centre - np.array([a, b]) * grid.size) @ turn[:2, :2]) - half
            inside |= away.max(axis=-1) < 0
            near |= away.max(axis=-1) < 0.71 * grid.sample_size
    environment = build_environment(grid, np.concatenate(boxes), settings=EnvironmentSettings(radius=0.0))
    assert np.all(environment.blocked[inside])
    # With no radius, all that is blocked beyond them is what the walls touch.
    assert np.all(near[environment.blocked])


def test_rooms_and_ceilings_are_not_solid():
    grid = Grid((20, 20, 4), 0.2)
    room = box_triangles((0.4, 0.4, -0.1), (3.6, 3.6, 2.5))[:, ::-1]
    middle = (40, 40)
    ceiling = box_triangles((0, 0, 2.4), (4, 4, 2.6))
    plane = ceiling[np.all(ceiling[:, :, 2] > 2.5, axis=1)]
    for open_air in (room, ceiling, plane, plane - [0, 0, 5]):
        assert not build_environment(grid, open_air).blocked[middle]
    assert build_environment(grid, room[:, ::-1]).blocked[middle]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_whichever_way_the_faces_of_a_closed_mesh_look_it_is_solid(seed):
    """Alone, in each other, side by side and one upon the other; also with an open sheet among them."""
    rng = np.random.default_rng(seed)
    grid = Grid((24, 24, 4), 0.25)
    boxes = [box_triangles((1, 1, -0.5), (2, 2, 1)), box_triangles((2, 1, -0.5), (3, 2, 3))]
    boxes += [box_triangles((1, 1, 1), (2, 2, 4)), box_triangles((1.5, 1.4, -1), (4, 2.6, 2.5))]
    low = rng.uniform(0, 4, 2)
    boxes += [box_triangles((*low, -0.2), (*(low + rng.uniform(0.2, 2, 2)), 2.2)), box_triangles((0, 5, 0), (5, 6, 2))]
    sheet = boxes.pop()[:5]
    body = EnvironmentSettings(radius=0.0)
    expected = build_environment(grid, np.concatenate([*boxes, sheet]), settings=body).blocked
    parts = []
    for box in boxes:
        looks_in = rng.random(12) < rng.choice([0.0, 0.5, 1.0])
        parts.append(np.where(looks_in[:, None, None], box[:, ::-1], box))
    pieces = [Piece(Shape(part), np.eye(4)) for part in (*parts, sheet)]
    assert np.array_equal(build_environment(grid, pieces, settings=body).blocked, expected)
    assert np.array_equal(build_environment(grid, pieces, settings=body, memory=ObstacleCache()).blocked, expected)
    outwards = solid_triangles(pieces, grid.corners)
    assert np.array_equal(build_environment(grid, outwards, settings=body).blocked, expected)


def test_a_box_that_looks_inwards_is_solid_and_a_mesh_with_a_hole_stays_as_it_is():
    grid = Grid((20, 20, 4), 0.2)
    box = box_triangles((1, 1, -0.1), (3, 3, 2.5))
    assert build_environment(grid, box[:, ::-1]).blocked[40, 40]
    assert turned_faces(box) is None and turned_faces(box[:, ::-1][1:]) is None
    assert turned_faces(np.empty((0, 3, 3))) is None


def test_a_ground_too_large_for_memory_is_refused():
    with pytest.raises(SceneError, match="larger Cell Size"):
        build_environment(Grid((40_000, 40_000, 8), 0.1), np.empty((0, 3, 3)))


def test_what_can_be_stepped_on_or_walked_under_is_no_obstacle():
    grid = Grid((20, 20, 8), 0.1)
    settings = EnvironmentSettings(radius=0.1, step_height=0.05, head_height=1.9)
    rug = box_triangles((0.5, 0.5, 0), (1, 1, 0.04))
    lintel = box_triangles((0.5, 0.5, 2.0), (1, 1, 2.4))
    table = box_triangles((0.5, 0.5, 0.7), (1, 1, 0.75))
    assert not build_environment(grid, rug, settings=settings).blocked.any()
    assert not build_environment(grid, lintel, settings=settings).blocked.any()
    assert build_environment(grid, table, settings=settings).blocked.any()


def test_regions_rule_where_frames_may_be_played():
    grid = Grid((10, 10, 4), 0.2)
    shape = box_triangles((0.8, 0.8, 0), (1.2, 1.2, 0.3))
    inside, outside = (SUBDIVISION * 5, SUBDIVISION * 5), (1, 1)
    expected = {  # rule: (untagged inside, tagged inside, untagged outside, tagged outside)
        RegionRule.REQUIRE: (False, True, True, True),
        RegionRule.FORBID: (True, False, True, True),
        RegionRule.CONFINE: (True, True, True, False),
    }
    for rule, free in expected.items():
        environment = build_environment(grid, np.empty((0, 3, 3)), [Region("step", rule, "step", shape)])
        plain, tagged = environment.free_samples([]), environment.free_samples(["step"])
        assert (plain[inside], tagged[inside], plain[outside], tagged[outside]) == free, rule
        assert np.array_equal(environment.free_samples(["other"]), plain)


@given(st.integers(0, 10**6))
def test_region_masks_are_rounded_to_their_safe_side(seed):
    rng = np.random.default_rng(seed)
    grid = Grid((8, 8, 4), 0.25)
    triangle = np.column_stack([rng.uniform(0, 2, (3, 2)), np.zeros(3)])
    points = rng.uniform(0, 2, (2000, 2))
    sample = tuple(np.floor(points / grid.sample_size).astype(int).T)
    within = distance_to_polygons(points, [triangle[:, :2]])
    margin = float(rng.uniform(0, 0.3))
    environment = build_environment(
        grid, np.empty((0, 3, 3)), [Region("r", RegionRule.REQUIRE, "a", triangle[None], margin)]
    )
    assert np.all(within[~environment.regions[0].mask[sample]] >= margin - 1e-9)
    try:
        confined = build_environment(grid, np.empty((0, 3, 3)), [Region("r", RegionRule.CONFINE, "a", triangle[None])])
    except SceneError:  # a triangle too thin to hold a sample
        return
    assert np.all(within[confined.regions[0].mask[sample]] <= 1e-9)


@contextmanager
def strips_of(n_samples):
    """Masks are rasterised in strips of so many samples, but at least a row."""
    usual = obstacles.SAMPLES_AT_ONCE
    obstacles.SAMPLES_AT_ONCE = n_samples
    try:
        yield
    finally:
        obstacles.SAMPLES_AT_ONCE = usual


def touched_in_one_piece(grid, polygons, margin, tolerance=0.0):
    """The samples of a ground and of a margin around it that polygons touch, the whole mask rasterised at once."""
    size = np.array(grid.shape[:2]) * SUBDIVISION
    polygons = (polygons - grid.origin) / grid.sample_size
    if not grid.tiled:
        return rasterise(polygons + margin, tuple(size + 2 * margin), tolerance)
    if len(polygons) == 0:
        return np.zeros(size + 2 * margin, dtype=bool)
    polygons = polygons - np.floor(polygons.min(axis=1, keepdims=True) / size) * size
    n = np.floor(polygons.max(axis=(0, 1)) / size).astype(int) + 1
    tiles = rasterise(polygons, tuple(n * size), tolerance).reshape(n[0], size[0], n[1], size[1])
    return np.pad(tiles.any(axis=(0, 2)), margin, mode="wrap")


def near_in_one_piece(grid, polygons, distance):
    """The samples within a distance, by a distance transform of the whole mask."""
    margin = int(np.ceil(distance / grid.sample_size)) + 2
    occupied = touched_in_one_piece(grid, polygons, margin)
    if distance > 0 and occupied.any():
        apart = ndimage.binary_erosion(~occupied, np.ones((3, 3), dtype=bool), border_value=True)
        occupied = occupied | (ndimage.distance_transform_edt(apart) * grid.sample_size < distance * (1 + 1e-9))
    return occupied[margin:-margin, margin:-margin]


def inside_in_one_piece(grid, polygons):
    """The samples inside polygons, on one mask four times finer."""
    nx, ny, n_headings = grid.shape
    finer = Grid((nx * 4, ny * 4, n_headings), grid.cell_size / 4, grid.origin, grid.tiled)
    touched = touched_in_one_piece(finer, polygons, 1, 1e-6)
    inside = ndimage.binary_erosion(touched, np.ones((3, 3), dtype=bool))[1:-1, 1:-1]
    return inside.reshape(nx * SUBDIVISION, 4, ny * SUBDIVISION, 4).all(axis=(1, 3))


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.booleans(), st.integers(40, 1000))
def test_strips_join_without_a_seam(seed, tiled, n_samples):
    """What is built strip by strip is what one piece gives, to the bit; tiles wrap."""
    rng = np.random.default_rng(seed)
    shape = (*rng.integers(3, 8, 2).tolist(), 4)
    grid = Grid(shape, 0.2, tuple(rng.uniform(-1, 1, 2).tolist()), tiled)

    def things(n):
        """Turned boxes on and around the ground, some on its edges."""
        made = [np.empty((0, 3, 3))]
        for _ in range(n):
            half, angle = rng.uniform(0.02, 0.9, 2), rng.uniform(0, np.pi)
            turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
            at = grid.origin + rng.uniform(-0.3, 1.3, 2) * grid.size
            made.append(box_triangles((*-half, rng.uniform(-1, 1)), (*half, 3)) @ turn.T + [*at, 0])
        return np.concatenate(made)

    scene, body = things(rng.integers(4)), EnvironmentSettings(radius=float(rng.choice([0, 0.03, 0.25, 0.7, 3.0])))
    rules = list(RegionRule)
    margin = float(rng.choice([0, 0.1]))
    spots = [Region(rule.value, rule, rule.value, things(rng.integers(1, 3)), margin) for rule in rules]
    kept = []
    for region in spots:
        shadow = clip_to_heights(region.triangles, -np.inf, np.inf)
        if region.rule is RegionRule.CONFINE:
            mask = inside_in_one_piece(grid, shadow)
        else:
            mask = near_in_one_piece(grid, shadow, margin)
        if mask.any():
            kept.append((region, mask))
    with strips_of(10**9):
        whole = build_environment(grid, scene, [region for region, _ in kept], body)
    with strips_of(n_samples):
        built = build_environment(grid, scene, [region for region, _ in kept], body)
    low, high = body.ground_height + body.step_height, body.ground_height + body.head_height
    expected = near_in_one_piece(grid, clip_to_heights(scene, low, high), body.radius)
    assert np.array_equal(built.blocked, whole.blocked)
    assert not np.any(expected & ~built.blocked)
    # What is blocked besides is inside something closed.
    bare = samples_within(grid, clip_to_heights(scene, low, high), body.radius)
    assert np.array_equal(bare, expected)
    for (_, mask), found in zip(kept, built.regions, strict=True):
        assert np.array_equal(found.mask, mask)


@given(st.integers(0, 10**6), st.floats(0.01, 7.0))
def test_what_is_near_is_what_a_distance_transform_finds(seed, distance):
    rng = np.random.default_rng(seed)
    margin = int(np.ceil(distance)) + 2
    occupied = rng.random(rng.integers(1, 20, 2) + 2 * margin) < rng.choice([0.001, 0.02, 0.3])
    found = samples_near(occupied, distance)[margin:-margin, margin:-margin]
    if not occupied.any():
        assert not found.any()
        return
    apart = ndimage.binary_erosion(~occupied, np.ones((3, 3), dtype=bool), border_value=True)
    expected = ndimage.distance_transform_edt(apart) < distance * (1 + 1e-9)
    assert np.array_equal(found, expected[margin:-margin, margin:-margin])


def confined(*triangles, grid, names=("a", "b")):
    """Samples in which a confined tag may be played: each entry of ``triangles`` is a region of its own."""
    regions = [Region(n, RegionRule.CONFINE, "jump", t) for n, t in zip(names, triangles, strict=False)]
    return build_environment(grid, np.empty((0, 3, 3)), regions).free_samples(["jump"])


def test_confining_regions_add_up_but_not_across_a_gap():
    grid = Grid((20, 20, 4), 0.1)
    left, right = box_triangles((0.2, 0.2, 0), (1.03, 1.5, 1)), box_triangles((1.03, 0.2, 0), (1.8, 1.5, 1))
    together = confined(np.concatenate([left, right]), grid=grid)
    assert np.array_equal(confined(left, right, grid=grid), together)
    assert together[12:70, 12:56].all()
    apart = confined(left, right + [0.03, 0, 0], grid=grid)
    columns = np.floor(np.array([1.03, 1.06]) / grid.sample_size).astype(int)
    assert not apart[columns[0] : columns[1] + 1].any()
    assert apart[columns[0] - 1, 20:40].all() and apart[columns[1] + 1, 20:40].all()


def test_a_region_as_large_as_the_ground_confines_to_all_of_it():
    grid = Grid((20, 20, 4), 0.1)
    assert confined(box_triangles((0, 0, 0), (2, 2, 1)), grid=grid).all()


def test_grid_over_rectangle():
    grid = Grid.over_rectangle((-3.5, -4), (3.5, 4), 0.125, 24)
    assert grid.shape == (56, 64, 24)
    assert np.allclose(grid.positions([0, 0]), [-3.5 + 0.0625, -4 + 0.0625])
    assert np.array_equal(grid.cells(grid.positions([[3, 60], [70, -2]])), [[3, 60], [70, -2]])
    # Sizes that come through single precision are still whole numbers of cells.
    for size, cell in [(6.0, 0.15), (6.0, 0.05), (100.0, 0.1)]:
        n = round(size / cell)
        assert Grid.over_rectangle((0, 0), (size, size), float(np.float32(cell)), 8, tiled=True).shape == (n, n, 8)
    narrow = Grid.over_rectangle((0, 0), (1.05, 1.0), 0.1, 8)
    assert narrow.shape == (10, 10, 8)
    assert narrow.origin[0] == pytest.approx(0.025)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Grid.over_rectangle((0, 0), (0, 5), 0.1, 8), "empty"),
        (lambda: Grid.over_rectangle((0, 0), (0.05, 5), 0.1, 8), "smaller than one cell"),
        (lambda: Grid.over_rectangle((0, 0), (5, 5), 0, 8), "positive"),
        (lambda: Grid.over_rectangle((0, 0), (5.05, 5), 0.1, 8, tiled=True), "whole number of cells"),
        (lambda: Grid.over_rectangle((0, np.nan), (5, 5), 0.1, 8), "empty"),
        (lambda: Grid((4, 4, 0), 0.1), "at least one"),
        (lambda: build_environment(Grid((4, 4, 4), 0.1), np.full((1, 3, 3), np.nan)), "not a number"),
        (
            lambda: build_environment(Grid((4, 4, 4), 0.1), [], settings=EnvironmentSettings(radius=-1)),
            "Radius",
        ),
        (
            lambda: build_environment(
                Grid((4, 4, 4), 0.1), [], [Region("Far Away", RegionRule.FORBID, "a", np.full((1, 3, 3), 50.0))]
            ),
            "Far Away",
        ),
        (lambda: Environment(Grid((4, 4, 4), 0.1), np.zeros((4, 4), dtype=bool)), "needs"),
        (lambda: Environment(Grid((4, 4, 4), 0.1), np.ones((16, 16), dtype=np.uint8)), "bool"),
        (lambda: build_environment(Grid((4, 4, 4), 0.1), np.zeros((9, 2))), "triangles of shape"),
        (
            lambda: build_environment(Grid((4, 4, 4), 0.1), [], settings=EnvironmentSettings(ground_height=np.nan)),
            "height of the ground",
        ),
        (lambda: Grid((8.5, 6, 4), 0.1), "whole numbers"),
        (
            lambda: build_environment(
                Grid((4, 4, 4), 0.1), [], [Region("Hot", RegionRule.FORBID, "a", np.zeros((1, 3, 3)), -0.1)]
            ),
            "margin of the region 'Hot'",
        ),
        (
            lambda: build_environment(
                Grid((4, 4, 4), 0.1), [], [Region("Hot", RegionRule.FORBID, "a", np.full((1, 3, 3), np.nan))]
            ),
            "'Hot' has a vertex",
        ),
        (
            lambda: build_environment(
                Grid((4, 4, 4), 0.1), [], [Region("Thin", RegionRule.CONFINE, "a", np.zeros((1, 3, 3)))]
            ),
            "'Thin' holds no part",
        ),
    ],
)
def test_bad_input_is_refused_with_a_sentence(make, message):
    with pytest.raises(SceneError, match=message):
        make()


def patch(low, high, corners=1, z=0.0):
    """(T, 3, 3): a flat rectangle of ``corners`` x ``corners`` quads of two triangles each."""
    x, y = (np.linspace(low[axis], high[axis], corners + 1) for axis in (0, 1))
    quads = []
    for i in range(corners):
        for j in range(corners):
            a, b = (x[i], y[j], z), (x[i + 1], y[j], z)
            c, d = (x[i + 1], y[j + 1], z), (x[i], y[j + 1], z)
            quads += [(a, b, c), (a, c, d)]
    return np.array(quads)


@given(st.integers(0, 10**6), st.booleans())
def test_ground_is_where_every_part_of_a_sample_is_covered(seed, tiled):
    """Unions of rectangles with corners on the finest mask, against that mask filled one by one."""
    rng = np.random.default_rng(seed)
    grid = Grid((3, 6, 4), 1.0, (rng.uniform(-9, 9), 0.5), tiled)
    fine = grid.sample_size / 4
    size = np.array(grid.shape[:2]) * SUBDIVISION * 4
    covered, faces = np.zeros(size, dtype=bool), []
    for _ in range(rng.integers(1, 5)):
        # Gaps that are narrower count as closed.
        low, high = np.sort(3 * rng.integers(0, size // 3, (2, 2)), axis=0) + [[0], [3]]
        covered[low[0] : high[0], low[1] : high[1]] = True
        faces.append(patch(grid.origin + low * fine, grid.origin + high * fine, rng.integers(1, 3)))
    expected = covered.reshape(size[0] // 4, 4, size[1] // 4, 4).all(axis=(1, 3))
    ground = np.concatenate(faces)
    # Nothing beside it is held, and nothing is lost but, here and there, along an edge.
    held = samples_inside(ground, grid)
    assert not (held & ~expected).any()
    around = np.pad(expected, 1, mode="wrap") if tiled else np.pad(expected, 1, constant_values=True)
    assert not (ndimage.binary_erosion(around, np.ones((3, 3)))[1:-1, 1:-1] & ~held).any()
    blocked = build_environment(grid, np.empty((0, 3, 3)), ground=ground).blocked
    assert np.array_equal(blocked, ~held)


@given(st.integers(0, 10**6))
def test_a_rectangle_is_known_by_its_edges(seed):
    rng = np.random.default_rng(seed)
    quads = patch((-2, 1), (3, 5), 4).reshape(-1, 2, 3, 3)
    full = quads.reshape(-1, 3, 3)
    # However the faces are wound, and whatever their heights.
    wound = np.where(rng.random(len(full))[:, None, None] < 0.5, full, full[:, ::-1])
    wound[:, :, 2] = np.sin(5 * wound[:, :, 0]) * wound[:, :, 1]
    assert fills_rectangle(wound)
    assert fills_rectangle(box_triangles((-1, -1, 0), (1, 2, 1)))
    missing = rng.choice(16, rng.integers(1, 16), replace=False)
    part = np.delete(quads, missing, axis=0).reshape(-1, 3, 3)
    low, high = part[:, :, :2].min(axis=(0, 1)), part[:, :, :2].max(axis=(0, 1))
    area = np.prod(high - low)
    assert fills_rectangle(part) == (len(part) * 5 / 8 >= area - 1e-9)
    turn = np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])
    assert not fills_rectangle(full @ turn)
    assert not fills_rectangle(np.empty((0, 3, 3)))


@pytest.mark.parametrize("scale", [(-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1), (-1, -1, 1)])
def test_what_is_mirrored_is_as_solid_as_before(scale):
    shape = Shape(box_triangles((-2, -2, -1), (2, 2, 1)))
    grid = Grid.over_rectangle((-4, -4), (4, 4), 0.25, 8)
    plain, mirrored = (Piece(shape, np.diag([*factors, 1.0])) for factors in ((1, 1, 1), scale))
    expected = build_environment(grid, [plain])
    assert np.array_equal(build_environment(grid, [mirrored]).blocked, expected.blocked)
    assert not expected.free_cells()[12:20, 12:20].any()
