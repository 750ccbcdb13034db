"""The maps of the floor: each shows the core's numbers, says what its colours mean, and lies where it should."""

from itertools import combinations

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.properties.graph_names import clip_names, segment_names
from bl_ext.user_default.wayfarer.addon.render.floor import LEGEND_PROPERTY, find_floor, floor_legend, put_on_floor
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.core.environment.grid import Grid
from bl_ext.user_default.wayfarer.core.errors import MotionGraphError
from bl_ext.user_default.wayfarer.core.evaluation.detours import detours_steps
from bl_ext.user_default.wayfarer.core.evaluation.goals import goal_at
from bl_ext.user_default.wayfarer.core.evaluation.occupancy import occupancy_steps
from bl_ext.user_default.wayfarer.core.evaluation.reach import round_times, time_to_reach_steps
from bl_ext.user_default.wayfarer.core.evaluation.variability import variability
from bl_ext.user_default.wayfarer.core.evaluation.weak_spots import WeakSpotSettings, weak_spots_steps
from bl_ext.user_default.wayfarer.core.maps import MAPS, MapOptions, MapQuantity, PaintedMap, map_of
from bl_ext.user_default.wayfarer.core.maps.colors import Palette, lightest_value, linear, scale_of
from bl_ext.user_default.wayfarer.core.maps.legend import MapLegend
from bl_ext.user_default.wayfarer.core.progress import finish
from bl_ext.user_default.wayfarer.core.wording import area as area_words
from bl_ext.user_default.wayfarer.core.wording import short

from .test_why_not_map import SIGHTS, lab

operators = bpy.ops.wayfarer


@pytest.fixture(scope="module")
def embedding(sample_file):
    """Of the coarse sample; nothing of it belongs to a file."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    settings.environment.cell_size, settings.environment.n_headings = 0.25, 12
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc"))
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    return store.results(bpy.context.scene).embedding


@pytest.fixture
def settings(sample_settings):
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    return sample_settings


def paint(embedding, name, **options):
    return finish(map_of(name).paint_steps(embedding, MapOptions(**options)))


def on_scale(painted, scale) -> np.ndarray:
    """(nx, ny) position of each cell's colour on the scale, from 0 to 1; not a number off it."""
    fine = linear(scale.colors(np.linspace(0, 1, 2001)))
    apart = np.abs(painted.colors[:, :, None, :3] - fine).max(axis=3)
    at = apart.argmin(axis=2) / 2000
    return np.where(apart.min(axis=2) < 2e-3, at, np.nan)


def has_color(painted, srgb) -> np.ndarray:
    return np.isclose(painted.colors[..., :3], linear(srgb), atol=1e-6).all(axis=2)


# --------------------------------------------------------------------------------------------- every map


@pytest.mark.parametrize("kind", MAPS, ids=lambda kind: kind.name)
def test_every_colour_on_the_floor_is_in_the_legend(embedding, kind):
    palette = Palette.VIRIDIS
    place = embedding.environment.grid.positions(np.argwhere(embedding.covered().any(axis=2))[40])
    painted = paint(embedding, kind.name, palette=palette, goal=tuple(place.tolist()))
    nx, ny, _, _ = embedding.shape
    assert painted.colors.shape == (nx, ny, 4)
    assert painted.colors.min() >= 0 and painted.colors.max() <= 1 and (painted.colors[..., 3] == 1).all()
    explained = np.zeros((nx, ny), dtype=bool)
    for entry in painted.legend.swatches:
        explained |= has_color(painted, entry.color)
    if painted.legend.bar is not None:
        explained |= np.isfinite(on_scale(painted, scale_of(palette)))
        assert painted.legend.bar.stops in (scale_of(palette).stops, scale_of(palette).stops[::-1])
        assert painted.legend.unit and painted.legend.bar.ticks
    assert explained.all()
    assert painted.legend.title and painted.report and not painted.report.endswith(".")
    assert type(painted.legend).from_json(painted.legend.to_json()) == painted.legend


