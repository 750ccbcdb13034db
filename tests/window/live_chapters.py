"""Live evaluation by the clock: what passes between a change and the picture that shows what comes of it."""

import statistics
import time
from contextlib import contextmanager

import bpy
import hand
from scene_facts import badges, colors, keep_picture, numbers, part, settings

PILLAR = "Pillar A"
PAPER_LINKS = 147
_TIMES = 3
_UNCOUNTED = 2
"""At first nobody knows how long it takes."""

_STEP = 0.3


class _Watch:
    """Notes when the viewport is drawn, and when the floor is first seen to have other colours.

    Timers are called when the window has been drawn, before anything else happens: then a picture is complete.
    """

    def __init__(self):
        self._before = colors()
        self.written = self.first_picture = self.picture = 0.0
        self.redraws = 0
        draw = bpy.types.SpaceView3D.draw_handler_add
        self._handles = [
            draw(self.look, (), "WINDOW", "PRE_VIEW"),
            draw(self._drawing, (), "WINDOW", "POST_PIXEL"),
        ]
        self._began = time.perf_counter()

    def _passed(self) -> float:
        return time.perf_counter() - self._began

    def _drawing(self):
        self.redraws += not self.picture
        if not bpy.app.timers.is_registered(self._drawn):
            bpy.app.timers.register(self._drawn)

    def _drawn(self):
        passed = self._passed()
        self.first_picture = self.first_picture or passed
        if self.written and not self.picture:
            self.picture = passed

    def look(self) -> None:
        if not self.written and colors() != self._before:
            self.written = self._passed()

    def end(self) -> None:
        for handle in self._handles:
            bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")


def time_changes(note) -> hand.Turns:
    """Move a pillar to and fro, each time when all is at rest."""
    settings().live = True
    module = part("live.live")
    live, pillar = module.evaluation(bpy.context.scene), bpy.data.objects[PILLAR]
    start = pillar.location.x
    note("size", numbers())
    for name, area in (("redraw_viewport", hand.region()), ("redraw_area", hand.viewport())):
        times = []
        for _ in range(_TIMES):
            yield from _at_rest(live)
            watch = _Watch()
            area.tag_redraw()
            yield from hand.until(lambda watch=watch: watch.first_picture, "the viewport to be drawn")
            watch.end()
            times.append(watch.first_picture)
        note(name, _median(times))
    yield from _note_times(note, pillar, live)
    note("status", module.status(bpy.context.scene)[0])
    keep_picture("11_live")
    with _all_the_time_in_the_world(module):
        yield from _take(pillar)
        yield from _at_rest(live)
        watch, place = _Watch(), pillar.matrix_world.translation
        yield from hand.move(*hand.pixel_of((place.x + _STEP, place.y, 0.0)))
        yield from hand.until(lambda: watch.look() or watch.picture, "the map in a picture")
        watch.end()
        note("one_picture", watch.picture == watch.first_picture)
        yield from hand.press("LEFTMOUSE")
        yield from hand.until(lambda: not hand.running(), "the pillar to be put down")
        yield from _at_rest(live)
        painted, pillar.location.x = colors(), start
        bpy.context.view_layer.update()
        note("left_to_the_script", colors() == painted)
        yield from hand.until(lambda: colors() != painted, "the map to follow")
    pillar.location.x = start
    yield from _at_rest(live)
    note("stale", badges())
    settings().live = False
    yield from hand.redrawn()


def time_few_links(note) -> hand.Turns:
    """The same with as many links as the paper's motion graph had; then everything as it was."""
    live, pillar, graph = part("live.live").evaluation(bpy.context.scene), bpy.data.objects[PILLAR], settings().graph
    start, before = pillar.location.x, (graph.threshold_mode, graph.max_links)
    yield from _embed_with(("LINKS", PAPER_LINKS), live)
    note("size", numbers())
    yield from _note_times(note, pillar, live)
    pillar.location.x = start
    yield from _embed_with(before, live)
    note("stale", badges())
    settings().live = False
    yield from hand.redrawn()


