"""The whole workflow in a real Blender with a window, by mouse and keys.

It happens once, in session.py, a chapter after the other; each test here looks at one chapter. The pictures that are
taken on the way are kept in dist/window, or in the folder that WAYFARER_PICTURES names. WAYFARER_BLENDER_ROOT names the
folder that holds a system with Blender in it, default /opt/blender-sid; without it all this is skipped.
"""

import math

import pytest

NOTHING_STALE = {"graph": False, "embedding": False, "map": False, "walk": False}


def test_the_zip_is_installed(session):
    assert session.chapter("install")["done"] == ["FINISHED"]


def test_the_tab_has_the_panels_in_the_order_of_the_work(session):
    found = session.chapter("look_around")
    order = ["Clips", "Motion Graph", "Environment", "Embedding", "Map", "Evaluation", "Tuning", "Queries", "Walk"]
    assert [label for label in found["panels"] if label in order] == order
    # Nothing can be pressed before what it needs is there.
    assert {"build_motion_graph", "embed", "paint_map", "random_walk"} <= set(found["disabled"])
    assert "add_sample_character" not in found["disabled"]


def test_the_sample_character_is_added_by_its_button(session):
    assert session.chapter("add_character")["clips"] == 28


def test_the_sample_room_is_added_from_its_menu(session):
    found = session.chapter("add_room")
    assert found["ground"] == "Ground" and found["regions"] == 1
    # A fresh file has no room for names with numbers.
    assert found["collections"] == ["Wayfarer Character", "Wayfarer Obstacles", "Wayfarer Regions", "Wayfarer Room"]


@pytest.mark.parametrize(
    ("moment", "is_shown"),
    [
        ("ticked", True),
        ("panel_closed", True),
        ("other_tab", True),
        ("sidebar_hidden", True),
        ("unticked", False),
    ],
)
def test_the_environment_is_drawn_while_its_box_is_ticked(session, moment, is_shown):
    found = session.chapter("show_environment")
    from_plain, from_lines, drawn_at_rest = found[moment]
    assert found["lines"] > 500 and found["tab"] != "Wayfarer"
    assert (from_plain, from_lines) == ((found["lines"], 0) if is_shown else (0, found["lines"]))
    assert drawn_at_rest == 0, "it is drawn for ever"


@pytest.mark.parametrize("chapter", ["cancel_building", "cancel_embedding"])
def test_escape_in_the_middle_of_long_work_changes_nothing(session, chapter):
    found = session.chapter(chapter)
    assert found["ran"] == 4, "it did not run any more when Esc was pressed"
    assert found["same"]


def test_a_cancelled_embedding_leaves_the_one_before(session):
    assert session.chapter("cancel_embedding")["stale"] == NOTHING_STALE


def test_the_buttons_build_embed_and_paint(session):
    assert session.chapter("build")["segments"] > 50
    found = session.chapter("embed")
    assert found["nodes"] > 1_000_000 and found["stale"] == NOTHING_STALE
    assert session.chapter("paint")["stale"] == NOTHING_STALE


def test_the_legend_is_drawn_in_the_viewport(session):
    found = session.chapter("look_at_legend")
    width, height = found["size"]
    assert 150 < width < 400 and 80 < height < 300
    assert found["inside"], "it lies over the sidebar, or outside of the viewport"
    # Text beside it is smoothed, so colours are taken with a little doubt.
    assert found["farthest_color"] <= 8, "a colour of the legend is not on the screen"
    assert found["back"]


def test_undo_and_redo_of_a_map(session):
    found = session.chapter("undo_map")
    assert found["gone"] and found["same"] and found["stale"] == NOTHING_STALE


def test_the_map_follows_a_pillar_that_is_dragged(session):
    found = session.chapter("move_pillar")
    assert found["selected"]
    x, y, z = found["moved"]
    assert abs(x) > 0.5 and abs(y) > 0.5 and abs(z) < 1e-4
    assert found["followed"], "it was painted anew only when the pillar was put down"
    assert found["changed"] and found["pixels"] > 5000
    assert found["stale"] == NOTHING_STALE
    assert found["off"]


def test_the_map_follows_when_the_pillar_is_put_back_by_undo(session):
    assert session.chapter("move_pillar")["stale_after_undo"] == NOTHING_STALE


def test_another_map_is_painted_as_soon_as_it_is_chosen(session):
    assert session.chapter("ask_why_not")["legend"] == "Why Not"


def test_weak_spots_are_found_by_their_button(session):
    assert int(session.chapter("evaluate")["weak_spots"]["Weak Spots"].split()[0]) > 0


def test_pruning_and_its_way_back(session):
    found = session.chapter("tune")
    assert 0 < found["pruned"]["nodes"] < found["before"]["nodes"]
    assert 0 < found["pruned"]["links"] < found["before"]["links"]
    assert found["restored"] == found["before"] and found["stale"] == NOTHING_STALE


def test_metrics_are_measured_by_their_button(session):
    assert "m²" in session.chapter("evaluate")["metrics"]["Position"]


def test_times_to_reach_are_found_by_their_button(session):
    assert session.chapter("query")["numbers"]


def test_the_walk_is_baked_and_stays_in_the_room(session):
    found = session.chapter("walk")
    first, last = found["frames"]
    assert last - first > 1700 and found["plays"] and found["stale"] == NOTHING_STALE
    assert all(abs(x) < 3.5 and abs(y) < 4 and 0.5 < z < 1.2 for x, y, z in found["places"])
    assert len({tuple(place) for place in found["places"]}) == len(found["places"])


