"""The fifth part of the session: regions, presets, and how it all looks in another theme and size."""

import bpy
import editors
import hand
import numpy as np
import picture
import sidebar
from scene_facts import badges, keep_picture, legend_facts, part, settings

_PRESETS = {False: 94, True: 158}
"""Pixels from the right edge of the sidebar to the button of a panel's presets: beside a check mark, and beside the
badge of what has changed."""
_FIRST_ROW, _LAST_ROW = 30, 18
"""From the upper edge of a popover, with its arrow, to the middle of its first row, and from the lower to the last."""


def add_region(note) -> hand.Turns:
    """An object becomes a region with a rule, which is drawn where the environment is."""
    box = "Environment", "wayfarer.overlay.show_environment"
    with bpy.context.temp_override(**hand.in_viewport()):
        bpy.ops.mesh.primitive_plane_add(size=1.2, location=(-1.6, -2.2, 0.02))
    rug = bpy.context.active_object
    rug.name = "Rug"
    bpy.ops.ed.undo_push(message="Rug")
    regions = settings().environment.regions
    before = len(regions)
    yield from sidebar.open_part("Environment", "Regions")
    yield from sidebar.press_button("Environment", "wayfarer.add_region", sidebar.BESIDE_LIST)
    yield from hand.until(lambda: len(regions) == before + 1, "the region")
    yield from hand.redrawn()
    region, path = regions[before], f"wayfarer.environment.regions[{before}]"
    yield from editors.turn_to("Environment", f"{path}.rule", lambda: region.rule, "FORBID")
    yield from editors.fill("Environment", f"{path}.tag", "step")
    yield from hand.until(lambda: badges()["embedding"], "the embedding to be out of date")
    note("region", [region.object.name, region.rule, region.tag])
    color = part("render.environment_lines").RULES[part("properties.environment").RegionRule.FORBID]
    yield from sidebar.press_button(*box)
    yield from hand.until(lambda: _n_pixels(color) > 100, "the outline of the region")
    yield from hand.rest()
    note("drawn", _n_pixels(color))
    keep_picture("38_regions")
    yield from sidebar.press_button(*box)
    yield from sidebar.press_button("Environment", "wayfarer.remove_region", sidebar.BESIDE_LIST)
    yield from hand.until(lambda: len(regions) == before, "the region to be gone")
    note("object_stays", rug.name in bpy.data.objects)
    bpy.data.objects.remove(rug)
    yield from hand.until(lambda: not badges()["embedding"], "the embedding to be up to date again")
    yield from sidebar.close_part("Environment", "Regions")


def _n_pixels(color) -> int:
    """How many pixels of the viewport, beside the sidebar, have nearly an sRGB colour."""
    view = hand.region()
    shown = picture.pixels()[view.y : view.y + view.height, view.x : hand.region("UI").x]
    return int((np.abs(shown - 255 * np.array(color[:3])).max(axis=2) < 24).sum())


def keep_preset(note) -> hand.Turns:
    """Settings kept under a name, and brought back by it."""
    embedding = settings().embedding
    before, embedding.position_rate = embedding.position_rate, 0.11
    yield from sidebar.open_panel("Embedding")
    yield from hand.until(lambda: badges()["embedding"], "the embedding to be out of date")
    left, low, width, height = yield from _open_presets("Embedding")
    yield from hand.move(left + 0.4 * width, low + _LAST_ROW)
    yield from hand.press("RET")
    yield from hand.type_text("roomy")
    yield from hand.press("RET")
    yield from hand.click(left + width - _LAST_ROW, low + _LAST_ROW)
    yield from hand.until(lambda: bpy.utils.preset_paths("wayfarer/embedding"), "the preset")
    keep_picture("39_presets")
    yield from hand.press("ESC")
    embedding.position_rate = before
    yield from hand.until(lambda: not badges()["embedding"], "the embedding to be up to date again")
    left, low, width, height = yield from _open_presets("Embedding")
    keep_picture("40_presets_with_one")
    yield from hand.click(left + 0.4 * width, low + height - _FIRST_ROW)
    yield from hand.until(lambda: embedding.position_rate != before, "the preset's settings")
    note("rate", embedding.position_rate)
    # A click while the popover is open closes that, and nothing else.
    yield from hand.press("ESC")
    yield from hand.rest()
    embedding.position_rate = before
    yield from hand.until(lambda: not badges()["embedding"], "the embedding to be up to date again")


def _open_presets(panel: str):
    """The popover of a panel's presets: x, y, width and height."""
    side = hand.region("UI")
    yield from hand.redrawn()
    x = side.x + side.width - _PRESETS[badges()[panel.lower()]]
    return (yield from editors.open_popup(x, sidebar.header(panel)))


def light_theme(note) -> hand.Turns:
    """Every panel, and the legend, in the light theme that Blender comes with."""
    paths = bpy.utils.preset_paths("interface_theme")
    bpy.ops.script.execute_preset(
        filepath=f"{paths[0]}/Blender_Light.xml", menu_idname="USERPREF_MT_interface_theme_presets"
    )
    yield from hand.redrawn()
    yield from _look_at_panels("light")
    note("legend", (yield from legend_facts()))
    bpy.ops.preferences.reset_default_theme()
    yield from hand.redrawn()


def large_interface(note) -> hand.Turns:
    """Every panel, and the legend, half as large again."""
    view, width = bpy.context.preferences.view, hand.region("UI").width
    view.ui_scale = 1.5
    yield from hand.until(lambda: hand.region("UI").width > 1.3 * width, "the wider sidebar")
    yield from hand.redrawn()
    yield from _look_at_panels("large")
    note("legend", (yield from legend_facts()))
    view.ui_scale = 1.0
    yield from hand.until(lambda: hand.region("UI").width == width, "the sidebar as it was")
    yield from hand.redrawn()


def _look_at_panels(name: str) -> hand.Turns:
    for panel in sidebar.panels():
        yield from sidebar.open_panel(panel)
        yield from hand.redrawn(kind="UI")
        keep_picture(f"{name}_{panel.lower().replace(' ', '_')}")