def test_choices_in_files_stay_what_they_are():
    numbers = [kind.number for kind in MAPS]
    assert len(set(numbers)) == len(MAPS) and len({kind.name for kind in MAPS}) == len(MAPS)
    kept = {"VARIABILITY": 0, "COVERAGE": 1, "WHY_NOT": 2, "SEGMENT": 3, "REACH": 4, "LONG_WAY": 5, "OCCUPANCY": 6}
    kept |= {"WEAK_SPOTS": 7, "QUERY": 8}
    assert kept == {kind.name: kind.number for kind in MAPS}
    assert {item.name for item in MapQuantity} == set(kept)
    for kind in MAPS:
        assert kind.heeds <= set(MapOptions.__dataclass_fields__)


def test_only_what_a_map_heeds_makes_a_difference(settings):
    options = {
        "palette": {"palette": "CIVIDIS"},
        "heading": {"use_heading": True, "heading": 1.0},
        "segment": {"segment": "x"},
        "goal": {"goal": "OBJECT"},
        "bands": {"bands": False},
        "few_ways": {"few_ways": 3},
    }
    bpy.context.view_layer.objects.active = bpy.data.objects["Table"]
    for kind in MAPS:
        for option, values in options.items():
            settings.map.quantity = kind.name
            before = {name: getattr(settings.map, name) for name in values}
            key = settings.map.key
            for name, value in values.items():
                setattr(settings.map, name, value)
            assert (settings.map.key != key) == (option in kind.heeds), (kind.name, option)
            for name, value in before.items():
                setattr(settings.map, name, value)
            assert settings.map.key == key


# ---------------------------------------------------------------------------------------------- amounts


def check_amounts(painted, values, palette):
    """Lighter where there is more, by the square root; other colours where there is nothing."""
    at = on_scale(painted, scale_of(palette))
    present = values > 0
    assert present.any() and not present.all()
    expected = np.sqrt(np.minimum(values / lightest_value(values), 1))
    np.testing.assert_allclose(at[present], expected[present], atol=3e-3)
    assert not np.isfinite(at[~present]).any()
    assert painted.numbers["map_highest"] == values.max() and painted.numbers["map_cells"] == present.sum()


@pytest.mark.parametrize("palette", list(Palette))
def test_variability(embedding, palette):
    ways = variability(embedding)
    check_amounts(paint(embedding, "VARIABILITY", palette=palette), ways.sum(axis=2), palette)
    n_headings = embedding.shape[2]
    for heading, index in ((0.0, 0), (np.radians(59), 2), (np.radians(-31), n_headings - 1), (np.radians(359), 0)):
        painted = paint(embedding, "VARIABILITY", palette=palette, heading=heading)
        check_amounts(painted, ways[:, :, index], palette)
        assert painted.legend.title == f"Variability, Heading {30 * index}°"


def test_coverage(embedding):
    mask = embedding.node_mask()
    check_amounts(paint(embedding, "COVERAGE"), mask.any(axis=3).sum(axis=2), Palette.GREYS)
    check_amounts(paint(embedding, "COVERAGE", heading=np.pi), mask[:, :, 6].sum(axis=2), Palette.GREYS)


def test_a_single_segment(embedding):
    ways, segments = embedding.in_degree().astype(np.int64) * embedding.out_degree(), embedding.graph.segments
    for index in (0, 5):
        check_amounts(paint(embedding, "SEGMENT", segment=segments[index].name), ways[..., index].sum(2), Palette.GREYS)
    name = segments[5].name
    check_amounts(paint(embedding, "SEGMENT", segment=name, heading=0.0), ways[:, :, 0, 5], Palette.GREYS)
    np.testing.assert_array_equal(
        paint(embedding, "SEGMENT").colors, paint(embedding, "SEGMENT", segment=segments[0].name).colors
    )
    with pytest.raises(MotionGraphError, match="no segment 'moonwalk'"):
        paint(embedding, "SEGMENT", segment="moonwalk")


