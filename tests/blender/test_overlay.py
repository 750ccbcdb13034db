"""What is drawn over the viewport, as far as that can be told without one: layouts, lines, and places under a mouse."""

from itertools import pairwise

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from bl_ext.user_default.wayfarer.addon.live import environment as environment_view
from bl_ext.user_default.wayfarer.addon.operators.floor_map import tip_box
from bl_ext.user_default.wayfarer.addon.operators.mixins import ground_under
from bl_ext.user_default.wayfarer.addon.render.environment_lines import BLOCKED, GROUND, RULES, body_lines
from bl_ext.user_default.wayfarer.addon.render.screen_box import BoxTheme, guarded, text_width
from bl_ext.user_default.wayfarer.addon.results import store
from bl_ext.user_default.wayfarer.addon.ui.overlay import legend_box
from bl_ext.user_default.wayfarer.core.environment.regions import RegionRule
from bl_ext.user_default.wayfarer.core.evaluation.place import place_report
from bl_ext.user_default.wayfarer.core.evaluation.why_not import why_not_steps
from bl_ext.user_default.wayfarer.core.maps.legend import ColorBar, MapLegend, Swatch
from bl_ext.user_default.wayfarer.core.progress import finish

operators = bpy.ops.wayfarer
LEGEND = MapLegend(
    title="Variability, Heading 45°",
    unit="ways",
    bar=ColorBar(((0.1, 0.1, 0.1), (0.5, 0.5, 0.5), (0.9, 0.9, 0.9)), ((0.0, "1"), (0.5, "1.08 M"), (1.0, "4.3 M+"))),
    swatches=(Swatch((0.5, 0.1, 0.1), "Cannot Go Here", "12%"), Swatch((0.0, 0.0, 0.0), "Too Near an Obstacle")),
    numbers=(("Cells", "12"),),
)


# ---------------------------------------------------------------------------------------------- legend


def test_a_legend_is_kept_as_text():
    assert MapLegend.from_json(LEGEND.to_json()) == LEGEND
    bare = MapLegend("Why Not")
    assert MapLegend.from_json(bare.to_json()) == bare
    for text in ("", "{}", "[]", '{"title": 1}', '{"title": "", "unit": "", "bar": null, "swatches": [3]}'):
        with pytest.raises((ValueError, KeyError, TypeError)):
            MapLegend.from_json(text)


@pytest.mark.parametrize("scale", [1.0, 1.7])
def test_everything_of_a_legend_lies_inside_its_box(scale):
    box = legend_box(LEGEND, scale, stale=True)
    for patch in box.patches:
        assert patch.x > 0 and patch.x + patch.width < box.width
        assert patch.y > 0 and patch.y + patch.height < box.height
    lines = {}
    for text in box.texts:
        assert text.x > 0 and 0 < text.y < box.height - text.points / 2
        lines.setdefault(round(text.y), []).append(text)
    shown = [text.text for text in box.texts]
    assert shown[:2] == [LEGEND.title, "Out of date"] and "ways" in shown and "12%" in shown
    # Lines keep apart, and texts on one line do not run into each other.
    heights = sorted(lines)
    assert min(np.diff(heights)) > 10 * scale
    for texts in lines.values():
        texts.sort(key=lambda text: text.x)
        for left, right in pairwise(texts):
            assert left.x + text_width(left.text, left.points) < right.x
        assert texts[-1].x + text_width(texts[-1].text, texts[-1].points) < box.width
    # The bar has no gaps.
    bar = [patch for patch in box.patches if not patch.framed]
    assert bar[0].x + bar[0].width == pytest.approx(bar[1].x) and bar[0].right == bar[1].left


def test_a_legend_grows_with_the_interface():
    small, large = legend_box(LEGEND, 1.0), legend_box(LEGEND, 2.0)
    assert large.height == pytest.approx(2 * small.height)
    assert large.width == pytest.approx(2 * small.width, rel=0.05)
    assert legend_box(LEGEND, 1.0, stale=True).height > small.height


