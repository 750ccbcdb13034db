"""In which viewports the environment is in sight: where its panel is open in the sidebar, everywhere, or nowhere.

Blender does not tell whether a panel is open, but it always draws an area in the same order: first it lays the sidebar
out, for which it calls ``draw`` of the panels that are open in the tab that is turned to, or pinned, and of no others;
then it draws the sidebar, then the viewport. So whoever draws the viewport knows what is open beside it, and the
viewport is drawn anew with the sidebar, once, when that has changed. A sidebar that is hidden is not laid out at all.
"""

import bpy

from ..properties.overlay import ShowEnvironment
from ..scene.changes import LISTENERS, Listener

# Sidebars and viewports are known by their place in memory: what belongs to one that is gone is overwritten before it
# is asked for again, because a new one is drawn first.
_laid_out: set[int] = set()
_open: set[int] = set()
_shown: dict[int, bool] = {}


def panel_is_drawn(context) -> None:
    """The panel is laid out, in the sidebar of the context if it is in one."""
    region = context.region
    if region is not None and region.type == "UI":
        _laid_out.add(region.as_pointer())


def sidebar_is_drawn(context) -> None:
    """A sidebar is drawn, of which everything that is open has been laid out; the viewport beside it follows."""
    area, sidebar = context.area, context.region.as_pointer()
    if sidebar in _laid_out:
        _open.add(sidebar)
    else:
        _open.discard(sidebar)
    _laid_out.discard(sidebar)
    for region in area.regions:
        if region.type == "WINDOW" and _shown.get(region.as_pointer(), False) != is_in_sight(context.scene, area):
            region.tag_redraw()


def panel_is_open(sidebar) -> bool:
    """Whether the panel was open when a sidebar was drawn last."""
    return sidebar.as_pointer() in _open


def viewport_is_drawn(context) -> bool:
    """Whether the environment is to be drawn in the viewport of the context."""
    shown = _shown[context.region.as_pointer()] = is_in_sight(context.scene, context.area)
    return shown


def is_in_sight(scene, area) -> bool:
    """Whether a 3D viewport shows the environment of its scene."""
    space = area.spaces.active
    if scene is None or not space.overlay.show_overlays:
        return False
    wanted = ShowEnvironment[scene.wayfarer.overlay.show_environment]
    if wanted is not ShowEnvironment.WITH_PANEL:
        return wanted is ShowEnvironment.ALWAYS
    # While it slides out, the sidebar still counts as shown; where there is no room for it, it is as narrow as hidden.
    sidebars = (region for region in area.regions if region.type == "UI")
    return space.show_region_ui and any(sidebar.width > 1 and panel_is_open(sidebar) for sidebar in sidebars)


def windows_in_sight() -> list[bpy.types.Window]:
    """The windows in which the environment of their scene is in sight."""
    return [
        window
        for window in bpy.context.window_manager.windows
        if any(area.type == "VIEW_3D" and is_in_sight(window.scene, area) for area in window.screen.areas)
    ]


def _forget() -> None:
    for known in (_laid_out, _open, _shown):
        known.clear()


_LISTENER = Listener(closed=_forget)


def register():
    LISTENERS.append(_LISTENER)


def unregister():
    LISTENERS.remove(_LISTENER)
    _forget()
