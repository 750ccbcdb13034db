"""The panel Evaluation: what its buttons find out is what the core says, and they leave no trace where they fail."""

import csv
import json
import re
from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.results import findings
from bl_ext.user_default.wayfarer.addon.ui.lists import WAYFARER_UL_findings
from bl_ext.user_default.wayfarer.core.evaluation.ablation import ablate_steps, without_steps
from bl_ext.user_default.wayfarer.core.evaluation.action_coverage import action_coverage
from bl_ext.user_default.wayfarer.core.evaluation.capture.candidate import candidates
from bl_ext.user_default.wayfarer.core.evaluation.capture.director import direct_capture_steps
from bl_ext.user_default.wayfarer.core.evaluation.deletion import deletable_together_steps
from bl_ext.user_default.wayfarer.core.evaluation.environment_coverage import environment_coverage
from bl_ext.user_default.wayfarer.core.evaluation.link_utility import link_utility
from bl_ext.user_default.wayfarer.core.evaluation.maneuverability import maneuverabilities_steps
from bl_ext.user_default.wayfarer.core.evaluation.occupancy import occupancy_steps
from bl_ext.user_default.wayfarer.core.evaluation.path_efficiency import path_efficiency_steps
from bl_ext.user_default.wayfarer.core.evaluation.segment_groups import Grouping
from bl_ext.user_default.wayfarer.core.evaluation.turn_balance import turn_balance
from bl_ext.user_default.wayfarer.core.evaluation.weak_spots import Domain, WeakSpotSettings, weak_spots_steps
from bl_ext.user_default.wayfarer.core.maps.scales import SERIES
from bl_ext.user_default.wayfarer.core.progress import finish
from bl_ext.user_default.wayfarer.core.report import topics
from bl_ext.user_default.wayfarer.core.report.drawing import svg

from .findings import contents, embedding, found, is_stale, kept, lines, operators, refused, rows, run, undone
from .test_panel import Layout

ASKING = ("measure", "find_weak_spots", "ablate", "find_deletable", "direct_capture", "find_occupancy")


@pytest.fixture
def settings(sample_settings):
    run("build_motion_graph", "embed")
    return sample_settings


# ------------------------------------------------------------------------------------------------ numbers


def test_metrics_are_the_cores(settings):
    settings.evaluation.n_pairs, settings.evaluation.seed = 30, 3
    run("measure")
    here = embedding()
    ground, actions, turns, links = (
        f(here) for f in (environment_coverage, action_coverage, turn_balance, link_utility)
    )
    ways = finish(path_efficiency_steps(here, np.random.default_rng(3), 30, 6))
    waits = finish(maneuverabilities_steps(here, Grouping.CLIP))
    numbers = {name: value for name, value, _ in rows(topics.METRICS)}
    assert numbers["environment coverage by position"] == ground.position_share
    assert numbers["environment coverage by position and heading"] == ground.task_share
    assert numbers["floor covered in every heading"] == ground.full_area
    assert numbers["action coverage, mean over clips"] == actions.shares.mean()
    assert numbers["turn balance (-1: right, 1: left)"] == turns.total
    assert numbers["links that turn left"] == turns.n_left
    assert (numbers["path efficiency, mean"], numbers["path efficiency, pairs of places"]) == (ways.mean, 30)
    assert numbers["local maneuverability, mean over clips"] == np.mean([wait.mean for wait in waits])
    assert numbers["links of the motion graph that are never played"] == len(links.idle_links)
    by_clip = {row[0]: row[1:] for row in rows(topics.ACTIONS)}
    for action, area, wait in zip(actions.actions, actions.areas, waits, strict=True):
        assert by_clip[action.name][0] == area
        assert by_clip[action.name][2:] == (wait.mean, wait.worst, wait.at_once, wait.promptly)
    assert sum(row[2] for row in rows(topics.LINKS)) == links.n_links == here.n_links
    shown = dict(findings.numbers_of(kept(topics.METRICS)))
    assert shown["Position"] == f"{ground.position_share:.1%} ({ground.covered_area:.1f} m²)"
    assert shown["Path Efficiency"] == f"{ways.mean:.1%} ± {ways.standard_error:.1%}"
    assert shown["Sampled"] == "30 pairs, 6 goals"


