"""Why the character cannot go somewhere, painted and counted; and embedding again after something moved."""

from itertools import combinations

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.properties import MapQuantity
from bl_ext.user_default.wayfarer.addon.render.floor import FLOOR_NAME, find_floor, floor_legend
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.core.evaluation.floor import floor_cells, ruled_cells
from bl_ext.user_default.wayfarer.core.evaluation.why_not import (
    Reason,
    floor_reasons,
    lost_links_steps,
    reason_shares,
    why_not_steps,
)
from bl_ext.user_default.wayfarer.core.maps.colors import linear
from bl_ext.user_default.wayfarer.core.maps.reasons import reason_colors, reason_legend
from bl_ext.user_default.wayfarer.core.progress import finish

operators = bpy.ops.wayfarer

# Linear RGB as protanopes, deuteranopes and tritanopes see it (Machado, Oliveira and Fernandes 2009, severity 1).
SIGHTS = {
    "usual": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def build(*steps):
    for step in steps:
        assert getattr(operators, step)() == {"FINISHED"}


def results():
    return store.results(bpy.context.scene)


def lab(srgb, sight) -> np.ndarray:
    seen = np.clip(np.asarray(sight) @ linear(srgb), 0, 1)
    x, y, z = np.cbrt(np.maximum(XYZ @ seen / (XYZ @ np.ones(3)), 1e-4))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


# --------------------------------------------------------------------------------------------------- map


def test_one_reason_for_each_cell():
    blocked, out, into, embedded = Reason.BLOCKED, Reason.NO_WAY_OUT, Reason.NO_WAY_IN, Reason.EMBEDDED
    headings = np.array(
        [[[blocked] * 4, [out, into, into, out], [into, into, out, into], [out, out, out, embedded]]], dtype=np.uint8
    )
    assert floor_reasons(headings).tolist() == [[blocked, out, into, embedded]]


def test_every_reason_has_a_colour_that_everybody_can_tell_apart():
    legend = reason_legend()
    assert list(legend) == [reason.name for reason in Reason]
    for name, sight in SIGHTS.items():
        for (_, a), (_, b) in combinations(legend.values(), 2):
            assert np.linalg.norm(lab(a, sight) - lab(b, sight)) > 12, (name, a, b)


def test_reasons_are_painted(settings):
    settings.map.quantity = MapQuantity.WHY_NOT.name
    build("build_motion_graph", "embed", "paint_map")
    found = results()
    environment = found.embedding.environment
    reasons = floor_reasons(finish(why_not_steps(found.embedding)))
    floor = bpy.data.objects[FLOOR_NAME].data
    colors = np.empty(4 * len(floor.vertices), dtype=np.float32)
    floor.color_attributes.active_color.data.foreach_get("color", colors)
    colors = colors.reshape(*reasons.shape, 4, 4)[:, :, 0]
    np.testing.assert_allclose(colors, reason_colors(reasons), atol=1e-6)
    covered = found.embedding.node_mask().any(axis=(2, 3))
    np.testing.assert_array_equal(reasons == Reason.EMBEDDED, covered)
    # These walks cannot step over anything: what lies behind the step is out of reach, and not for being blocked.
    assert len({Reason.EMBEDDED, Reason.BLOCKED, Reason.RULE} & set(np.unique(reasons))) == 3
    # The free part of the step is its rule to whoever looks at the map, and nothing else is.
    np.testing.assert_array_equal(reasons == Reason.RULE, ruled_cells(environment))
    # What coverage is a share of is what the map shows as reached, or as not reached for a reason of motion.
    np.testing.assert_array_equal(
        floor_cells(found.embedding), ~np.isin(reasons, [Reason.BLOCKED, Reason.RULE, Reason.FORBIDDEN])
    )
    assert "Crossed by 'step' Only" in [entry.text for entry in floor_legend(find_floor(bpy.context.scene)).swatches]
    shares = found.painted.numbers["reasons"]
    assert shares == reason_shares(reasons)
    assert sum(shares.values()) == pytest.approx(1)
    assert shares["EMBEDDED"] == pytest.approx(covered.mean())
    assert not staleness.map_is_stale(bpy.context.scene)
    settings.map.quantity = MapQuantity.VARIABILITY.name
    assert staleness.map_is_stale(bpy.context.scene)
    build("paint_map")
    assert found.painted.numbers["map_highest"] > 0


# ------------------------------------------------------------------------------------------------- links


def test_lost_links_are_counted_when_asked(settings):
    build("build_motion_graph", "embed")
    scene = bpy.context.scene
    assert store.lost_links(scene) is None
    build("count_lost_links")
    lost = store.lost_links(scene)
    assert lost == finish(lost_links_steps(results().embedding))
    assert lost.possible == lost.obstacles + lost.regions + lost.free
    assert min(lost.obstacles, lost.regions, lost.embedded) > 0
    build("embed")
    assert store.lost_links(scene) is None


# ------------------------------------------------------------------------------------------------- again


def test_embedding_again_equals_embedding_anew(settings):
    build("build_motion_graph", "embed")
    first = results().embedding
    table = bpy.data.objects["Table"]
    table.location.x += 0.6
    bpy.context.view_layer.update()
    build("embed")
    again, numbers = results().embedding, results().summary
    assert again is not first and again.planes != first.planes
    results().embedding = None
    build("embed")
    anew = results().embedding
    assert again.planes == anew.planes
    np.testing.assert_array_equal(again.in_degree(), anew.in_degree())
    np.testing.assert_array_equal(again.out_degree(), anew.out_degree())
    assert numbers == results().summary
    # And back to where it was.
    table.location.x -= 0.6
    bpy.context.view_layer.update()
    build("embed")
    assert results().embedding.planes == first.planes
