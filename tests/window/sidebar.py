"""The sidebar with our panels: opened, closed and pressed by the mouse, wherever Blender has laid things out."""

import importlib
import time
from collections.abc import Generator

import bpy
import hand
import numpy as np
import picture
from hand import Turns

CATEGORY = "Wayfarer"
_GAP = 4
"""Pixels between two closed panels, at every size of the interface."""
_HEADER, _PITCH = 12, 24
"""Pixels from the top of the sidebar, after a gap, to the middle of the first header, and from that to the next; these
and all other pixels at the interface's usual size."""
_STEP = 14
"""Pixels between two places where a button is looked for: less than the height of one."""
_COLUMNS = 0.65, 0.3
"""Parts of the sidebar's width where buttons are looked for, one after the other."""
_TABS = 10
"""Pixels from the right edge of the sidebar to the middle of the tabs."""
_STILL = 0.2
"""Seconds without a change after which panels have come to rest."""
TICKS, BESIDE_LABEL, BESIDE_LIST = 0.113, 0.42, 0.83
"""Where the check boxes of a list are, those behind a label, and the buttons on the right of a list."""


def open_sidebar() -> Turns:
    """Open the sidebar with its key and turn to our tab."""
    if not hand.viewport().spaces.active.show_region_ui:
        yield from hand.press_in_viewport("N")
    yield from hand.until(lambda: hand.region("UI").width > 1, "the sidebar")
    yield from hand.redrawn()
    hand.region("UI").active_panel_category = CATEGORY
    yield from hand.redrawn()


def scroll(steps: int) -> Turns:
    """Turn the wheel over the sidebar: downwards, or upwards for negative steps."""
    side = hand.region("UI")
    # At the left edge, where there is no list that would turn instead.
    yield from hand.move(side.x + 4, side.y + 0.5 * side.height)
    for _ in range(abs(steps)):
        yield from hand.press_wheel("WHEELDOWNMOUSE" if steps > 0 else "WHEELUPMOUSE")
    yield from hand.redrawn()


def close_panels() -> Turns:
    """Close all panels; the tab must show its first one."""
    # With Ctrl, a click on a header closes all other panels.
    yield from _click_header(0, ctrl=True)
    yield from _click_header(0, 0.45)
    _open.clear()
    # What a closed header's arrow looks like, seen at a place that is known.
    global _arrow
    strip, middle = _arrow_strip(), hand.region("UI").height - _GAP - _HEADER
    arrow, x = picture.bright_part(strip[middle - 9 : middle + 9, :32])
    # Those of subpanels are farther to the right.
    _arrow = arrow, x + arrow.shape[1]
    yield


_open: list[str] = []


def panels() -> list[str]:
    """Labels of our panels, without subpanels, from top to bottom."""
    panels = importlib.import_module(f"{hand.EXTENSION}.addon.ui.panels").PANELS
    return [panel.bl_label for panel in panels if not getattr(panel, "bl_parent_id", "")]


def _click_header(number: int, across: float = 0.3, **modifiers: bool) -> Turns:
    side, before = hand.region("UI"), _arrow_strip()
    yield from hand.click(side.x + across * side.width, header(panels()[number]), **modifiers)
    # Panels slide to their places, and are pressed where they are drawn on the way.
    since, seen = time.monotonic(), None
    while time.monotonic() - since < _STILL:
        yield from hand.redrawn(1, "UI")
        strip = _arrow_strip()
        if seen is None or not np.array_equal(strip, seen):
            since, seen = time.monotonic(), strip
    if np.array_equal(seen, before):
        raise hand.Waited(f"the header of {panels()[number]} was clicked, and nothing opened or closed")


def _down(number: float) -> float:
    """Pixels from the top of the sidebar to the middle of the header with this number, counted from 0."""
    return _GAP + hand.scale() * _HEADER + number * (_GAP + hand.scale() * _PITCH)


def header(panel: str) -> float:
    """The y of a panel's header in the window, of one that is open or above that."""
    side = hand.region("UI")
    return side.y + side.height - _down(panels().index(panel))


def open_panel(label: str) -> Turns:
    """Open one panel; the one that was open before is closed."""
    labels = panels()
    if [label] == _open:
        return
    if _open:
        # Elsewhere than where it was opened: at one place the two would be a double click.
        yield from _click_header(labels.index(_open.pop()), 0.45)
    yield from _click_header(labels.index(label))
    _open.append(label)


def close_panel(label: str) -> Turns:
    """Close a panel that :func:`open_panel` opened."""
    if [label] == _open:
        _open.clear()
        yield from _click_header(panels().index(label), 0.45)


def turn_tabs(steps: int) -> Turns:
    """Turn the wheel over the tabs, with Ctrl: to those further down, or further up for negative steps."""
    side = hand.region("UI")
    for _ in range(abs(steps)):
        # A tab that has been turned to knows of the mouse when it moves.
        yield from hand.move(side.x + side.width - _TABS - hand.mouse()[0] % 2, side.y + 0.5 * side.height)
        before = side.active_panel_category
        yield from hand.press_wheel("WHEELDOWNMOUSE" if steps > 0 else "WHEELUPMOUSE", ctrl=True)
        yield from hand.until(lambda before=before: side.active_panel_category != before, "another tab")
        yield from hand.redrawn(1, "UI")


