"""The third part of the session: other maps, questions to the floor, charts."""

import re
from pathlib import Path

import bpy
import editors
import hand
import numpy as np
import sidebar
from scene_facts import badges, colors, findings, keep_picture, log_browser, part, results, settings, settled

# In the sample room: between the pillars, and in front of the step.
PLACE, BEFORE_STEP = (0.2, -0.8, 0.0), (0.0, 0.6, 0.0)

_SPARE = ("pivot_", "walk_", *(f"turn_{side}_{angle}" for side in ("left", "right") for angle in (30, 45, 60)))
"""How the names of clips begin that the character can do without."""


def untick_clip(note) -> hand.Turns:
    """One clip less: everything says so, until it is made anew. With few clips, on a coarse grid, to be quick."""
    clip, before = settings().clips[0], results().graph
    yield from sidebar.press_button("Clips", "wayfarer.clips[0].use", sidebar.TICKS)
    yield from hand.until(lambda: not clip.use and badges()["graph"], "the motion graph to be out of date")
    yield from hand.rest()
    note("stale", badges())
    keep_picture("20_one_clip_less")
    environment = settings().environment
    environment.cell_size, environment.n_headings = 0.25, 12
    for other in settings().clips:
        other.use &= not other.action.name.startswith(_SPARE)
    yield from sidebar.press_button("Motion Graph", "wayfarer.build_motion_graph")
    yield from hand.until(lambda: results().graph is not before, "the motion graph of the rest")
    yield from hand.work_is_done()
    note("clips", [before.clips[s.clip].name for s in before.segments].count(clip.action.name))
    after = results().graph
    note("clips_left", [after.clips[s.clip].name for s in after.segments].count(clip.action.name))
    before = results().embedding
    yield from sidebar.press_button("Embedding", "wayfarer.embed")
    yield from hand.until(lambda: results().embedding is not before, "the embedding of the rest")
    yield from hand.work_is_done()
    yield from sidebar.press_button("Map", "wayfarer.paint_map")
    yield from hand.until(lambda: not badges()["map"], "the map of the rest")
    yield from hand.work_is_done()
    note("stale_after", badges())


def choose_map(note) -> hand.Turns:
    """Another map from the menu, another scale of colours, a single heading, a single segment: each is seen at once."""
    chosen = settings().map
    chosen.quantity = "VARIABILITY"
    yield from settled()
    seen = [colors()]
    place = yield from sidebar.point_at("Map", "wayfarer.map.quantity")
    yield from editors.open_popup(*place)
    keep_picture("21_menu_of_maps")
    yield from hand.press("ESC")
    yield from hand.redrawn()
    yield from editors.turn_to("Map", "wayfarer.map.palette", lambda: chosen.palette, "VIRIDIS")
    yield from _repainted(seen)
    yield from sidebar.press_button("Map", "wayfarer.map.use_heading", sidebar.BESIDE_LABEL)
    yield from _repainted(seen)
    yield from editors.fill("Map", "wayfarer.map.heading", "90")
    yield from _repainted(seen)
    note("typed", chosen.heading)
    yield from sidebar.point_at("Map", "wayfarer.map.heading")
    yield from hand.drag(120, 0)
    note("dragged", chosen.heading)
    yield from settled()
    keep_picture("22_single_heading")
    yield from sidebar.press_button("Map", "wayfarer.map.use_heading", sidebar.BESIDE_LABEL)
    yield from settled()
    yield from editors.turn_to("Map", "wayfarer.map.palette", lambda: chosen.palette, "GREYS")
    yield from settled()
    note("back", colors() == seen[0])
    yield from editors.turn_to("Map", "wayfarer.map.quantity", lambda: chosen.quantity, "SEGMENT")
    yield from _repainted(seen)
    wanted = _clip_that_differs(results().embedding)
    yield from editors.search("Map", "wayfarer.map.segment", wanted)
    yield from _repainted(seen)
    note("segment", chosen.segment)
    note("wanted", wanted)
    note("legend", part("render.floor").floor_legend(part("render.floor").find_floor(bpy.context.scene)).title)
    keep_picture("23_single_segment")
    chosen.quantity = "VARIABILITY"
    yield from settled()
    note("stale", badges())


def _clip_that_differs(embedding) -> str:
    """A clip whose segments all have another map than the first of the graph, which is shown where none is chosen.

    Its name can be typed: letters only.
    """
    graph, at_places = embedding.graph, np.moveaxis(embedding.node_mask().sum(axis=2), -1, 0)
    alike = {graph.clips[graph.segments[s].clip].name for s, at in enumerate(at_places) if (at == at_places[0]).all()}
    return next(clip.name for clip in graph.clips if clip.name.isalpha() and clip.name not in alike)


def _repainted(seen: list[str]) -> hand.Turns:
    """Until the floor has colours that it has not had before, which are added to ``seen``."""
    yield from hand.until(lambda: colors() not in seen, "another map")
    yield from settled()
    seen.append(colors())