def test_weak_spots_are_the_cores_and_can_be_looked_at(settings):
    settings.evaluation.domain, settings.evaluation.few_ways = "HEADINGS", 50
    run("find_weak_spots")
    spots = finish(
        weak_spots_steps(embedding(), WeakSpotSettings(Domain.HEADINGS, 50, settings.evaluation.min_area))
    ).spots
    assert len(spots) > 3 and [row[1] for row in rows(topics.WEAK_SPOTS)] == [spot.area for spot in spots]
    finding = kept(topics.WEAK_SPOTS)
    assert [tuple(row.place) for row in finding.rows] == [pytest.approx(spot.position) for spot in spots]
    assert finding.rows[0].sentence == spots[0].describe() + "."
    assert finding.active_row == -1
    before = contents()
    finding.active_row = 2
    cursor = bpy.context.scene.cursor.location
    assert tuple(cursor) == pytest.approx((*spots[2].position, found().ground_height))
    # Nothing else has changed; nothing is selected.
    assert {**contents(), "cursor": None} == {**before, "cursor": None}


@pytest.mark.parametrize("kind", [Grouping.CLIP, Grouping.SEGMENT])
def test_what_matters_is_the_cores(settings, kind):
    settings.evaluation.parts = kind.name
    run("ablate")
    ranked = finish(ablate_steps(embedding(), (kind,))).ranked(kind)
    assert lines(topics.ABLATION) == [loss.group.name for loss in ranked]
    assert [(row[2], row[5]) for row in rows(topics.ABLATION)] == [(loss.floor, loss.nodes) for loss in ranked]
    assert [row.note for row in kept(topics.ABLATION).rows] == [loss.verdict.name.title() for loss in ranked]
    # No clip of these carries a tag.
    settings.evaluation.parts = Grouping.TAG.name
    run("ablate")
    assert not rows(topics.ABLATION) and kept(topics.ABLATION).sentences == "There is no tag to take away."


def test_deletable_clips_are_the_cores_and_can_be_unticked(settings):
    settings.evaluation.allowed_loss = 1.0
    run("find_deletable")
    joint = finish(deletable_together_steps(embedding(), 0.01))
    names = [part.name for part in joint.groups]
    assert len(names) > 1 and [row[1] for row in rows(topics.DELETION)] == names
    ticked = {clip.action.name for clip in settings.clips if clip.use}
    undone("untick_clips")
    run("untick_clips")
    # Undo has replaced the scene.
    assert {clip.action.name for clip in bpy.context.scene.wayfarer.clips if clip.use} == ticked - set(names)
    # What is left is what was promised: the same segments are played, whatever else the threshold now allows.
    gone = [i for part in joint.groups for i in part.segments]
    assert finish(without_steps(embedding(), gone)).n_nodes == joint.left.nodes
    assert operators.untick_clips() == {"CANCELLED"}


def test_a_clip_stays_if_its_mirror_image_must(settings):
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "arc"))
    settings.graph.mirror_clips = True
    run("build_motion_graph", "embed")
    settings.evaluation.allowed_loss = 5.0
    run("find_deletable")
    deletable = {row[1] for row in rows(topics.DELETION)}
    played = {found().graph.clips[segment.clip].name for segment in found().graph.segments}
    before = {clip.action.name for clip in settings.clips if clip.use}
    run("untick_clips")
    gone = before - {clip.action.name for clip in settings.clips if clip.use}
    assert gone
    for name in before:
        both = {name, f"{name} (mirrored)"} & played
        assert (name in gone) == (bool(both & deletable) and both <= deletable)
    assert any(f"{name} (mirrored)" in deletable for name in before)


def test_missing_motions_are_the_cores(settings):
    settings.evaluation.n_candidates = 7
    run("direct_capture")
    tried = topics.capture.evenly_chosen(candidates(embedding()), 7)
    assert len(tried) == 7 and len({candidate.words for candidate in tried}) == 7
    advice = finish(direct_capture_steps(embedding(), tried))
    assert rows(topics.CAPTURE) == [tuple(row) for row in advice.table()[1]]
    useful = [gain for gain in advice.gains if gain.floor > 0 or gain.places > 0]
    assert [row.sentence for row in kept(topics.CAPTURE).rows] == [gain.describe() for gain in useful]
    assert kept(topics.CAPTURE).sentences.splitlines()[0] == advice.describe()[0]
    for row, gain in zip(kept(topics.CAPTURE).rows, useful, strict=True):
        assert row.has_place == gain.opened.any()
        if row.has_place:
            cell = embedding().environment.grid.cells(np.array(tuple(row.place), dtype=float))
            assert gain.opened[tuple(cell)]


def test_occupancy_is_the_cores(settings):
    run("find_occupancy")
    stationary = finish(occupancy_steps(embedding()))
    shares = dict(rows(topics.OCCUPANCY))
    names = [segment.name for segment in found().graph.segments]
    np.testing.assert_array_equal([shares[name] for name in names], stationary.segments)
    assert kept(topics.OCCUPANCY).sentences.splitlines() == stationary.describe()


