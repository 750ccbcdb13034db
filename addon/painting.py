"""Maps of the embedding, painted on the floor of the scene."""

from ..core.embedding.embedding import Embedding
from .render.floor import put_on_floor
from .render.maps import PaintedMap
from .state import keep_painted, results


def paint_floor(scene, embedding: Embedding, painted: PaintedMap, key: str, offset: float, in_operator: bool = False):
    """Paint a map of the scene's embedding on its floor, and keep what the floor shows and the numbers for the panels.

    ``key`` is that of the map (``scene.wayfarer.map.key``), ``offset`` the floor's height above the ground in metres.
    Raises SceneError if the floor cannot be painted: then nothing has changed.
    """
    found = results(scene)
    floor = put_on_floor(scene, embedding.environment.grid, found.ground_height, offset, painted, in_operator)
    keep_painted(scene, floor, embedding, key, in_operator)
    found.summary.update(painted.numbers)
