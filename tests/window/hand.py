"""The hand of an artist: mouse and keys, by events that go through Blender's own window.

Everything here is a generator: each ``yield`` gives Blender a turn, some hundredths of a second in which it handles the
event that was sent and draws. Nothing waits for a length of time; :func:`until` waits for what is to come.
"""

import time
from collections.abc import Callable, Generator

import bpy

Turns = Generator[None, None, None]

EXTENSION = "bl_ext.user_default.wayfarer"

_mouse = (600, 500)
_drawn = {"WINDOW": 0, "UI": 0}


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


def scale() -> float:
    """The user's size of the interface, as a factor."""
    return bpy.context.preferences.system.ui_scale


# ------------------------------------------------------------------------------------------------ waiting


_PATIENCE = 300.0
"""Seconds after which nothing comes any more, also on a busy machine."""


def until(condition: Callable[[], object], what: str) -> Turns:
    """Until the condition holds; Waited if it does not for a very long time."""
    end = time.monotonic() + _PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise Waited(f"waited {_PATIENCE:.0f} s in vain for {what}")
        yield


def count_redraws() -> None:
    """Begin to count how often the viewport and its sidebar are drawn, for :func:`redrawn`."""

    def count(kind: str):
        _drawn[kind] += 1

    for kind in _drawn:
        bpy.types.SpaceView3D.draw_handler_add(count, (kind,), kind, "POST_PIXEL")


def n_drawn(kind: str = "WINDOW") -> int:
    """How often the viewport, or its sidebar, has been drawn since :func:`count_redraws`."""
    return _drawn[kind]


def redrawn(times: int = 2, kind: str = "WINDOW") -> Turns:
    """Until the viewport has been drawn anew, twice: what the first drawing asks for comes with the second.

    With "UI" only its sidebar, which takes a fraction of the time.
    """
    for _ in range(times):
        (viewport() if kind == "WINDOW" else region(kind)).tag_redraw()
        before = _drawn[kind]
        yield from until(lambda before=before: _drawn[kind] > before, "the viewport to be drawn")
        # The picture is shown only after all regions are drawn.
        yield


def running() -> list[str]:
    """Identifiers of the modal operators that run in the window."""
    return [operator.bl_idname for operator in window().modal_operators]


def work_is_done() -> Turns:
    """Until no operator of ours runs, and what it changed has been seen."""
    yield from until(lambda: not any("WAYFARER" in name for name in running()), f"the end of {running()}")
    yield from redrawn()


# ------------------------------------------------------------------------------------------------- events


def _send(kind: str, value: str, **modifiers: bool | str) -> Turns:
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


def mouse() -> tuple[int, int]:
    """Where the mouse is, as a pixel of the window."""
    return _mouse


def drag(across: int, up: int) -> Turns:
    """Press the mouse where it is, move it by so many pixels, and let it go."""
    x, y = _mouse
    yield from _send("LEFTMOUSE", "PRESS")
    for share in range(1, 11):
        yield from move(x + 0.1 * share * across, y + 0.1 * share * up)
    yield from _send("LEFTMOUSE", "RELEASE")


def press_wheel(kind: str, **modifiers: bool) -> Turns:
    """Turn the wheel by one notch where the mouse is."""
    yield from _send(kind, "PRESS", **modifiers)


def type_text(text: str) -> Turns:
    """Type small letters, digits and what stands in numbers."""
    for letter in text:
        kind = _KEYS.get(letter, letter.upper())
        yield from _send(kind, "PRESS", unicode=letter)
        yield from _send(kind, "RELEASE")


_DIGITS = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")
_KEYS = {**{str(digit): kind for digit, kind in enumerate(_DIGITS)}, ".": "PERIOD", "-": "MINUS", " ": "SPACE"}


def rest() -> Turns:
    """Move the mouse to an empty corner of the viewport, where nothing lights up and no tooltip opens."""
    view = region()
    yield from move(view.x + view.width * 0.2, view.y + view.height * 0.1)
    if region("UI").width > 1:
        yield from redrawn(kind="UI")


def press_in_viewport(kind: str, **modifiers: bool) -> Turns:
    """Press a key with the mouse over an empty corner of the viewport."""
    view = region()
    yield from move(view.x + view.width * 0.2, view.y + view.height * 0.1)
    yield from press(kind, **modifiers)