def test_text_can_be_read_in_every_theme():
    colors = bpy.context.preferences.themes[0].user_interface.wcol_tooltip
    before = tuple(colors.inner), tuple(colors.text)
    try:
        for inner, text in (before, ((0.95, 0.95, 0.95, 1.0), (0.1, 0.1, 0.1))):
            colors.inner, colors.text = inner, text
            theme = BoxTheme.of(bpy.context.preferences)
            for color in (theme.text, theme.faint, theme.warning):
                assert len(color) == 4 and abs(np.mean(color[:3]) - np.mean(theme.background[:3])) > 0.2
    finally:
        colors.inner, colors.text = before


def test_a_draw_handler_complains_once(capsys):
    calls = []

    def broken():
        calls.append(1)
        raise RuntimeError("no such thing")

    handler = guarded(broken)
    for _ in range(3):
        handler()
    assert len(calls) == 1
    assert capsys.readouterr().err.count("Traceback") == 1


# ----------------------------------------------------------------------------------------- environment


def crossings(lines, x: float, y: float) -> int:
    """How often the pieces cross the ray from a point towards +X."""
    a, b = lines.points.reshape(-1, 2, 3)[:, :, :2].transpose(1, 0, 2)
    upright = np.isclose(a[:, 0], b[:, 0]) & ((a[:, 1] <= y) != (b[:, 1] <= y))
    return int((upright & (a[:, 0] > x)).sum())


def test_outlines_run_around_what_they_outline(sample_settings):
    scene = bpy.context.scene
    assert environment_view.environment_view(scene).lines == ()
    assert environment_view.look(scene, bpy.context.evaluated_depsgraph_get())
    assert not environment_view.look(scene, bpy.context.evaluated_depsgraph_get())
    view = environment_view.environment_view(scene)
    by_color = {lines.color: lines for lines in view.lines}
    assert set(by_color) == {GROUND, BLOCKED, RULES[RegionRule.REQUIRE]}
    rectangle = by_color[GROUND].points
    np.testing.assert_allclose(rectangle.min(axis=0)[:2], (-3.5, -4), atol=1e-6)
    np.testing.assert_allclose(rectangle.max(axis=0)[:2], (3.5, 4), atol=1e-6)
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    environment = store.results(scene).embedding.environment
    rng = np.random.default_rng(0)
    grid, blocked = environment.grid, environment.blocked
    for i, j in zip(rng.integers(0, blocked.shape[0], 200), rng.integers(0, blocked.shape[1], 200), strict=True):
        x, y = np.array(grid.origin) + (np.array([i, j]) + 0.5) * grid.sample_size
        # From the far end of its row: every border on the way changes sides.
        changes = np.count_nonzero(np.diff(blocked[i:, j].astype(int)))
        assert crossings(by_color[BLOCKED], x, y) == changes

    settings = scene.wayfarer.environment
    settings.radius += 0.1
    assert environment_view.look(scene, bpy.context.evaluated_depsgraph_get())
    assert environment_view.environment_view(scene) is not view
    settings.regions[0].tag = ""
    assert environment_view.look(scene, bpy.context.evaluated_depsgraph_get())
    assert "no tag" in environment_view.environment_view(scene).error


def test_the_circle_is_as_large_as_the_character_and_the_arrow_shows_the_heading():
    circle = body_lines(1.0, 2.0, 0.5, 0.25, None).points
    np.testing.assert_allclose(np.hypot(circle[:, 0] - 1, circle[:, 1] - 2), 0.25, atol=1e-6)
    arrow = body_lines(1.0, 2.0, 0.5, 0.25, np.pi / 2).points
    tip = arrow[np.argmax(arrow[:, 1])]
    assert tip[0] == pytest.approx(1.0, abs=1e-6) and tip[1] > 2.25


# ----------------------------------------------------------------------------------------------- place


class View:
    """The part of a viewport's data that places under the mouse are found with."""

    def __init__(self, matrix, perspective):
        self.view_matrix, self.is_perspective = matrix.inverted(), perspective
        window = Matrix.Identity(4)
        if perspective:
            window = Matrix(((2, 0, 0, 0), (0, 2, 0, 0), (0, 0, -1.0002, -0.02), (0, 0, -1, 0)))
        self.window_matrix = window
        self.perspective_matrix = window @ self.view_matrix
        self.view_perspective = "PERSP" if perspective else "ORTHO"


