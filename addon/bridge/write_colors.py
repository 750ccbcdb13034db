"""A ground of flat coloured cells."""

from typing import cast

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import SceneError
from .materials import own_material
from .owned import GRID_PROPERTY, painted_ground, painted_shape
from .versions import node_tree

ATTRIBUTE = "Wayfarer Map"
"""Name of the colour attribute and of the material. (Cycles shows names such as "heat" or "density" as black.)"""

_PLACE_PROPERTY = "wayfarer_place"


def painted_cell_size(obj) -> float:
    """Metres from cell to cell of a :func:`ground_grid`."""
    return float(obj[_PLACE_PROPERTY][2])


def ground_grid(name: str, x0: float, y0: float, cell_size: float, nx: int, ny: int, z: float, collection):
    """A mesh object with one square for each of nx x ny cells, to be painted with :func:`paint`.

    Cell (ix, iy) spans x0 + ix * cell_size to x0 + (ix + 1) * cell_size in metres, y likewise, at height
    ``z``; it has four vertices of its own, so that colours do not run into each other. What this function
    put into the collection before is used again, whatever its name, and its mesh too if it has as many cells. The
    object stands at the world's origin and shows the attribute through a material.
    """
    obj = painted_ground(collection)
    if obj is None:
        obj = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        collection.objects.link(obj)
    if obj.matrix_world != Matrix.Identity(4):
        obj.matrix_world = Matrix.Identity(4)
    mesh = cast(bpy.types.Mesh, obj.data)
    place = (x0, y0, cell_size, z)
    remade = painted_shape(obj) != (nx, ny) or len(mesh.polygons) != nx * ny
    # Someone may have merged them.
    remade = remade or len(mesh.vertices) != 4 * nx * ny
    if not remade and tuple(obj.get(_PLACE_PROPERTY, ())) == place:
        # Painted again in the same place, as live evaluation does many times a second.
        return obj
    if remade:
        mesh.clear_geometry()
        numbers = np.arange(4 * nx * ny, dtype=np.int32)
        mesh.vertices.add(4 * nx * ny)
        mesh.edges.add(4 * nx * ny)
        mesh.loops.add(4 * nx * ny)
        mesh.polygons.add(nx * ny)
        mesh.polygons.foreach_set("loop_start", numbers[::4].copy())
        # Corner k of a cell is its vertex k, and edge k leads from there to the next. (Blender would take two
        # seconds to find the edges of 640,000 cells, and one to fill mesh.loops instead of the attributes.)
        ends = np.stack([numbers, np.roll(numbers.reshape(-1, 4), -1, axis=1).ravel()], axis=1)
        mesh.attributes[".corner_vert"].data.foreach_set("value", numbers)
        mesh.attributes[".corner_edge"].data.foreach_set("value", numbers)
        mesh.attributes[".edge_verts"].data.foreach_set("value", ends.ravel())
        obj[GRID_PROPERTY] = (nx, ny)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32)
    cells = np.stack(np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"), axis=-1)
    positions = np.empty((nx, ny, 4, 3), dtype=np.float32)
    positions[..., :2] = (x0, y0) + cell_size * (cells[:, :, None] + corners)
    positions[..., 2] = z
    mesh.attributes["position"].data.foreach_set("vector", positions.ravel())
    mesh.update()
    obj[_PLACE_PROPERTY] = place
    if not mesh.materials:
        mesh.materials.append(_map_material(ATTRIBUTE))
    return obj


def paint(obj, colors: np.ndarray, attribute: str = ATTRIBUTE) -> None:
    """Colour the cells of a :func:`ground_grid`.

    ``colors`` is (nx, ny, 4): linear RGBA, indexed by cell. The attribute becomes the active one, which the
    viewport's solid mode shows when it colours by attribute; the material shows it everywhere else, its
    alpha included.

    Raises ValueError if ``colors`` has another number of cells than the object.
    """
    mesh = obj.data
    if colors.shape != (*obj[GRID_PROPERTY], 4):
        raise ValueError(f"{colors.shape} colours for {tuple(obj[GRID_PROPERTY])} cells")
    layer = mesh.color_attributes.get(attribute)
    if layer is not None and (layer.domain, layer.data_type) != ("POINT", "FLOAT_COLOR"):
        # Someone has converted it.
        mesh.color_attributes.remove(layer)
        layer = None
    is_new = layer is None
    if is_new:
        layer = mesh.color_attributes.new(attribute, "FLOAT_COLOR", "POINT")
    if is_new or mesh.color_attributes.active_color_name != attribute:
        mesh.color_attributes.active_color = layer
        mesh.color_attributes.render_color_index = mesh.color_attributes.find(attribute)
        if mesh.materials:
            mesh.materials[0] = _map_material(attribute)
        else:
            mesh.materials.append(_map_material(attribute))
    corners = np.repeat(np.asarray(colors, dtype=np.float32).reshape(-1, 4), 4, axis=0)
    layer.data.foreach_set("color", corners.ravel())
    mesh.update_tag()


def painted_colors(obj, attribute: str = ATTRIBUTE) -> np.ndarray:
    """(nx, ny, 4) float32 linear RGBA of the cells of a :func:`ground_grid`, as :func:`paint` left them.

    Raises SceneError if someone is editing the object, or has.
    """
    if obj.data.is_editmode:
        raise SceneError(f"The floor '{obj.name}' is being edited; leave Edit Mode, so that its colors can be read.")
    layer, shape = obj.data.color_attributes.get(attribute), (*obj[GRID_PROPERTY], 4, 4)
    if layer is None or 4 * len(layer.data) != np.prod(shape):
        raise SceneError(f"The floor '{obj.name}' is not as it was painted; paint the map again.")
    corners = np.empty(4 * len(layer.data), dtype=np.float32)
    layer.data.foreach_get("color", corners)
    return corners.reshape(shape)[:, :, 0]


def _map_material(attribute: str):
    """The material that glows in the colours of ``attribute``; made once."""

    def furnish(material) -> None:
        material.surface_render_method = "BLENDED"
        tree = node_tree(material)
        nodes, links = tree.nodes, tree.links
        nodes.clear()
        output = nodes.new("ShaderNodeOutputMaterial")
        mix = nodes.new("ShaderNodeMixShader")
        clear = nodes.new("ShaderNodeBsdfTransparent")
        glow = nodes.new("ShaderNodeEmission")
        color = nodes.new("ShaderNodeVertexColor")
        color.layer_name = attribute
        links.new(color.outputs["Color"], glow.inputs["Color"])
        links.new(color.outputs["Alpha"], mix.inputs[0])
        links.new(clear.outputs[0], mix.inputs[1])
        links.new(glow.outputs[0], mix.inputs[2])
        links.new(mix.outputs[0], output.inputs["Surface"])
        for node, place in ((color, (-600, 0)), (glow, (-350, 0)), (clear, (-350, 150)), (mix, (-120, 0))):
            node.location = place
        output.location = (80, 0)

    return own_material(attribute, furnish)
