"""Objects that stand on the ground and are in no collection of obstacles: walks pass through them."""

from collections.abc import Iterable

import bpy
import numpy as np

from ..bridge.read_scene import shown_objects
from ..properties.environment import REGION_TYPES, GroundSource
from .inputs import obstacle_objects, solid_objects


def unlisted_objects(scene) -> list[bpy.types.Object]:
    """Return the visible objects that reach into the room that the character needs over the ground, but are no
    obstacles. What holds the whole ground is a backdrop, and left out.
    """
    settings, view_layer = scene.wayfarer.environment, bpy.context.view_layer
    ground = _ground(scene, view_layer)
    if ground is None:
        return []
    low = [*(ground[0, :2] - settings.radius), ground[1, 2] + settings.step_height]
    high = [*(ground[1, :2] + settings.radius), ground[1, 2] + settings.head_height]
    listed = set(settings.obstacles.all_objects) if settings.obstacles is not None else set()
    faces = (obj for obj in scene.objects if obj.type in REGION_TYPES and obj not in listed)
    found = []
    for obj in shown_objects(solid_objects(scene, faces), view_layer):
        box = _bounds([obj])
        holds_all = np.all(box[0, :2] <= ground[0, :2]) and np.all(box[1, :2] >= ground[1, :2])
        reaches = np.all(box[1] > low) and np.all(box[0] < high)
        if reaches and not holds_all and obj.display_type in {"SOLID", "TEXTURED"}:
            found.append(obj)
    return found


def _ground(scene, view_layer) -> np.ndarray | None:
    """Lowest and highest corner (2, 3) of the ground (m), as far as boxes tell; None without any."""
    settings = scene.wayfarer.environment
    if settings.source is GroundSource.TYPED:
        z = settings.ground_height
        return np.array([(*settings.ground_low, z), (*settings.ground_high, z)])
    if settings.source is GroundSource.OBJECT and settings.ground is not None:
        return _bounds([settings.ground])
    shown = [obj for obj in shown_objects(obstacle_objects(scene), view_layer) if obj.type in REGION_TYPES]
    if not shown:
        return None
    box = _bounds(shown)
    box[1, 2] = box[0, 2]  # what has no ground stands on the height of its lowest
    return box


def _bounds(objects: Iterable) -> np.ndarray:
    """(2, 3) lowest and highest world coordinates (m) of the objects' boxes."""
    corners = []
    for obj in objects:
        matrix = np.array(obj.matrix_world)
        corners.append(np.array([tuple(corner) for corner in obj.bound_box]) @ matrix[:3, :3].T + matrix[:3, 3])
    corners = np.concatenate(corners)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])
