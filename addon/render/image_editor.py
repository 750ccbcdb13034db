"""Showing images where there is room for them."""

import bpy


def show_in_editor(context, image) -> bool:
    """Show an image in the first Image Editor of any window, or else in a window of its own; False if neither can be:
    without a window to open it from."""
    area = _open_editor(context)
    if area is not None:
        _show(area, image)
        return True
    if bpy.app.background or context.window is None:
        return False
    name = image.name
    # Later: an operator that opens a window before it has come to its end never leaves Blender's list of running ones.
    bpy.app.timers.register(lambda: _show_in_new_window(name), first_interval=0.0)
    return True


def _show(area, image) -> None:
    area.spaces.active.image = image
    area.tag_redraw()


def _open_editor(context):
    """The first Image Editor of any window."""
    areas = (area for window in context.window_manager.windows for area in window.screen.areas)
    return next((area for area in areas if area.type == "IMAGE_EDITOR"), None)


def _show_in_new_window(name: str) -> None:
    image, windows = bpy.data.images.get(name), bpy.context.window_manager.windows
    if image is None or not windows:
        return
    before = {window.as_pointer() for window in windows}
    with bpy.context.temp_override(window=windows[0]):
        bpy.ops.wm.window_new()
    opened = next((window for window in windows if window.as_pointer() not in before), None)
    if opened is not None:
        area = opened.screen.areas[0]
        area.type = "IMAGE_EDITOR"
        _show(area, image)