def test_occupancy(embedding):
    share, scale = finish(occupancy_steps(embedding)).floor, scale_of(Palette.VIRIDIS)
    at = on_scale(paint(embedding, "OCCUPANCY", palette=Palette.VIRIDIS), scale)
    present = share > 0
    np.testing.assert_allclose(
        at[present], np.sqrt(np.minimum(share / np.percentile(share[present], 99), 1))[present], atol=3e-3
    )
    assert not share[~embedding.environment.free_cells()].any()
    # The scale stops short of the busiest cell, and says so.
    legend = paint(embedding, "OCCUPANCY").legend
    end = np.percentile(share[present], 99) / embedding.environment.grid.cell_size**2
    assert legend.unit == "% of time per m²" and legend.bar.ticks[-1] == (1.0, f"{short(100 * end)}+")


# ------------------------------------------------------------------------------------------------ times


def test_time_to_reach(embedding):
    covered = embedding.covered().any(axis=2)
    goal = tuple(embedding.environment.grid.positions(np.argwhere(covered)[60]).tolist())
    field = finish(time_to_reach_steps(embedding, goal_at(embedding, goal, 0.25)))
    painted, scale = paint(embedding, "REACH", goal=goal), scale_of(Palette.GREYS)
    times = round_times(field.floor())
    bands = np.searchsorted(times, field.floor() - 1e-3)
    legend = {entry.text: entry.color for entry in painted.legend.swatches}
    for band, name in enumerate((*(f"Up to {time:g} s" for time in times), "Longer")):
        np.testing.assert_array_equal(has_color(painted, legend[name]), (bands == band) & covered, err_msg=name)
    assert len({legend[f"Up to {time:g} s"] for time in times}) == len(times) > 1
    within = dict(painted.legend.numbers)
    for time, area in zip(times, field.areas(times), strict=True):
        assert within[f"Within {time:g} s"] == area_words(area)

    painted = paint(embedding, "REACH", goal=goal, bands=False)
    at, seconds = on_scale(painted, scale), field.floor()
    end = np.percentile(seconds[covered], 99)
    np.testing.assert_allclose(at[covered], 1 - np.minimum(seconds[covered] / end, 1), atol=3e-3)
    assert painted.legend.unit == "seconds" and painted.legend.bar.stops == scale.stops[::-1]
    with pytest.raises(MotionGraphError, match="off the ground"):
        paint(embedding, "REACH", goal=(50.0, 0.0))


def test_the_long_way_around(embedding):
    worst = finish(detours_steps(embedding)).worst
    painted = paint(embedding, "LONG_WAY", bands=False)
    at, known = on_scale(painted, scale_of(Palette.GREYS)), np.isfinite(worst)
    end = np.percentile(worst[known], 99)
    np.testing.assert_allclose(at[known], 1 - np.clip(worst[known] / end, 0, 1), atol=3e-3)
    banded = paint(embedding, "LONG_WAY")
    color = {entry.text: entry.color for entry in banded.legend.swatches}["Longer"]
    np.testing.assert_array_equal(has_color(banded, color), known & (worst > 8.001))


def test_goals(settings):
    scene = bpy.context.scene
    settings.map.quantity = "REACH"
    scene.cursor.location = (0.4, -2.0, 7.0)
    assert settings.map.to_core().goal == pytest.approx((0.4, -2.0))
    bpy.context.view_layer.objects.active = bpy.data.objects["Table"]
    settings.map.goal = "OBJECT"
    assert settings.map.to_core().goal == pytest.approx((-2.2, -2.95))
    with pytest.raises(RuntimeError, match="something stands there"):
        operators.paint_map()
    settings.map.goal = "CURSOR"
    assert operators.paint_map() == {"FINISHED"}
    assert not staleness.map_is_stale(scene)
    scene.cursor.location.x += 0.5
    assert staleness.map_is_stale(scene)


# ------------------------------------------------------------------------------------------- weak spots


@pytest.mark.parametrize("few", [0, 400])
def test_weak_spots(embedding, few):
    painted = paint(embedding, "WEAK_SPOTS", few_ways=few)
    found = finish(weak_spots_steps(embedding, WeakSpotSettings(threshold=few)))
    assert len(found.spots) > 0
    legend = {entry.text: entry for entry in painted.legend.swatches}
    for weakness in {spot.weakness for spot in found.spots}:
        numbers = [1 + i for i, spot in enumerate(found.spots) if spot.weakness is weakness]
        cells = has_color(painted, legend[weakness.value].color)
        np.testing.assert_array_equal(cells, np.isin(found.labels, numbers))
        assert legend[weakness.value].value == area_words(cells.sum() * embedding.environment.grid.cell_size**2)
    assert painted.numbers["weak_spots"] == len(found.spots)


