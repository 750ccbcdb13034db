"""The map on the floor, and the numbers of a place under the mouse."""

import bpy

from ...core.errors import EvaluationError
from ...core.evaluation.place import PlaceReport, place_report
from ...core.evaluation.why_not import why_not_steps
from ...core.progress import finish
from ..jobs import LongOperator, Slices
from ..render.screen_box import Box, BoxTheme, draw_box, guarded
from ..render.viewport import show_colors
from ..results.shown import paint_floor
from ..results.store import embedding_of, results
from ..session import redraw
from .mixins import LooksAtEmbedding, PicksOnFloor, clicked, ground_under, reports_errors, viewport_under

_SLICE = 0.02
_TICK = 0.02
"""Seconds of work on the reasons, and of everything else between two slices of it."""

_BESIDE = 18.0
"""Pixels from the mouse to the tooltip, at the interface's usual size."""


class WAYFARER_OT_paint_map(LooksAtEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.paint_map"
    bl_label = "Paint Map"
    bl_description = (
        "Colour the floor: the lighter, the more ways to pass, red where the character cannot go; or by the reason "
        "why it cannot"
    )

    def steps(self, context):
        embedding, settings = embedding_of(context.scene), context.scene.wayfarer.map
        key, offset = settings.key, settings.offset
        painted = yield from settings.kind.paint_steps(embedding, settings.to_core())
        return embedding, key, offset, painted

    def apply(self, context, result):
        embedding, key, offset, painted = result
        paint_floor(context.scene, embedding, painted, key, offset, in_operator=True)
        show_colors(context.screen, context.scene)
        self.report({"INFO"}, painted.report)
        self.warn_if_stale(context.scene)


class WAYFARER_OT_pick_place(LooksAtEmbedding, PicksOnFloor, bpy.types.Operator):
    bl_idname = "wayfarer.pick_place"
    bl_label = "Pick Place"
    bl_description = (
        "Tell the numbers of the place under the mouse: ways by heading, the segments that end there, and why the "
        "character cannot go there. A click keeps them in the panel; Esc or a right click ends"
    )
    bl_options = {"REGISTER", "UNDO"}
    picking_cursor = "EYEDROPPER"

    location: bpy.props.FloatVectorProperty(
        name="Location",
        description="The place to ask, for scripts",
        size=2,
        subtype="XYZ",
        unit="LENGTH",
        options={"SKIP_SAVE"},
    )

    @reports_errors
    def execute(self, context):
        scene = context.scene
        embedding = embedding_of(scene)
        report = place_report(embedding, *self.location, reasons=finish(why_not_steps(embedding)))
        if report is None:
            raise EvaluationError("That place is beside the ground; choose one on it")
        self._keep(scene, report)

    def begin(self, context):
        self._embedding = None
        self._work: Slices | None = None
        self._report: PlaceReport | None = None
        self._lines: list[str] = []
        # The pointer is compared, never followed.
        self._mouse, self._area = (0, 0), context.area.as_pointer()
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        self._handle = bpy.types.SpaceView3D.draw_handler_add(guarded(self._draw), (), "WINDOW", "POST_PIXEL")

    def handle(self, context, event):
        embedding = results(context.scene).embedding
        if embedding is None:
            self.stop(context)
            return {"CANCELLED"}
        if event.type == "TIMER":
            self._find_reasons(embedding)
        elif event.type == "MOUSEMOVE":
            self._look(context, event, embedding)
        # A click on the sidebar, or on another editor, is theirs.
        elif clicked(event) and viewport_under(context, event) is not None:
            self._look(context, event, embedding)
            if self._report is not None:
                self._keep(context.scene, self._report)
                redraw()
            return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}

    def _find_reasons(self, embedding) -> None:
        """Work on the reasons for a slice; the other numbers do not wait for them."""
        if self._work is None or embedding is not self._embedding:
            self._embedding, self._work = embedding, Slices(why_not_steps(embedding))
        self._work.advance(_SLICE)

    def _look(self, context, event, embedding) -> None:
        region = viewport_under(context, event)
        self._report, self._lines = None, []
        if region is not None:
            x, y = event.mouse_x - region.x, event.mouse_y - region.y
            place = ground_under(region, context.space_data.region_3d, (x, y), results(context.scene).ground_height)
            if place is not None:
                work = self._work if embedding is self._embedding else None
                reasons = work.result if work is not None and work.done else None
                self._report = place_report(embedding, *place, reasons=reasons)
            self._mouse = x, y
        if self._report is not None:
            self._lines = self._report.lines()
        status = "    ".join(self._lines[:3]) or "Point at the floor"
        context.workspace.status_text_set(f"{status}    Click: Keep    Esc: End")
        context.area.tag_redraw()

    def _keep(self, scene, report: PlaceReport) -> None:
        scene.wayfarer.overlay.place = "\n".join(report.lines(n_segments=12))
        self.report({"INFO"}, ", ".join(report.lines()[:3]))

    def _draw(self) -> None:
        context = bpy.context
        if not self._lines or context.area is None or context.area.as_pointer() != self._area:
            return
        scale = context.preferences.system.ui_scale
        box = tip_box(self._lines, scale)
        x = min(self._mouse[0] + _BESIDE * scale, context.region.width - box.width)
        y = max(self._mouse[1] - _BESIDE * scale - box.height, 0.0)
        draw_box(box, x, y, BoxTheme.of(context.preferences))

    def end(self, context):
        bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
        context.window_manager.event_timer_remove(self._timer)
        redraw()


def tip_box(lines: list[str], scale: float) -> Box:
    """The tooltip, laid out: what place it is first, the rest fainter."""
    box = Box(scale)
    for number, line in enumerate(lines):
        box.text(line.strip(), indent=10.0 * scale if line.startswith(" ") else 0.0, size=0.95, faint=number > 1)
    return box.done()


CLASSES = (WAYFARER_OT_paint_map, WAYFARER_OT_pick_place)
