"""The hand of an artist: mouse, keys and the sidebar, by events that go through Blender's own window.

Everything here is a generator: each ``yield`` gives Blender a turn, a few hundredths of a second in which it handles
the event that was sent and draws. Nothing waits for a length of time; :func:`until` waits for what is to come.
"""

import importlib
import time
from collections.abc import Callable, Generator

import bpy
import picture

Turns = Generator[None, None, None]

EXTENSION = "bl_ext.user_default.wayfarer"
CATEGORY = "Wayfarer"
_HEADER, _PITCH = 16, 28
"""Pixels from the top of the sidebar to the middle of the first header, and from one closed panel to the next."""
_STEP = 9
"""Pixels between two places where a button is looked for: less than half of one."""

_mouse = (600, 500)
_drawn = 0


class Waited(Exception):
    """What was waited for has not come."""


# ------------------------------------------------------------------------------------------------ places


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def viewport() -> bpy.types.Area:
    return next(area for area in window().screen.areas if area.type == "VIEW_3D")


def region(kind: str = "WINDOW") -> bpy.types.Region:
    return next(region for region in viewport().regions if region.type == kind)


def in_viewport() -> dict:
    """Overrides of the context, as if the mouse were in the viewport."""
    return {"window": window(), "area": viewport(), "region": region()}


def pixel_of(place) -> tuple[int, int]:
    """Window pixel of a place in the world (m)."""
    from bpy_extras.view3d_utils import location_3d_to_region_2d
    from mathutils import Vector

    view = region()
    found = location_3d_to_region_2d(view, viewport().spaces.active.region_3d, Vector(place))
    return int(view.x + found.x), int(view.y + found.y)


# ------------------------------------------------------------------------------------------------ waiting


def until(condition: Callable[[], object], what: str, seconds: float = 60.0) -> Turns:
    """Until the condition holds; Waited if it does not within the time."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise Waited(f"waited {seconds:.0f} s in vain for {what}")
        yield


def count_redraws() -> None:
    """Begin to count how often the viewport is drawn, for :func:`redrawn`."""

    def count():
        global _drawn
        _drawn += 1

    bpy.types.SpaceView3D.draw_handler_add(count, (), "WINDOW", "POST_PIXEL")


def redrawn(times: int = 2) -> Turns:
    """Until the viewport has been drawn anew, twice: what the first drawing asks for comes with the second."""
    for _ in range(times):
        viewport().tag_redraw()
        before = _drawn
        yield from until(lambda before=before: _drawn > before, "the viewport to be drawn")
        # The picture is shown only after all regions are drawn.
        yield


def running() -> list[str]:
    """Identifiers of the modal operators that run in the window."""
    return [operator.bl_idname for operator in window().modal_operators]


def work_is_done() -> Turns:
    """Until no operator of ours runs, and what it changed has been seen."""
    yield from until(lambda: not any("WAYFARER" in name for name in running()), f"the end of {running()}", 120)
    yield from redrawn()


# ------------------------------------------------------------------------------------------------- events


def _send(kind: str, value: str, **modifiers: bool) -> Turns:
    window().event_simulate(type=kind, value=value, x=_mouse[0], y=_mouse[1], **modifiers)
    yield


def move(x: float, y: float) -> Turns:
    """Move the mouse to a pixel of the window."""
    global _mouse
    _mouse = int(x), int(y)
    yield from _send("MOUSEMOVE", "NOTHING")


def press(kind: str, **modifiers: bool) -> Turns:
    """Press a key or button of the mouse where the mouse is, and let it go."""
    yield from _send(kind, "PRESS", **modifiers)
    yield from _send(kind, "RELEASE", **modifiers)


def click(x: float, y: float, **modifiers: bool) -> Turns:
    yield from move(x, y)
    yield from press("LEFTMOUSE", **modifiers)


def press_in_viewport(kind: str, **modifiers: bool) -> Turns:
    """Press a key with the mouse over an empty corner of the viewport."""
    view = region()
    yield from move(view.x + view.width * 0.2, view.y + view.height * 0.1)
    yield from press(kind, **modifiers)


# ------------------------------------------------------------------------------------------------ sidebar


def open_sidebar() -> Turns:
    """Open the sidebar with its key and turn to our tab."""
    if not viewport().spaces.active.show_region_ui:
        yield from press_in_viewport("N")
    yield from until(lambda: region("UI").width > 1, "the sidebar")
    yield from redrawn()
    region("UI").active_panel_category = CATEGORY
    yield from redrawn()


def scroll(steps: int) -> Turns:
    """Turn the wheel over the sidebar: downwards, or upwards for negative steps."""
    side = region("UI")
    yield from move(side.x + 0.3 * side.width, side.y + 0.5 * side.height)
    for _ in range(abs(steps)):
        yield from _send("WHEELDOWNMOUSE" if steps > 0 else "WHEELUPMOUSE", "PRESS")
    yield from redrawn()


def close_panels() -> Turns:
    """Close all panels; the tab must show its first one."""
    # With Ctrl, a click on a header closes all other panels.
    yield from _click_header(0, ctrl=True)
    yield from _click_header(0)
    _open.clear()
    # What a closed header's arrow looks like, seen at a place that is known.
    global _arrow
    strip, middle = _arrow_strip(), region("UI").height - _HEADER
    arrow, x = picture.bright_part(strip[middle - 9 : middle + 9, :32])
    # Those of subpanels are farther to the right.
    _arrow = arrow, x + arrow.shape[1]
    yield


_open: list[str] = []


def panels() -> list[str]:
    """Labels of our panels, without subpanels, from top to bottom."""
    panels = importlib.import_module(f"{EXTENSION}.addon.ui.panels").PANELS
    return [panel.bl_label for panel in panels if not getattr(panel, "bl_parent_id", "")]


def _click_header(number: int, **modifiers: bool) -> Turns:
    side = region("UI")
    yield from click(side.x + 0.3 * side.width, side.y + side.height - _HEADER - number * _PITCH, **modifiers)
    yield from redrawn(1)


def open_panel(label: str) -> Turns:
    """Open one panel; the one that was open before is closed."""
    labels = panels()
    if [label] == _open:
        return
    if _open:
        yield from _click_header(labels.index(_open.pop()))
    yield from _click_header(labels.index(label))
    _open.append(label)


def open_part(panel: str, part: str) -> Turns:
    """Open a panel and one of its subpanels, which is known by the arrow at its header."""
    yield from open_panel(panel)
    if (panel, part) in _open_parts:
        return
    parts = [label for label in _closed_parts(panel) if (panel, label) not in _open_parts]
    yield from redrawn()
    side = region("UI")
    arrows = [y for x, y in picture.find_all(_arrow[0], _arrow_strip()) if x > _arrow[1]]
    if len(arrows) < len(parts):
        raise Waited(f"{panel} shows {len(arrows)} closed subpanels instead of {len(parts)}")
    # From the top downwards, as the panels are listed.
    y = sorted(arrows, reverse=True)[parts.index(part)]
    yield from click(side.x + 0.5 * side.width, side.y + y)
    yield from redrawn()
    _open_parts.add((panel, part))


_open_parts: set[tuple[str, str]] = set()
_arrow: tuple


def _closed_parts(panel: str) -> list[str]:
    """Labels of the subpanels that a panel shows closed at first, from top to bottom."""
    kinds = importlib.import_module(f"{EXTENSION}.addon.ui.panels").PANELS
    parent = next(kind for kind in kinds if kind.bl_label == panel and not getattr(kind, "bl_parent_id", ""))
    with bpy.context.temp_override(**in_viewport()):
        return [
            kind.bl_label
            for kind in kinds
            if getattr(kind, "bl_parent_id", "") == parent.__name__
            and "DEFAULT_CLOSED" in getattr(kind, "bl_options", ())
            and (not hasattr(kind, "poll") or kind.poll(bpy.context))
        ]


def _arrow_strip():
    """Pixels of the sidebar's left edge, where the arrows of the headers are."""
    side = region("UI")
    return picture.pixels()[side.y : side.y + side.height, side.x : side.x + 60]