def test_undo_and_redo_of_a_walk(session):
    found = session.chapter("undo_walk")
    assert found["gone"] and found["map_stays"] and found["same"] and found["stale"] == NOTHING_STALE


def test_a_clip_less_makes_everything_out_of_date_until_it_is_made_anew(session):
    found = session.chapter("untick_clip")
    assert found["stale"] == dict.fromkeys(NOTHING_STALE, True)
    assert found["clips"] > 0 and found["clips_left"] == 0
    # Nobody has walked anew.
    assert found["stale_after"] == {**NOTHING_STALE, "walk": True}


def test_maps_are_chosen_by_menu_slider_and_name(session):
    found = session.chapter("choose_map")
    assert found["typed"] == pytest.approx(math.pi / 2)
    assert found["dragged"] > found["typed"]
    assert found["back"]
    assert found["wanted"] in found["segment"] and found["legend"] == found["segment"]
    assert not found["stale"]["map"]


def test_a_place_tells_its_numbers(session):
    place = session.chapter("pick_place")["place"]
    assert place[0].endswith("m") and len(place) > 5


def test_times_to_a_region_are_found_by_its_name(session):
    found = session.chapter("reach_region")
    assert found["region"] == "Step" and found["numbers"]


def test_walks_start_where_the_floor_is_clicked(session):
    found = session.chapter("walks_from")
    assert found["after_escape"] == 0
    assert len(found["distances"]) == 5
    # From the middle of the cell.
    assert all(distance <= 0.25 for distance in found["distances"])


@pytest.mark.parametrize("chart", ["sweep", "ablation", "metrics"])
def test_charts_open_in_the_browser(session, chart):
    found = session.chapter("charts")
    _, width, height, colors = found[chart]
    assert width > 500 and height > 200 and colors >= 3


def test_every_chart_has_a_page_of_its_own(session):
    found = session.chapter("charts")
    assert len({found[chart][0] for chart in ("sweep", "ablation", "metrics")}) == 3


def test_a_walk_is_baked_as_strips_and_as_a_copy(session):
    found = session.chapter("bake_otherwise")
    assert found["strips"]["Wayfarer Walk"] > 2 and not found["action_with_strips"]
    assert len(found["copies"]) == 1
    # As an action again, the strips are gone that would move the character under it.
    assert found["plays"] and "Wayfarer Walk" not in found["tracks_left"]


def test_a_crowd_walks_without_meeting(session):
    found = session.chapter("crowd")
    # One that others shut in gets no walk, and that is said.
    assert found["walkers"] >= 3 and found["walkers"] + found["left_out"] == 4 and found["closest"] >= 0.59
    assert all(abs(x) < 3.5 and abs(y) < 4 and 0.5 < z < 1.2 for frame in found["places"] for x, y, z in frame)
    assert found["places"][0] != found["places"][1] != found["places"][2]
    assert not found["collection"]


def test_escape_leaves_the_crowd_of_before(session):
    found = session.chapter("crowd")
    assert found["ran"] == 4, "it did not run any more when Esc was pressed"
    assert found["same"]


def test_the_report_is_written_and_opened(session):
    found = session.chapter("write_report")
    assert found["page"].endswith("report.html") and found["ends"]
    assert {"What can it reach?", "What is weak?"} <= set(found["headings"]) and len(found["headings"]) > 8
    assert found["pictures"] > 5
    assert len(found["files"]) > 1 and all(found["files"].values())


def test_the_results_are_exported(session):
    found = session.chapter("export_results")
    assert {"results.json", "map.png"} <= set(found["files"]) and all(found["files"].values())
    assert {f"{kind.lower()}.csv" for kind in found["findings"]} <= set(found["files"])


def test_a_region_is_added_and_drawn(session):
    found = session.chapter("add_region")
    assert found["region"] == ["Rug", "FORBID", "step"]
    assert found["drawn"] > 100 and found["object_stays"]


def test_presets_bring_settings_back(session):
    assert session.chapter("keep_preset")["rate"] == pytest.approx(0.11)


LEGEND_LINE = 19
"""Pixels at the interface's usual size."""


@pytest.mark.parametrize("chapter", ["light_theme", "large_interface"])
def test_the_legend_follows_theme_and_size(session, chapter):
    usual, found = session.chapter("look_at_legend"), session.chapter(chapter)["legend"]
    assert found["inside"] and found["farthest_color"] <= 12 and found["back"]
    factor = 1.5 if chapter == "large_interface" else 1.0
    # Each swatch is a line more.
    height = usual["size"][1] + LEGEND_LINE * (found["swatches"] - usual["swatches"])
    assert found["size"][1] == pytest.approx(factor * height, rel=0.1)


def test_everything_is_there_when_the_file_is_opened_again(session):
    found = session.chapter("save_and_reopen")
    assert found["same"] and found["problem"] == ""
    assert found["stale"] == NOTHING_STALE


def test_disabling_it_leaves_the_scene(session):
    assert session.chapter("disable")["objects"] > 10


def test_nothing_went_wrong_unseen(session):
    assert session.code == 0
    for word in ("Traceback", "Error:", "rna_uiItem", "unknown operator"):
        assert word not in session.log, session.log


def test_the_pictures_are_kept(session):
    names = {path.stem for path in session.pictures.glob("*.png")}
    assert {"01_empty", "09_map", "10_dragging", "12_why_not", "14_walk", "33_crowd", "18_opened_again"} <= names