def drag_without_floor(note) -> hand.Turns:
    """Without a floor, drag a pillar, and switch Live on: the floor is made when that is put down, as a step of undo of
    its own."""
    live, pillar, floors = (
        part("live.live").evaluation(bpy.context.scene),
        bpy.data.objects[PILLAR],
        part("render.floor"),
    )
    bpy.data.batch_remove([floors.find_floor(bpy.context.scene)])
    start, location = pillar.matrix_world.translation.copy(), pillar.location.copy()
    yield from _take(pillar)
    for step in range(5):
        yield from hand.move(*hand.pixel_of((start.x + 0.1 * step, start.y, 0.0)))
    settings().live = True
    held = time.perf_counter()
    yield from hand.until(lambda: time.perf_counter() > held + 1.0, "a second to pass")
    note("while_dragged", floors.find_floor(bpy.context.scene) is not None)
    yield from hand.press("LEFTMOUSE")
    yield from hand.until(lambda: not hand.running(), "the pillar to be put down")
    yield from hand.until(colors, "the floor to be back")
    yield from _at_rest(live)
    note("stale", badges())
    moved = (pillar.matrix_world.translation - start).length
    yield from hand.press_in_viewport("Z", ctrl=True)
    yield from hand.until(lambda: not colors(), "the floor to be undone")
    yield from hand.redrawn()
    pillar = bpy.data.objects[PILLAR]
    note("moved", [moved, (pillar.matrix_world.translation - start).length])
    yield from hand.press_in_viewport("Z", ctrl=True, shift=True)
    yield from hand.until(colors, "the floor to be there again")
    bpy.data.objects[PILLAR].location = location
    yield from _at_rest(live)
    note("stale_at_the_end", badges())
    settings().live = False
    # Deselect it, so that its outline is not in the pictures that follow.
    yield from hand.press_in_viewport("A", alt=True)


def _take(pillar) -> hand.Turns:
    """Select a pillar by the mouse and take it by the key."""
    x, y, z = pillar.matrix_world.translation
    yield from hand.click(*hand.pixel_of((x, y, z)))
    yield from hand.move(*hand.pixel_of((x, y, 0.0)))
    yield from hand.press("G")
    yield from hand.until(lambda: "TRANSFORM_OT_translate" in hand.running(), "the pillar to be taken")


def _embed_with(threshold: tuple[str, int], live) -> hand.Turns:
    """Make the motion graph and the embedding anew, and let the map follow."""
    graph = settings().graph
    settings().live = False
    graph.threshold_mode, graph.max_links = threshold
    for step in (bpy.ops.wayfarer.build_motion_graph, bpy.ops.wayfarer.embed):
        step()
        yield from hand.redrawn()
    settings().live = True
    yield from _at_rest(live)


def _note_times(note, pillar, live) -> hand.Turns:
    """Move the pillar to and fro, from where it is."""
    start, measured = pillar.location.x, []
    for number in range(_UNCOUNTED + _TIMES):
        watch = yield from _change(pillar, start + (0.0 if number % 2 else _STEP), live)
        measured.append((watch.written, watch.picture, live.written, live.drawn, watch.redraws))
    written, picture, said_written, said_drawn, redraws = zip(*measured[_UNCOUNTED:], strict=True)
    note("written", _median(written))
    note("picture", _median(picture))
    note("said", [_median(said_written), _median(said_drawn)])
    note("redraws", redraws)
    note("work", {phase: round(seconds, 4) for phase, seconds in live.seconds.items()})


def _change(pillar, x: float, live):
    """Move the pillar and wait for the picture that shows the map of it."""
    yield from _at_rest(live)
    watch = _Watch()
    pillar.location.x = x
    yield from hand.until(lambda: watch.look() or watch.picture, "the map in a picture")
    watch.end()
    return watch


@contextmanager
def _all_the_time_in_the_world(module):
    """There is always time for the map to come first."""
    before = module.FOLLOWS, module._BEFORE_DRAWING
    module.FOLLOWS = module._BEFORE_DRAWING = 60.0
    try:
        yield
    finally:
        module.FOLLOWS, module._BEFORE_DRAWING = before


def _median(times) -> float:
    return round(statistics.median(times), 4)


def _at_rest(live) -> hand.Turns:
    """Until nothing is drawn or worked at any more."""
    settle = part("results.staleness")._settle
    yield from hand.until(lambda: live.done and not bpy.app.timers.is_registered(settle), "rest")
    for _ in range(15):
        yield