def hovered() -> str:
    """What the button under the mouse does: ``wayfarer.embed`` for an operator, the path of a property, or nothing."""
    manager = bpy.context.window_manager
    with bpy.context.temp_override(window=window(), area=viewport(), region=region("UI")):
        shown = getattr(bpy.context, "property", None)
        if shown is not None:
            return shown[1]
        manager.clipboard = ""
        if bpy.ops.ui.copy_python_command_button.poll():
            bpy.ops.ui.copy_python_command_button()
    return manager.clipboard.removeprefix("bpy.ops.").partition("(")[0]


def find_button(name: str) -> Generator[None, None, tuple[int, int]]:
    """The window pixel of a button in the open panel, found by moving the mouse over the sidebar.

    Buttons that open menus do not say what they do.
    """
    side = region("UI")
    top = side.height - _HEADER - int((panels().index(_open[0]) + 0.5) * _PITCH) if _open else side.height
    looked = [(side.x + across * side.width, side.y + y) for y in range(top, 4, -_STEP) for across in (0.3, 0.65)]
    for number, place in enumerate(looked):
        yield from move(*place)
        if hovered() != name:
            continue
        # What is under the mouse may be known a moment later than the mouse moves.
        for known in reversed(looked[max(number - 2, 0) : number + 1]):
            yield from move(*known)
            yield from redrawn(1)
            if hovered() == name:
                return _mouse
    raise Waited(f"there is no button {name} in the panel {_open}")


def press_button(panel: str, name: str) -> Turns:
    """Open a panel and click on one of its buttons, where it was the last time or wherever it is now."""
    yield from open_panel(panel)
    if name in _places:
        yield from move(*_places[name])
        yield from redrawn(1)
    if name not in _places or hovered() != name:
        _places[name] = yield from find_button(name)
    yield from click(*_places[name])


_places: dict[str, tuple[int, int]] = {}
