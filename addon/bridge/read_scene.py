"""The triangles of scene objects, as Blender shows them."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ...core.errors import SceneError


@dataclass
class ShapeMemory:
    """Triangles that have been read, so that what did not change shape is not read again.

    A shape is known by the evaluated mesh that it was read from. That mesh lives until the object that shows it, or
    the object that instances it, changes its geometry: whoever keeps a memory must :meth:`forget` these objects then,
    and everything when Blender makes its evaluated data anew (undo, another file or view layer).
    """

    _shapes: dict[tuple, np.ndarray] = field(default_factory=dict)

    def triangles(self, shown, source) -> np.ndarray:
        """(T, 3, 3) corners in the object's own space of an evaluated object, ``source`` being what it comes from."""
        mesh = shown.data
        owners = shown.original.session_uid, source.original.session_uid
        key = (*owners, mesh.as_pointer(), len(mesh.vertices), len(mesh.polygons))
        if key not in self._shapes:
            self._shapes[key] = _local_triangles(shown)
        return self._shapes[key]

    def forget(self, objects: Iterable[int]) -> None:
        """Forget what these objects, given by their session uid, show or instance."""
        changed = set(objects)
        self._shapes = {key: shape for key, shape in self._shapes.items() if not changed.intersection(key[:2])}

    def clear(self) -> None:
        self._shapes.clear()


def read_triangles(objects: Iterable, depsgraph, memory: ShapeMemory | None = None) -> np.ndarray:
    """(T, 3, 3) world positions in metres of the corners of all triangles of ``objects``: [triangle, corner,
    xyz].

    Evaluated: modifiers and geometry nodes are applied, and everything that the objects instance
    (collections, instances of geometry nodes, duplis, particles) is included where it stands. Curves, text
    and metaballs count by their surface. Objects without faces, and objects hidden in the viewport, give no
    triangles. One Blender unit is one metre. With a ``memory``, shapes that it knows are not read again.

    Raises SceneError, naming the object, if a coordinate is not a number.
    """
    wanted = {obj.original for obj in objects}
    # Many instances share one shape; evaluated data stays in place while the instances are listed.
    memory = ShapeMemory() if memory is None else memory
    triangles = []
    for instance in depsgraph.object_instances:
        shown = instance.object
        source = instance.parent if instance.is_instance else shown
        if source is None or source.original not in wanted or shown.type != "MESH":
            # Curves, text and metaballs are listed a second time, as an instance of their own mesh.
            continue
        local = memory.triangles(shown, source)
        if len(local) == 0:
            continue
        matrix = np.array(instance.matrix_world, dtype=float)
        corners = local.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(corners).all():
            raise SceneError(
                f"The object '{source.original.name}' has vertices whose position is not a number; repair its mesh "
                "or its modifiers, or leave it out of the obstacles."
            )
        triangles.append(corners.reshape(-1, 3, 3))
    return np.concatenate(triangles) if triangles else np.empty((0, 3, 3))


def _local_triangles(evaluated) -> np.ndarray:
    """(T, 3, 3) corners in the object's own space."""
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        corners = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", corners)
        positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        if len(mesh.vertices):
            mesh.attributes["position"].data.foreach_get("vector", positions)
        return positions.reshape(-1, 3)[corners].astype(float).reshape(-1, 3, 3)
    finally:
        evaluated.to_mesh_clear()
