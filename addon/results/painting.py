"""Maps of the embedding, painted on the floor of the scene."""

from ...core.embedding.embedding import Embedding
from ...core.errors import SceneError
from ...core.maps import PaintedMap
from ..render.floor import find_floor, put_on_floor
from .state import keep_painted, results


def paint_floor(scene, embedding: Embedding, painted: PaintedMap, key: str, offset: float, in_operator: bool = False):
    """Paint a map of the scene's embedding on its floor, and keep what the floor shows and the numbers for the panels.

    ``key`` is that of the map (``scene.wayfarer.map.key``), ``offset`` the floor's height above the ground in metres.
    Raises SceneError if the floor is being edited, or if undo has taken it away and no operator asks for another one:
    that would come back however often it is undone, and nothing could be redone any more. Then nothing has changed.
    """
    found = results(scene)
    if not in_operator and find_floor(scene) is None and found.map_was_undone:
        raise SceneError("The painted floor was undone; redo, or paint the map again.")
    floor = put_on_floor(scene, embedding.environment.grid, found.ground_height, offset, painted)
    keep_painted(scene, floor, embedding, key, in_operator)
    found.summary.update(painted.numbers)
