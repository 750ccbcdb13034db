"""The triangles of scene objects, as Blender shows them."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import bpy
import numpy as np

from ...core.environment.obstacle_masks import ObstacleCache
from ...core.environment.pieces import Piece, Shape, all_triangles
from ...core.errors import SceneError
from ...core.motion.kinematics import FARTHEST
from ...core.wording import amount

_MOST_PIECES = 20_000
"""Places of shapes that are remembered; a scene that has more loses only time."""


@dataclass
class ShapeMemory:
    """Shapes that have been read, so that what did not change shape is not read again, and what is known of those that
    did not move.

    A shape is known by the evaluated mesh that it was read from. That mesh lives until the object that shows it, or
    the object that instances it, changes its geometry: whoever keeps a memory must :meth:`forget` these objects then,
    and everything when Blender makes its evaluated data anew (undo, another file or view layer).

    Attributes
    ----------
    obstacles : ObstacleCache
        What the shapes leave on the ground; known by their content, and so never wrong.
    """

    obstacles: ObstacleCache = field(default_factory=ObstacleCache)
    _shapes: dict[tuple, Shape] = field(default_factory=dict)
    _pieces: dict[tuple, Piece] = field(default_factory=dict)

    def shape(self, shown, source) -> Shape:
        """Return what an evaluated object shows, in its own space; ``source`` is what it comes from."""
        mesh = shown.data
        owners = shown.original.session_uid, source.original.session_uid
        key = (*owners, mesh.as_pointer(), len(mesh.vertices), len(mesh.polygons))
        if key not in self._shapes:
            self._shapes[key] = Shape(_local_triangles(shown))
        return self._shapes[key]

    def piece(self, shape: Shape, matrix: np.ndarray) -> Piece:
        """A shape of this memory in its place."""
        key = id(shape), matrix.tobytes()
        if key not in self._pieces:
            if len(self._pieces) >= _MOST_PIECES:
                self._pieces.clear()
            self._pieces[key] = Piece(shape, matrix)
        return self._pieces[key]

    def forget(self, objects: Iterable[int]) -> None:
        """Forget what these objects, given by their session uid, show or instance."""
        changed = set(objects)
        if not any(changed.intersection(key[:2]) for key in self._shapes):
            return
        self._shapes = {key: shape for key, shape in self._shapes.items() if not changed.intersection(key[:2])}
        known = {id(shape) for shape in self._shapes.values()}
        self._pieces = {key: piece for key, piece in self._pieces.items() if key[0] in known}

    def clear(self) -> None:
        self._shapes.clear()
        self._pieces.clear()


def read_pieces(objects: Iterable, depsgraph, memory: ShapeMemory | None = None) -> tuple[Piece, ...]:
    """Return what ``objects`` show, in metres: one piece for each mesh that has faces.

    Evaluated: modifiers and geometry nodes are applied, and everything that the objects instance
    (collections, instances of geometry nodes, duplis, particles) is included where it stands. Curves, text
    and metaballs count by their surface. Objects without faces, and objects hidden in the viewport, give no
    pieces. One Blender unit is one metre. With a ``memory``, shapes that it knows are not read again.

    Raises SceneError, naming the object, if a coordinate is not a number or absurdly large.
    """
    wanted = {obj.original for obj in objects}
    # Many instances share one shape; evaluated data stays in place while the instances are listed.
    memory = ShapeMemory() if memory is None else memory
    pieces = []
    for instance in depsgraph.object_instances:
        shown = instance.object
        source = instance.parent if instance.is_instance else shown
        if source is None or source.original not in wanted or shown.type != "MESH":
            # Curves, text and metaballs are listed a second time, as an instance of their own mesh.
            continue
        shape = memory.shape(shown, source)
        if len(shape.triangles) == 0:
            continue
        pieces.append(_checked(source, memory.piece(shape, np.array(instance.matrix_world, dtype=float))))
    return tuple(pieces)


def read_own_piece(obj, depsgraph, memory: ShapeMemory | None = None) -> Piece | None:
    """Return what an object shows by itself, modifiers applied, in metres; also of a hidden one, but nothing that it
    instances. None if it has no faces.

    Raises SceneError, naming the object, if a coordinate is not a number or absurdly large.
    """
    evaluated = obj.evaluated_get(depsgraph)
    matrix = np.array(evaluated.matrix_world, dtype=float)
    if memory is not None and evaluated.type == "MESH":
        piece = memory.piece(memory.shape(evaluated, evaluated), matrix)
    else:
        piece = Piece(Shape(_local_triangles(evaluated)), matrix)
    return _checked(evaluated, piece) if len(piece.shape.triangles) else None


def shown_objects(objects: Iterable, view_layer) -> list:
    """Return the objects that a view layer shows.

    Those that a viewport leaves out for a while, in its local view, stand where they stood.
    """
    with bpy.context.temp_override(area=None, region=None):
        return [obj for obj in objects if obj.visible_get(view_layer=view_layer)]


def _checked(source, piece: Piece) -> Piece:
    """Return a piece that comes from an object; SceneError, naming that, if it cannot be worked with."""
    name = source.original.name
    if not (piece.shape.is_finite and np.isfinite(piece.matrix).all()):
        raise SceneError(
            f"The object '{name}' has vertices whose position is not a number; repair its mesh or its modifiers, or "
            "leave it out."
        )
    if piece.farthest > FARTHEST:
        raise SceneError(
            f"The object '{name}' reaches farther than {amount(FARTHEST / 1000)} km from the origin; move the scene to "
            "the origin, shrink the object, or leave it out."
        )
    return piece


def read_triangles(objects: Iterable, depsgraph, memory: ShapeMemory | None = None) -> np.ndarray:
    """(T, 3, 3) world positions in metres of the corners of all triangles of ``objects``: [triangle, corner,
    xyz]; see :func:`read_pieces`.
    """
    return all_triangles(read_pieces(objects, depsgraph, memory))


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
