"""What opens beside the viewport and over it: fields to type into, menus, the file browser."""

import time
from collections.abc import Callable, Generator

import bpy
import hand
import picture
import sidebar
from hand import Turns


def fill(panel: str, path: str, text: str, *columns: float) -> Turns:
    """Type into a field of a panel, in place of what is in it."""
    yield from sidebar.point_at(panel, path, *columns)
    # Begins to edit what is under the mouse, all of it selected.
    yield from hand.press("RET")
    yield from hand.type_text(text)
    yield from hand.press("RET")
    yield from hand.rest()


def search(panel: str, path: str, text: str) -> Turns:
    """Type into a field of a panel that proposes names, and take the first of them."""
    yield from sidebar.point_at(panel, path)
    yield from hand.press("LEFTMOUSE")
    yield from hand.redrawn()
    yield from hand.type_text(text)
    yield from hand.redrawn()
    yield from hand.press("DOWN_ARROW")
    yield from hand.press("RET")
    yield from hand.rest()


def turn_to(panel: str, path: str, value: Callable[[], str], wanted: str) -> Turns:
    """Turn the wheel over a menu of a panel, with Ctrl, until its value is the one that is wanted."""
    yield from sidebar.point_at(panel, path)
    x, y = hand.mouse()
    for kind in ("WHEELDOWNMOUSE", "WHEELUPMOUSE"):
        unturned = 0
        # At an end the value stays as it is; so it does, now and then, where the sidebar is drawn at that moment.
        while value() != wanted and unturned < 3:
            before = value()
            # A button that has been drawn anew knows of the mouse when it moves.
            yield from hand.move(x + 2 * (unturned % 2), y)
            yield from hand.redrawn(1, "UI")
            yield from hand.press_wheel(kind, ctrl=True)
            # A second, and as many turns as that has where nothing else is at work.
            end, turns = time.monotonic() + 1.0, 30
            while value() == before and (time.monotonic() < end or turns > 0):
                turns -= 1
                yield
            unturned = unturned + 1 if value() == before else 0
    if value() != wanted:
        raise hand.Waited(f"{path} has no {wanted}")
    yield from hand.rest()


def open_popup(x: float, y: float) -> Generator[None, None, tuple[int, int, int, int]]:
    """Click on what opens a menu or a popover; x, y, width and height of it in the window."""
    # So that what the mouse lights up is not mistaken for it.
    yield from hand.move(x, y)
    yield from hand.redrawn()
    before = picture.pixels()
    yield from hand.press("LEFTMOUSE")
    found = None
    for _ in range(100):
        yield
        last, found = found, picture.changed_box(before, picture.pixels(), 24)
        # Two pictures alike: it is all there.
        if found is not None and found[2] > 60 and found == last:
            return found
    raise hand.Waited("nothing opened")


# ------------------------------------------------------------------------------------------ file browser


def file_browser() -> bpy.types.Area | None:
    return next((area for area in hand.window().screen.areas if area.type == "FILE_BROWSER"), None)


def choose_folder(folder: str, look: Callable[[], None]) -> Turns:
    """Turn the open file browser to a folder and accept; ``look`` is called with everything to be seen."""
    yield from hand.until(lambda: file_browser() and file_browser().spaces.active.params, "the file browser")
    area = file_browser()
    area.spaces.active.params.directory = folder.encode()
    yield from hand.until(lambda: area.spaces.active.params.directory.rstrip(b"/") == folder.encode(), folder)
    # The picture of the whole window, once it stays as it is.
    before = None
    for _ in range(100):
        yield
        now = picture.pixels()
        if before is not None and (now == before).all():
            break
        before = now
    look()
    main = next(region for region in area.regions if region.type == "WINDOW")
    yield from hand.move(main.x + 0.5 * main.width, main.y + 0.5 * main.height)
    yield from hand.press("RET")
    yield from hand.until(lambda: file_browser() is None, "the file browser to close")
    yield from hand.redrawn()
