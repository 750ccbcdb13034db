"""Live evaluation in a real window: the chapter time_changes of the session. Its times are in facts.json."""

import pytest

NOTHING_STALE = {"graph": False, "embedding": False, "map": False, "walk": False}


@pytest.mark.parametrize("chapter", ["time_changes", "time_few_links"])
def test_times_are_told_as_they_are(session, chapter):
    found = session.chapter(chapter)
    assert 0 < found["written"] <= found["picture"] < 60
    # The panel tells what was measured from outside; that begins and ends at slightly other moments.
    written, drawn = found["said"]
    assert 0 < written <= found["written"] + 1.0 and written < drawn <= found["picture"] + 1.0
    assert set(found["work"]) == {"read", "environment", "embed", "map", "paint", "count"}
    assert found["stale"] == NOTHING_STALE


def test_the_panel_tells_how_long_it_took(session):
    found = session.chapter("time_changes")
    assert found["status"].startswith(("Painted after", "Updat"))
    assert 0 < found["redraw_viewport"] < 60 and 0 < found["redraw_area"] < 60


def test_the_papers_number_of_links_is_no_special_case(session):
    size = session.chapter("time_few_links")["size"]
    assert size["nodes"] > 0 and size["links"] > 0 and size["segments"] > 0
    assert session.chapter("time_changes")["size"]["links"] > 100 * size["links"]


def test_where_drawing_takes_longer_than_the_work_both_are_in_one_picture(session):
    assert session.chapter("time_changes")["one_picture"]


def test_nothing_is_painted_in_the_middle_of_a_script(session):
    assert session.chapter("time_changes")["left_to_the_script"]


def test_no_floor_is_made_while_something_is_dragged(session):
    found = session.chapter("drag_without_floor")
    assert not found["while_dragged"] and found["stale"] == found["stale_at_the_end"] == NOTHING_STALE
    # Undo took the floor away, and nothing else.
    assert found["moved"][0] > 0.05 and found["moved"][0] == pytest.approx(found["moved"][1])
