"""Solid viewports that show the painted floor."""

from ..bridge.versions import keep_material_colors


def show_colors(screen, scene) -> None:
    """Let solid viewports that colour by material colour by attribute, the only way in which they show a map."""
    keep_material_colors(scene.objects)
    for area in screen.areas if screen else ():
        if area.type == "VIEW_3D":
            shading = area.spaces.active.shading
            if shading.type == "SOLID" and shading.color_type == "MATERIAL":
                shading.color_type = "VERTEX"