# ------------------------------------------------------------------------------------------- the floor


def test_the_legend_stays_with_the_floor(settings, tmp_path):
    operators.paint_map()
    scene = bpy.context.scene
    legend = floor_legend(find_floor(scene))
    assert legend.title == "Variability"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "map.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "map.blend"))
    floor = find_floor(bpy.context.scene)
    assert floor_legend(floor) == legend
    for nonsense in ("", "{}", 3):
        floor[LEGEND_PROPERTY] = nonsense
        assert floor_legend(floor) is None


@pytest.mark.parametrize("size", [7.0, 100.0])
def test_the_floor_lies_higher_where_it_is_looked_at_from_farther_away(size):
    scene, offset = bpy.context.scene, 0.01
    grid = Grid.over_rectangle((0.0, 0.0), (size, size), size / 4, 4)
    painted = PaintedMap(np.ones((4, 4, 4)), MapLegend("Test"))
    floor = put_on_floor(scene, grid, 0.5, offset, painted)
    above = floor.data.vertices[0].co.z - 0.5
    assert above == pytest.approx(max(offset, 4e-4 * size * np.sqrt(2)), abs=1e-6)
    # In the same place it is not built again, in another one it is.
    floor.data.vertices[0].co.z = 9.0
    put_on_floor(scene, grid, 0.5, offset, painted)
    assert floor.data.vertices[0].co.z == 9.0
    put_on_floor(scene, grid, 0.6, offset, painted)
    assert floor.data.vertices[0].co.z == pytest.approx(0.6 + above, abs=1e-6)


def test_segments_are_offered_by_name(settings):
    graph = store.results(bpy.context.scene).graph
    assert segment_names(settings.map, bpy.context, "") == [segment.name for segment in graph.segments]
    found = segment_names(settings.map, bpy.context, "ARC")
    assert found and all("arc" in name for name in found)
    # Maps, walks and questions are of what was embedded, whatever was built since.
    settings.graph.mirror_clips = True
    assert operators.build_motion_graph() == {"FINISHED"}
    assert store.results(bpy.context.scene).graph is not graph
    assert segment_names(settings.map, bpy.context, "") == [segment.name for segment in graph.segments]
    assert any("mirror" in clip.name for clip in store.results(bpy.context.scene).graph.clips)
    clips = clip_names(settings.walk, bpy.context, "")
    assert clips and not any("mirror" in name for name in clips)


# --------------------------------------------------------------------------------------------- palettes


@pytest.mark.parametrize("palette", [Palette.VIRIDIS, Palette.CIVIDIS])
def test_palettes_are_for_everybody(palette):
    scale = scale_of(palette)
    others = {"unreached": scale.unreached, "ruled": scale.ruled, "blocked": scale.blocked}
    for sight, matrix in SIGHTS.items():
        seen = [lab(color, matrix) for color in scale.stops]
        # From dark to light all the way: no two amounts look alike, not even on paper.
        assert np.all(np.diff([color[0] for color in seen]) > 2), sight
        for name, color in others.items():
            nearest = min(np.linalg.norm(lab(color, matrix) - stop) for stop in seen)
            assert nearest > 10, (sight, name, nearest)
        for (a, one), (b, other) in combinations(others.items(), 2):
            assert np.linalg.norm(lab(one, matrix) - lab(other, matrix)) > 12, (sight, a, b)


@pytest.mark.parametrize("palette", [Palette.VIRIDIS, Palette.CIVIDIS])
def test_palettes_are_the_published_ones(palette):
    matplotlib = pytest.importorskip("matplotlib")
    share = np.linspace(0, 1, 256)
    published = matplotlib.colormaps[palette.value](share)[:, :3]
    assert np.abs(scale_of(palette).colors(share) - published).max() < 0.04