def pick_place(note) -> hand.Turns:
    """The numbers of a place under the mouse, kept by a click."""
    yield from sidebar.open_part("Map", "Place")
    yield from sidebar.press_button("Map", "wayfarer.pick_place")
    yield from hand.until(lambda: "WAYFARER_OT_pick_place" in hand.running(), "the eyedropper")
    yield from hand.move(*hand.pixel_of(BEFORE_STEP))
    yield from hand.redrawn()
    yield from hand.click(*hand.pixel_of(PLACE))
    yield from hand.until(lambda: settings().overlay.place, "the numbers of the place")
    yield from hand.redrawn()
    note("place", settings().overlay.place.splitlines())
    keep_picture("24_place")
    yield from hand.press("ESC")
    yield from hand.until(lambda: not hand.running(), "the eyedropper to end")
    yield from sidebar.close_part("Map", "Place")


def reach_region(note) -> hand.Turns:
    """How long does it take to a region, and what does the floor look like then?"""
    asked = settings().queries
    yield from editors.turn_to("Queries", "wayfarer.queries.goal", lambda: asked.goal, "REGION")
    yield from editors.search("Queries", "wayfarer.queries.region", "s")
    note("region", asked.region)
    before = findings().get("REACH")
    yield from sidebar.press_button("Queries", "wayfarer.find_reach")
    yield from hand.until(lambda: findings().get("REACH") != before, "the times to the region")
    yield from hand.work_is_done()
    note("numbers", findings()["REACH"])
    settings().map.quantity = "QUERY"
    yield from settled()
    keep_picture("25_to_a_region")
    settings().map.quantity = "VARIABILITY"
    yield from settled()


def walks_from(note) -> hand.Turns:
    """Click a place on the floor and see walks from there; Esc before the click changes nothing."""
    walks = part("render.walk_fan")
    output = bpy.data.collections[part("bridge.owned").OUTPUT]
    yield from sidebar.open_part("Queries", "Walks from Here")
    yield from editors.fill("Queries", "wayfarer.queries.n_walks", "5")
    settings().queries.duration = 4.0
    yield from sidebar.press_button("Queries", "wayfarer.pick_walks_from")
    yield from hand.until(lambda: "WAYFARER_OT_pick_walks_from" in hand.running(), "the eyedropper")
    yield from hand.press("ESC")
    yield from hand.until(lambda: not hand.running(), "the eyedropper to end")
    note("after_escape", len(walks.walk_fan(output)))
    yield from sidebar.press_button("Queries", "wayfarer.pick_walks_from")
    yield from hand.until(lambda: "WAYFARER_OT_pick_walks_from" in hand.running(), "the eyedropper")
    yield from hand.click(*hand.pixel_of(PLACE))
    yield from hand.until(lambda: walks.walk_fan(output), "the walks")
    yield from hand.work_is_done()
    starts = [curve.data.splines[0].points[0].co[:2] for curve in walks.walk_fan(output)]
    note("distances", [float(np.hypot(x - PLACE[0], y - PLACE[1])) for x, y in starts])
    keep_picture("26_walks_from_here")
    yield from sidebar.press_button("Queries", "wayfarer.clear_walks_from", sidebar.BESIDE_LIST)
    yield from hand.until(lambda: not walks.walk_fan(output), "the walks to be gone")
    yield from sidebar.close_part("Queries", "Walks from Here")


def charts(note) -> hand.Turns:
    """Each chart opens in the browser as soon as it is asked for; what opens it writes down the page."""
    settings().evaluation.n_pairs = 10
    opened = log_browser()
    yield from sidebar.open_part("Tuning", "Price of Pruning")
    yield from sidebar.press_button("Tuning", "wayfarer.sweep_pruning")
    yield from hand.until(lambda: "PRUNING_CURVE" in findings(), "the sweep over k")
    yield from _chart(note, opened, "sweep", "27_chart_of_k")
    yield from sidebar.close_part("Tuning", "Price of Pruning")
    yield from sidebar.open_part("Evaluation", "What Matters")
    yield from sidebar.press_button("Evaluation", "wayfarer.ablate")
    yield from hand.until(lambda: "ABLATION" in findings(), "the ablation")
    yield from hand.work_is_done()
    yield from sidebar.press_button("Evaluation", "wayfarer.show_chart")
    yield from _chart(note, opened, "ablation", "28_chart_of_what_matters")
    yield from sidebar.close_part("Evaluation", "What Matters")
    yield from sidebar.press_button("Evaluation", "wayfarer.measure")
    kept = part("results.findings")
    yield from hand.until(lambda: not kept.finding_is_stale(bpy.context.scene, kept.METRICS), "the metrics")
    yield from hand.work_is_done()
    yield from sidebar.open_part("Evaluation", "Clips in Numbers")
    yield from sidebar.press_button("Evaluation", "wayfarer.show_chart")
    yield from _chart(note, opened, "metrics", "29_chart_of_clips")
    yield from sidebar.close_part("Evaluation", "Clips in Numbers")
    yield from hand.redrawn()


def _chart(note, opened: Path, name: str, kept: str) -> hand.Turns:
    """The page that is opened next, and its drawing."""
    yield from hand.until(opened.exists, f"the page of the {name}")
    yield from hand.work_is_done()
    page = Path(opened.read_text("utf-8").strip().removeprefix("file://"))
    opened.unlink()
    text = page.read_text("utf-8")
    width, height = re.findall(r'<svg[^>]* width="(\d+)" height="(\d+)"', text)[0]
    note(name, [page.name, int(width), int(height), len(set(re.findall("#[0-9a-f]{6}", text)))])
    keep_picture(kept)
