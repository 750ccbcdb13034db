"""Showing images where there is room for them."""


def show_in_editor(context, image) -> bool:
    """Show an image in the first Image Editor of any window; False if none is open."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                area.tag_redraw()
                return True
    return False
