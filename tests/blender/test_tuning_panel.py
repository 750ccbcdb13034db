"""The panel Tuning: the scene goes on with a pruned embedding, and with the whole one again."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.live.evaluation import LiveEvaluation
from bl_ext.user_default.wayfarer.addon.results import findings, staleness
from bl_ext.user_default.wayfarer.core.evaluation.variability import coverage_share, floor_variability
from bl_ext.user_default.wayfarer.core.progress import finish
from bl_ext.user_default.wayfarer.core.report import topics
from bl_ext.user_default.wayfarer.core.report.drawing import Line, svg
from bl_ext.user_default.wayfarer.core.tuning.budget import BudgetSettings, Limit, prune_to_budget_steps
from bl_ext.user_default.wayfarer.core.tuning.global_pruning import prune_global_steps
from bl_ext.user_default.wayfarer.core.tuning.local_pruning import prune_local_steps
from bl_ext.user_default.wayfarer.core.tuning.pruning_curve import pruning_curve_steps
from bl_ext.user_default.wayfarer.core.tuning.spanning import Places

from .findings import contents, embedding, found, is_stale, kept, operators, refused, rows, run, undone

K = 20


@pytest.fixture
def settings(sample_settings):
    run("build_motion_graph", "embed")
    sample_settings.tuning.k = K
    return sample_settings


def scene():
    return bpy.context.scene


# -------------------------------------------------------------------------------------------- three ways


def test_each_method_is_the_cores(settings):
    whole, tuning = embedding(), settings.tuning
    budget = whole.n_links // 10
    tuning.n_segments, tuning.max_links, tuning.coverage_loss = 30, budget, 5.0
    asked = BudgetSettings(Limit.LINKS, budget, Places.CELLS, 0.05)
    expected = {
        "LOCAL": finish(prune_local_steps(whole, K)),
        "GLOBAL": finish(prune_global_steps(whole, 30)).embedding,
        "BUDGET": finish(prune_to_budget_steps(whole, asked)).embedding,
    }
    for method, wanted in expected.items():
        tuning.method = method
        run("prune")
        # Always from the whole one, whatever the scene had last.
        assert embedding().planes == wanted.planes and embedding() is not whole
        assert found().whole is whole and found().pruning.words
        numbers = {name: (before, after) for name, before, after in rows(topics.PRUNING)}
        assert numbers["nodes"] == (whole.n_nodes, wanted.n_nodes)
        assert numbers["links"] == (whole.n_links, wanted.n_links)
        summary = found().summary
        assert (summary.nodes, summary.links) == (wanted.n_nodes, wanted.n_links)
        assert summary.coverage == coverage_share(wanted)
        assert not staleness.embedding_is_stale(scene())
    assert found().pruning.met and embedding().n_links <= budget
    tuning.limit, tuning.max_megabytes = "BYTES", 0.5
    run("prune")
    assert (
        embedding().planes
        == finish(
            prune_to_budget_steps(whole, BudgetSettings(Limit.BYTES, 500_000, Places.CELLS, 0.05))
        ).embedding.planes
    )
    run("restore_embedding")
    assert embedding() is whole and found().pruning is None and found().summary.nodes == whole.n_nodes


def test_a_budget_that_cannot_be_met_is_told(settings):
    settings.tuning.method, settings.tuning.max_links = "BUDGET", 10
    run("prune")
    assert not found().pruning.met and "cannot be met" in found().pruning.sentences[0]
    assert embedding().covered().any(axis=2).sum() == found().whole.covered().any(axis=2).sum()


def test_what_cannot_be_pruned_stays_as_it_is(settings):
    settings.tuning.method, settings.tuning.n_segments = "GLOBAL", 1000
    assert "keep 1 to that many" in refused(operators.prune)
    assert "was not pruned" in refused(operators.restore_embedding)
    whole = embedding()
    settings.tuning.method, settings.tuning.k = "LOCAL", 1000
    run("prune")
    assert embedding() is whole and found().pruning is None


def test_nothing_to_prune_without_an_embedding(sample_settings):
    for name in ("prune", "sweep_pruning"):
        assert "Embed the motion graph first" in refused(getattr(operators, name))


# ----------------------------------------------------------------------- what else works with the embedding


def test_maps_walks_and_questions_use_what_is_left(settings):
    run("paint_map", "prune")
    assert staleness.map_is_stale(scene())
    run("paint_map")
    assert not staleness.map_is_stale(scene())
    assert found().painted.numbers["map_highest"] == floor_variability(embedding()).max()
    run("random_walk")
    walk = found().walk
    assert walk.embedding is embedding() and not staleness.walk_is_stale(scene())
    assert all(embedding().node_mask()[tuple(walk.states.T)])
    run("find_reach", "ablate")
    assert not is_stale(topics.REACH) and not is_stale(topics.ABLATION)
    # What is missing, and the price of pruning, are asked of the whole embedding.
    settings.evaluation.n_candidates = 2
    run("direct_capture", "sweep_pruning")
    assert not is_stale(topics.CAPTURE) and not is_stale(topics.PRUNING_CURVE)
    run("restore_embedding")
    assert is_stale(topics.REACH) and is_stale(topics.ABLATION)
    assert not is_stale(topics.CAPTURE) and not is_stale(topics.PRUNING_CURVE)


def test_a_walk_is_out_of_date_where_nodes_are_gone(settings):
    run("random_walk", "prune")
    assert staleness.walk_changes(scene()) == ("The embedding was pruned",)
    # It led through nodes of the whole; what was walked in a part is there in the whole, too.
    run("restore_embedding")
    assert not staleness.walk_is_stale(scene())
    run("prune", "random_walk", "restore_embedding")
    assert found().walk.embedding is not embedding() and not staleness.walk_is_stale(scene())
    run("embed", "paint_map")
    bpy.data.objects["Table"].location.x += 0.6
    bpy.context.view_layer.update()
    run("embed")
    assert staleness.walk_changes(scene()) == ("The motion graph was embedded anew",)


def test_embedding_again_starts_from_the_whole(settings):
    whole = embedding()
    run("prune", "embed")
    assert embedding().planes == whole.planes and found().pruning is None
    # So does live evaluation, when an obstacle moves.
    run("prune")
    table = bpy.data.objects["Table"]
    table.location.x += 0.6
    bpy.context.view_layer.update()
    live = LiveEvaluation()
    while not live.step(scene(), bpy.context.evaluated_depsgraph_get(), 1.0):
        pass
    assert live.error == "" and found().pruning is None
    followed = embedding().planes
    found().embedding = None
    run("embed")
    assert embedding().planes == followed


def test_live_evaluation_paints_what_is_pruned(settings):
    run("paint_map", "prune")
    live = LiveEvaluation()
    while not live.step(scene(), bpy.context.evaluated_depsgraph_get(), 1.0):
        pass
    assert found().pruning is not None and found().painted.embedding is embedding()
    assert not staleness.map_is_stale(scene())


# -------------------------------------------------------------------------------------------- undo, files


def test_undo_and_redo_change_the_embedding(settings):
    whole = embedding()
    undone("prune")
    bpy.ops.ed.redo()
    pruned = embedding()
    assert pruned is not whole and found().whole is whole and found().summary.nodes == pruned.n_nodes
    undone("restore_embedding")
    assert embedding() is pruned
    bpy.ops.ed.redo()
    assert embedding() is whole and found().summary.links == whole.n_links
    # What was embedded since then is no business of undo's.
    bpy.ops.ed.undo()
    run("embed")
    anew = embedding()
    bpy.ops.ed.undo_push(message="something else")
    bpy.ops.ed.undo()
    assert embedding() is anew


def test_both_embeddings_outlive_the_file(settings, tmp_path):
    run("prune", "random_walk")
    whole, pruned, walked = found().whole.planes, embedding().planes, found().walk.states
    numbers = found().summary
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pruned.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pruned.blend"))
    assert found().problem == "" and found().pruning is not None
    assert embedding().planes == pruned and found().whole.planes == whole
    assert found().graph is embedding().graph is found().whole.graph
    assert found().summary.nodes == numbers.nodes and not staleness.embedding_is_stale(scene())
    assert not staleness.walk_is_stale(scene())
    np.testing.assert_array_equal(found().walk.states, walked)
    run("restore_embedding")
    assert embedding().planes == whole and found().summary.nodes == embedding().n_nodes


def test_a_pruned_embedding_that_does_not_fit_is_refused(settings, tmp_path):
    from bl_ext.user_default.wayfarer.core.errors import EmbeddingError
    from bl_ext.user_default.wayfarer.core.tuning import pruning

    run("prune")
    plain = pruning.pruning_to_plain(found().pruning)
    again = pruning.pruning_from_plain(plain, found().whole, embedding().planes)
    assert again.pruned.planes == embedding().planes and again.before == found().pruning.before
    with pytest.raises(EmbeddingError, match="no part of the whole"):
        pruning.pruning_from_plain(plain, embedding(), found().whole.planes)


# ---------------------------------------------------------------------------------------------- the sweep


def test_the_sweep_is_the_cores_and_is_drawn(settings):
    before = embedding()
    undone("sweep_pruning")
    run("sweep_pruning")
    curve = finish(pruning_curve_steps(embedding()))
    assert embedding() is before and found().pruning is None
    k, nodes, links, floor, places = (np.array(column) for column in zip(*rows(topics.PRUNING_CURVE), strict=True))
    np.testing.assert_array_equal(k, curve.k)
    np.testing.assert_array_equal(nodes, curve.n_nodes)
    np.testing.assert_array_equal(links, curve.n_links)
    np.testing.assert_array_equal(floor, curve.floor_coverage)
    np.testing.assert_array_equal(places, curve.coverage)
    shown = dict(findings.numbers_of(kept(topics.PRUNING_CURVE)))
    least = curve.smallest_k(0.9 * curve.floor_coverage[-1])
    assert shown["Keep 90% of Floor"].startswith(f"k {least}, ")
    # Four curves, as long as there are k; nodes and links end at the top.
    drawing = findings.chart_of(scene(), topics.PRUNING_CURVE)
    curves = [mark for mark in drawing.marks if isinstance(mark, Line) and len(mark.points) == len(k)]
    assert len(curves) == 4 and curves[2].points[-1, 1] == curves[3].points[-1, 1] < curves[0].points[-1, 1]
    assert svg(drawing) in Path(bpy.app.tempdir, "wayfarer_pruning_curve.html").read_text("utf-8")


def test_nothing_changes_before_the_work_is_done(settings):
    before, had = contents(), embedding()
    for name in ("prune", "sweep_pruning"):
        operator = getattr(bpy.types, f"WAYFARER_OT_{name}")
        work = operator.steps(operator, bpy.context)
        for _ in zip(range(25), work, strict=False):
            pass
        work.close()
        assert contents() == before and embedding() is had