def open_part(panel: str, part: str) -> Turns:
    """Open a panel and one of its subpanels, which is known by the arrow at its header."""
    yield from open_panel(panel)
    if (panel, part) in _open_parts:
        return
    x, y = yield from _arrow_of(panel, part)
    side = hand.region("UI")
    # On the arrow: beside it there may be a check box.
    yield from hand.click(side.x + x, side.y + y)
    yield from hand.redrawn(kind="UI")
    # What the arrow of an open subpanel looks like, for closing it again.
    global _open_arrow
    _open_arrow, _ = picture.bright_part(_arrow_strip()[y - 9 : y + 9, x - 9 : x + 9])
    _open_parts.append((panel, part))


def close_part(panel: str, part: str) -> Turns:
    """Close a subpanel that :func:`open_part` opened, so that there is room for others."""
    if (panel, part) not in _open_parts:
        return
    yield from open_panel(panel)
    x, y = yield from _arrow_of(panel, part)
    side = hand.region("UI")
    yield from hand.click(side.x + x, side.y + y)
    yield from hand.redrawn(kind="UI")
    _open_parts.remove((panel, part))


_open_parts: list[tuple[str, str]] = []
_arrow: tuple
_open_arrow: object


def _arrow_of(panel: str, part: str) -> Generator[None, None, tuple[int, int]]:
    """Where the arrow of a subpanel is, in pixels of the sidebar: of those alike, the first is that of the first."""
    wanted = (panel, part) in _open_parts
    alike = [label for label, is_open in _parts(panel) if is_open == wanted]
    yield from hand.redrawn(kind="UI")
    glyph = _open_arrow if wanted else _arrow[0]
    arrows = [(x, y) for x, y in picture.find_all(glyph, _arrow_strip()) if x > _arrow[1]]
    # From the top downwards, as the panels are listed.
    arrows.sort(key=lambda place: -place[1])
    number = alike.index(part)
    if len(arrows) <= number:
        raise hand.Waited(f"{panel} shows {len(arrows)} subpanels like {part}, which is number {number + 1}")
    return arrows[number]


def _parts(panel: str) -> list[tuple[str, bool]]:
    """Labels of the subpanels that a panel shows, from top to bottom, each with whether it is open."""
    kinds = importlib.import_module(f"{hand.EXTENSION}.addon.ui.panels").PANELS
    parent = next(kind for kind in kinds if kind.bl_label == panel and not getattr(kind, "bl_parent_id", ""))
    with bpy.context.temp_override(**hand.in_viewport()):
        return [
            (
                kind.bl_label,
                (panel, kind.bl_label) in _open_parts or "DEFAULT_CLOSED" not in getattr(kind, "bl_options", ()),
            )
            for kind in kinds
            if getattr(kind, "bl_parent_id", "") == parent.__name__
            and (not hasattr(kind, "poll") or kind.poll(bpy.context))
        ]


def _arrow_strip():
    """Pixels of the sidebar's left edge, where the arrows of the headers are."""
    side = hand.region("UI")
    return picture.pixels()[side.y : side.y + side.height, side.x : side.x + 60]


def hovered() -> str:
    """What the button under the mouse does: ``wayfarer.embed`` for an operator, the path of a property, or nothing."""
    manager = bpy.context.window_manager
    with bpy.context.temp_override(window=hand.window(), area=hand.viewport(), region=hand.region("UI")):
        shown = getattr(bpy.context, "property", None)
        if shown is not None:
            return shown[1]
        manager.clipboard = ""
        if bpy.ops.ui.copy_python_command_button.poll():
            bpy.ops.ui.copy_python_command_button()
    return manager.clipboard.removeprefix("bpy.ops.").partition("(")[0]


def find_button(name: str, *columns: float) -> Generator[None, None, tuple[int, int]]:
    """The window pixel of a button in the open panel, found by moving the mouse over the sidebar.

    ``columns`` are the parts of its width where to look. Buttons that open menus do not say what they do.
    """
    side = hand.region("UI")
    top, low = side.height, 4
    if _open and not _scrolled:
        top -= int(_down(panels().index(_open[0]) + 0.5))
    step = int(hand.scale() * _STEP)
    looked = [(side.x + x * side.width, side.y + y) for x in columns or _COLUMNS for y in range(top, low, -step)]
    seen: list[str] = []
    for number, place in enumerate(looked):
        yield from hand.move(*place)
        found = hovered()
        if found and found not in seen:
            # Those on the way, as well, for when they are looked for.
            seen.append(found)
            _places[found] = hand.mouse()
        if found != name:
            continue
        # What is under the mouse may be known a moment later than the mouse moves.
        for known in reversed(looked[max(number - 2, 0) : number + 1]):
            yield from hand.move(*known)
            yield from hand.redrawn(1, "UI")
            if hovered() == name:
                return hand.mouse()
    raise hand.Waited(f"there is no button {name} in the panel {_open}, only {seen}")


def point_at(panel: str, name: str, *columns: float) -> Generator[None, None, tuple[int, int]]:
    """Open a panel and move the mouse to one of its buttons, where it was the last time or wherever it is now."""
    yield from open_panel(panel)
    if name in _places:
        yield from hand.move(*_places[name])
        yield from hand.redrawn(1, "UI")
    if name not in _places or hovered() != name:
        _places[name] = yield from find_button(name, *columns)
    return _places[name]


def press_button(panel: str, name: str, *columns: float) -> Turns:
    """Click on a button of a panel, if need be after scrolling to it."""
    global _scrolled
    try:
        place = yield from point_at(panel, name, *columns)
    except hand.Waited:
        yield from scroll(20)
        _scrolled = True
        place = yield from point_at(panel, name, *columns)
    yield from hand.click(*place)
    if _scrolled:
        yield from scroll(-30)
        _scrolled = False


_scrolled = False
_places: dict[str, tuple[int, int]] = {}