# ---------------------------------------------------------------------------------------- what is kept


def test_findings_outlive_the_file_and_know_what_they_are_about(settings, tmp_path):
    run("find_weak_spots", "ablate")
    before = contents()
    assert not is_stale(topics.WEAK_SPOTS) and not is_stale(topics.ABLATION)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert contents()["findings"] == before["findings"]
    assert not is_stale(topics.WEAK_SPOTS)
    table = bpy.data.objects["Table"]
    table.location.x += 0.6
    bpy.context.view_layer.update()
    assert is_stale(topics.WEAK_SPOTS)
    run("embed")
    assert is_stale(topics.WEAK_SPOTS)
    run("find_weak_spots")
    assert not is_stale(topics.WEAK_SPOTS) and is_stale(topics.ABLATION)
    # And where it stood before, what was found out then is true again.
    table.location.x -= 0.6
    bpy.context.view_layer.update()
    run("embed")
    assert is_stale(topics.WEAK_SPOTS) and not is_stale(topics.ABLATION)


@pytest.mark.parametrize("damage", ["[" * 100_000, "7", "[[], [[1]]]", '[["a"], [[{}]]]', "", "[1e999"])
def test_findings_that_are_damaged_are_none(settings, damage):
    run("find_weak_spots")
    settings.findings[topics.WEAK_SPOTS.name].table = damage
    assert kept(topics.WEAK_SPOTS) is None and not is_stale(topics.WEAK_SPOTS)
    run("find_weak_spots")
    settings.findings[topics.WEAK_SPOTS.name].numbers = damage
    assert kept(topics.WEAK_SPOTS) is None
    run("find_weak_spots")
    assert kept(topics.WEAK_SPOTS) is not None


def test_undone_in_one_step(settings):
    settings.evaluation.n_candidates = 2
    for name in ASKING:
        undone(name)


def test_nothing_changes_before_the_work_is_done(settings):
    """Whoever presses Esc has changed nothing: it closes the generator, and nothing else has happened."""
    before, had = contents(), embedding()
    for name in ASKING:
        operator = getattr(bpy.types, f"WAYFARER_OT_{name}")
        work = operator.steps(operator, bpy.context)
        for _ in zip(range(25), work, strict=False):
            pass
        work.close()
        assert contents() == before and embedding() is had


def test_nothing_to_ask_without_an_embedding(sample_settings):
    for name in ASKING:
        assert "Embed the motion graph first" in refused(getattr(operators, name))
    assert "Find deletable clips first" in refused(operators.untick_clips)
    assert "Find something out first" in refused(operators.export_results)


def test_nothing_to_measure_where_nobody_can_go(settings):
    settings.environment.radius = 3.0
    run("embed")
    assert embedding().n_nodes == 0
    for name in ("measure", "find_weak_spots", "ablate", "find_deletable", "find_occupancy"):
        assert "the embedding is empty" in refused(getattr(operators, name))
    # What is missing can be asked all the same.
    settings.evaluation.n_candidates = 3
    run("direct_capture")
    assert len(rows(topics.CAPTURE)) == 3


# ---------------------------------------------------------------------------------------- charts, files


def test_charts_are_drawn_on_a_page(settings):
    for name, topic in (
        ("measure", topics.ACTIONS),
        ("ablate", topics.ABLATION),
        ("find_weak_spots", topics.WEAK_SPOTS),
    ):
        assert "not been found out" in refused(operators.show_chart, finding=topic.name)
        run(name)
        before = contents()
        for _ in range(2):
            assert operators.show_chart(finding=topic.name) == {"FINISHED"}
        assert contents() == before
        page = Path(bpy.app.tempdir, f"wayfarer_{topic.title.lower().replace(' ', '_')}.html").read_text("utf-8")
        [drawing] = re.findall(r"<svg.*?</svg>", page)
        blue = "#" + bytes(round(255 * value) for value in SERIES[0]).hex()
        bars = [float(width) for width in re.findall(rf'<rect[^>]* width="([0-9.]+)"[^>]* fill="{blue}"', drawing)]
        assert len(bars) == min(len(rows(topic)), 40) and svg(findings.chart_of(bpy.context.scene, topic)) == drawing
        # The longest bar takes most of the width that the names leave.
        assert 'width="640"' in drawing and max(bars) > 0.4 * 640
        # The numbers are there, too.
        assert page.count("<tr>") > len(rows(topic))