class Region:
    width, height = 800, 800


@pytest.mark.parametrize("perspective", [True, False])
def test_the_ground_under_the_mouse(perspective):
    camera = Matrix.Translation((1.0, -6.0, 5.0)) @ Euler((0.9, 0, 0.2)).to_matrix().to_4x4()
    view = View(camera, perspective)
    for x, y in ((0.3, -2.0), (1.2, -0.5)) if perspective else ((0.9, -5.4), (1.4, -5.0)):
        seen = view.perspective_matrix @ Vector((x, y, 0.25, 1.0))
        mouse = [(1 + seen[k] / seen.w) * 400 for k in (0, 1)]
        assert ground_under(Region, view, mouse, 0.25) == pytest.approx((x, y), abs=1e-3)
    if perspective:
        level = View(Matrix.Translation((0, 0, 5)) @ Euler((np.pi / 2, 0, 0)).to_matrix().to_4x4(), True)
        assert ground_under(Region, level, (400, 700), 0.0) is None, "the sky"


def test_the_numbers_of_a_place_are_those_of_the_maps(sample_settings):
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    embedding = store.results(bpy.context.scene).embedding
    ways = embedding.in_degree().astype(np.int64) * embedding.out_degree()
    reasons, grid = finish(why_not_steps(embedding)), embedding.environment.grid
    mask = embedding.node_mask()
    nx, ny, n_headings = grid.shape
    rng = np.random.default_rng(1)
    cells = np.column_stack([rng.integers(0, nx, 25), rng.integers(0, ny, 25)])
    for x, y in [*cells.tolist(), np.unravel_index(ways.sum(axis=(2, 3)).argmax(), (nx, ny))]:
        place = grid.positions(np.array([x, y])) + 0.3 * grid.cell_size
        report = place_report(embedding, *place, reasons=reasons)
        assert report.cell == (x, y)
        np.testing.assert_array_equal(report.variability, ways[x, y].sum(axis=1))
        assert report.n_covered == mask[x, y].any(axis=1).sum()
        names = {embedding.graph.segments[s].name: ways[x, y, :, s].sum() for s in np.flatnonzero(mask[x, y].any(0))}
        assert dict(report.segments) == names
        counts = [count for _, count in report.segments]
        assert counts == sorted(counts, reverse=True)
        assert (report.reason == "Can Go Here") == mask[x, y].any()
        assert report.lines()[1] == report.reason
    assert f"of {n_headings} headings" in "\n".join(report.lines())
    assert len(tip_box(report.lines(), 1.0).texts) == len(report.lines())
    assert place_report(embedding, 100.0, 0.0) is None
    assert place_report(embedding, *place).reason == ""
    on_step = place_report(embedding, 0.0, 1.45, reasons=reasons)
    assert on_step.reason == "Rule of the region: 'step' only (Step)"


def test_picking_from_a_script(sample_settings):
    for step in ("build_motion_graph", "embed"):
        getattr(operators, step)()
    assert operators.pick_place(location=(0.0, 1.45)) == {"FINISHED"}
    assert "Rule of the region" in sample_settings.overlay.place
    with pytest.raises(RuntimeError, match="beside the ground"):
        operators.pick_place(location=(50.0, 0.0))


def test_a_place_on_a_tiled_ground(sample_settings):
    environment = sample_settings.environment
    environment.tiled = True
    for obj in list(environment.obstacles.all_objects):
        if obj.name.startswith("Wall"):
            bpy.data.objects.remove(obj)
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    embedding = store.results(bpy.context.scene).embedding
    assert embedding.environment.grid.tiled
    ways = (embedding.in_degree().astype(np.int64) * embedding.out_degree()).sum(axis=3)
    for x, y in ((-3.4, -3.9), (3.45, 0.0), (0.0, 3.2)):
        cell = embedding.environment.grid.cells(np.array([x, y]))
        for tile in ((0, 0), (1, -2)):
            report = place_report(embedding, x + tile[0] * 7.0, y + tile[1] * 8.0)
            assert report.cell == tuple(cell)
            np.testing.assert_array_equal(report.variability, ways[tuple(cell)])
