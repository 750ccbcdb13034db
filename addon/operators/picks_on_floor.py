"""What operators that wait for a click on the floor have in common."""

import bpy
from bpy_extras import view3d_utils


class PicksOnFloor:
    """Mixin: a modal operator in a 3D viewport, until Esc or a right click; ``execute`` is what it does without one."""

    picking_cursor = "CROSSHAIR"

    def invoke(self, context, event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Start this in a 3D viewport")
            return {"CANCELLED"}
        self._picking = True
        self.begin(context)
        context.window.cursor_modal_set(self.picking_cursor)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        try:
            # Another editor may have taken the viewport's place.
            lost = context.area is None or context.area.type != "VIEW_3D"
            if lost or (event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS"):
                self.stop(context)
                return {"CANCELLED"}
            return self.handle(context, event)
        except BaseException:
            # Not handled here, but cursor, timers and drawing must not outlive the operator.
            self.stop(context)
            raise

    def cancel(self, context):
        """Called by Blender when it ends the operator itself, for example on opening another file."""
        self.stop(context)

    def begin(self, context) -> None:
        """Picking begins."""

    def handle(self, context, event) -> set[str]:
        """Something has happened, other than the end."""
        raise NotImplementedError

    def end(self, context) -> None:
        """Picking has ended."""

    def stop(self, context) -> None:
        if not self._picking:
            return
        self._picking = False
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        self.end(context)


def clicked(event) -> bool:
    return event.type == "LEFTMOUSE" and event.value == "PRESS"


def ground_under(region, view, mouse, height: float) -> tuple[float, float] | None:
    """World x, y (m) of the ground, at ``height`` (m), under the mouse (pixels in the region); None in the sky."""
    origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
    if abs(direction.z) < 1e-9:
        return None
    distance = (height - origin.z) / direction.z
    if distance < 0 and view.is_perspective:
        return None
    place = origin + distance * direction
    return place.x, place.y


def viewport_under(context, event):
    """The viewport's main region under the mouse; None over its sidebar and toolbars, and elsewhere."""
    for kind in ("UI", "TOOLS", "HEADER", "TOOL_HEADER", "WINDOW"):
        for region in context.area.regions:
            if region.type == kind and region.width > 1:
                x, y = event.mouse_x - region.x, event.mouse_y - region.y
                if 0 <= x < region.width and 0 <= y < region.height:
                    return region if kind == "WINDOW" else None
    return None