def test_results_are_exported(settings, tmp_path):
    run("find_weak_spots", "ablate", "paint_map")
    assert "no folder" in refused(operators.export_results, directory=str(tmp_path / "absent"))
    assert operators.export_results(directory=str(tmp_path)) == {"FINISHED"}
    names = {"results.json", "weak_spots.csv", "ablation.csv", "weak_spots.svg", "ablation.svg", "map.svg", "map.png"}
    assert {path.name for path in tmp_path.iterdir()} == names | {".wayfarer.json"}
    told = json.loads((tmp_path / "results.json").read_text())
    assert told["embedding"] == {"nodes": embedding().n_nodes, "links": embedding().n_links}
    table = findings.table_of(kept(topics.ABLATION))
    assert told["findings"]["ablation"]["table"] == table.records()
    assert told["findings"]["ablation"]["up_to_date"] is True
    with (tmp_path / "ablation.csv").open(newline="") as file:
        read = list(csv.reader(file))
    assert read[0] == list(table.columns) and len(read) == 1 + len(table.rows)
    image = bpy.data.images.load(str(tmp_path / "map.png"))
    assert tuple(image.size) == tuple(3 * size for size in embedding().shape[:2])
    assert 'width="720"' in (tmp_path / "map.svg").read_text()
    settings.evaluation.use_json = settings.evaluation.use_csv = settings.evaluation.use_pictures = False
    assert "Nothing is to be written" in refused(operators.export_results, directory=str(tmp_path))


def test_the_map_is_exported_as_it_is_painted(settings, tmp_path):
    run("paint_map", "ablate")
    settings.evaluation.use_csv = settings.evaluation.use_json = False
    operators.export_results(directory=str(tmp_path))
    image = bpy.data.images.load(str(tmp_path / "map.png"))
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(4 * image.size[0] * image.size[1], dtype=np.float32)
    image.pixels.foreach_get(values)
    picture = values.reshape(image.size[1], image.size[0], 4)[::-1, :, :3]
    # Three pixels each way for a cell: black where something stands, none of the scale's colours elsewhere.
    cells = picture[1::3, 1::3][::-1].swapaxes(0, 1)
    blocked = ~embedding().environment.free_cells() & ~embedding().covered().any(axis=2)
    covered = embedding().covered().any(axis=2)
    assert np.all(cells[blocked].max(axis=1) < 0.2)
    greys = cells[covered]
    assert np.all(greys.max(axis=1) - greys.min(axis=1) < 0.03) and np.all(greys.min(axis=1) > 0.25)


def test_a_report_is_written(settings, tmp_path):
    assert "no folder" in refused(operators.write_report, directory=str(tmp_path / "absent"))
    assert operators.write_report(directory=str(tmp_path)) == {"FINISHED"}
    page = (tmp_path / "Scene_report" / "report.html").read_text()
    assert f"{embedding().n_nodes:,} nodes" in page and "<svg" in page
    # Times count to what the queries ask for.
    assert "(0.0, 0.0) m" in page
    # The report and the panel say the same: same pairs of places, same allowance, same tables.
    run("measure", "find_deletable")
    written = tmp_path / "Scene_report"
    with open(written / "metrics.csv", encoding="utf-8", newline="") as file:
        read = list(csv.reader(file))[1:]
    for (name, value, unit), row in zip(rows(topics.METRICS), read, strict=True):
        assert [name, "" if value is None else str(value), unit] == row
    numbers = json.loads((written / "report.json").read_text("utf-8"))
    assert numbers["importance"]["deletable_together"] == [row[1] for row in rows(topics.DELETION)]
    assert kept(topics.METRICS).sentences.splitlines()[3] in page.replace("&#x27;", "'")


def test_lines_are_drawn_with_icons_that_exist(settings):
    run("measure", "find_weak_spots", "ablate", "find_deletable", "find_occupancy")
    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys()
    for kind in (topics.ACTIONS, topics.WEAK_SPOTS, topics.ABLATION, topics.DELETION, topics.OCCUPANCY):
        finding = kept(kind)
        assert len(finding.rows) > 1 and {row.icon for row in finding.rows} <= set(icons)
        for index, row in enumerate(finding.rows):
            layout = Layout()
            WAYFARER_UL_findings.draw_item(None, bpy.context, layout, finding, row, 0, None, "", index)
            drawn = [what[0] for what_kind, *what in layout.drawn if what_kind == "text"]
            # Of what matters, icon and sentence tell the verdict: a sidebar is narrow.
            note = "" if kind == topics.ABLATION else row.note
            # What areas are in stands above the list.
            name = row.name.removesuffix(" m²")
            assert (name == row.name) == (kind != topics.WEAK_SPOTS)
            assert drawn == [text for text in (name, row.value, note) if text or text == row.value]
