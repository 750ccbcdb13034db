"""Inputs of the core from a scene: clips, shapes and settings as arrays and values, and their fingerprints."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...core.environment.environment import Environment, build_environment_steps
from ...core.environment.grid import Grid
from ...core.environment.pieces import Piece, solid_triangles
from ...core.environment.regions import Region, RegionRule
from ...core.errors import ClipError, SceneError
from ...core.motion.clip import MotionClip
from ...core.motion.doctor import DoctorSettings
from ...core.motion.graph_settings import MotionGraphSettings
from ...core.motion.heading import with_steady_heading
from ...core.motion.mirror import mirrored
from ...core.progress import Progress, finish
from ...core.wording import amount, exact, small
from ..bridge.clip_actions import character_problem
from ..bridge.copies import is_deformed_by
from ..bridge.owned import drawn_objects, is_copy
from ..bridge.read_actions import read_clip
from ..bridge.read_scene import ShapeMemory, read_own_piece, read_pieces, read_triangles, shown_objects
from ..bridge.rig import bind_rig
from ..properties.environment import REGION_TYPES, GroundSource
from .changes import belongs_to
from .fingerprint import fingerprint
from .motion_fingerprint import action_fingerprint

# ------------------------------------------------------------------------------------------------ motion


@dataclass(frozen=True)
class CharacterClips:
    """The clips in use.

    Attributes
    ----------
    clips : list of MotionClip
    problems : list of (action name, reason)
        Of those that cannot be read.
    seen : dict of str to str
        The fingerprint of each action, by its name.
    """

    clips: list[MotionClip]
    problems: list[tuple[str, str]]
    seen: dict[str, str]


def read_character_steps(scene) -> Generator[Progress, None, CharacterClips]:
    """Read the clips in use, one between two yields: hundreds of them take their time.

    Raises ClipError if the scene has no character, no action of it is in use, or one is deleted between two yields.
    """
    settings = scene.wayfarer
    problem = character_problem(scene)
    if problem:
        raise ClipError(f"{problem}.")
    character, actions = settings.character, settings.used_actions()
    if not actions:
        raise ClipError(f"No action of '{character.name}' is in use; refresh the clips or tick at least one.")
    read, binding = CharacterClips([], [], {}), bind_rig(character)
    names = [action.name for action in actions]
    for done, (name, action) in enumerate(zip(names, actions, strict=True)):
        yield Progress(done / len(actions), f"Reading {name}")
        try:
            read.seen[name] = action_fingerprint(scene, action)
            read.clips.append(read_clip(character, action, binding=binding))
        except ClipError as error:
            read.problems.append((name, str(error)))
        except ReferenceError as error:
            raise ClipError(f"'{name}' or its character was deleted before it was read; start again.") from error
    return read


def check_any(scene, read: CharacterClips) -> None:
    """Raise ClipError, with the first reason, if no clip could be read."""
    if not read.clips:
        name, reason = read.problems[0]
        raise ClipError(f"No action of '{scene.wayfarer.character.name}' can be used. '{name}': {reason}")


def read_character(scene) -> tuple[list[MotionClip], list[tuple[str, str]]]:
    """The clips in use, and (action name, reason) of those that cannot be read; see :func:`read_character_steps`."""
    read = finish(read_character_steps(scene))
    return read.clips, read.problems


def prepared_clips_steps(
    clips: Sequence[MotionClip], steady_heading: bool, mirror: bool
) -> Generator[Progress, None, list[MotionClip]]:
    """The clips as the motion graph is to get them, their mirror images after them.

    Raises ClipError for a clip that has no heading, or cannot be mirrored.
    """
    prepared = list(clips)
    if steady_heading:
        for place, clip in enumerate(clips):
            yield Progress(0.0, f"Steadying {clip.name}")
            prepared[place] = with_steady_heading(clip)
    if mirror:
        for clip in prepared[: len(clips)]:
            yield Progress(0.0, f"Mirroring {clip.name}")
            prepared.append(mirrored(clip))
    return prepared


def graph_settings(scene) -> MotionGraphSettings:
    """Return how the scene wants its motion graph built; ClipError if the settings contradict the character."""
    settings = scene.wayfarer
    return settings.graph.to_core(settings.contacts.to_core(settings.character))


def doctor_settings(scene) -> DoctorSettings:
    """Return what counts as a defect in the scene; ClipError if its feet are none of the character's."""
    settings = scene.wayfarer
    return DoctorSettings(
        min_segment_duration=settings.graph.min_segment_duration, feet=settings.contacts.feet(settings.character)
    )


def graph_settings_fingerprint(scene) -> str:
    settings = scene.wayfarer
    graph = settings.graph
    return fingerprint(graph.to_core(), settings.contacts.values(), graph.mirror_clips, graph.steady_heading)


def doctor_settings_fingerprint(scene) -> str:
    settings = scene.wayfarer
    contacts = settings.contacts
    return fingerprint(settings.graph.min_segment_duration, contacts.left_foot, contacts.right_foot)


def contacts_fingerprint(scene) -> str:
    return fingerprint(scene.wayfarer.contacts.values())


# ----------------------------------------------------------------------------------------------- ground


_NARROW = 0.001
"""Metres that a ground must extend: a wall that is to be upright is not quite."""


_COARSEST = 1 / 16
"""Share of a cell that neighbouring numbers may be apart: a quarter of a sample."""


@dataclass(frozen=True)
class SceneShapes:
    """The shapes in a scene.

    Attributes
    ----------
    pieces : tuple of Piece
        The obstacles, in metres.
    low, high : (x, y)
        Corners of the ground rectangle in metres.
    ground_height : float
        World z of the ground in metres.
    ground : Piece or None
        What can be stood on, seen from above; None where the ground is the whole rectangle.
    regions : tuple of (T, 3, 3) float array
        Triangles of each of the scene's regions, in their order; those without an object are left out.
    """

    pieces: tuple[Piece, ...]
    low: tuple[float, float]
    high: tuple[float, float]
    ground_height: float
    ground: Piece | None
    regions: tuple[np.ndarray, ...]

    @property
    def obstacles(self) -> np.ndarray:
        """(T, 3, 3) world-space triangles in metres of all obstacles; those of solid ones look outwards."""
        return solid_triangles(self.pieces, (self.low, self.high))

    @cached_property
    def fingerprint(self) -> str:
        keys = [piece.key for piece in self.pieces]
        outline = () if self.ground is None else self.ground.key
        return fingerprint(keys, self.low, self.high, self.ground_height, outline, *self.regions)


def read_shapes(scene, depsgraph, memory: ShapeMemory | None = None) -> SceneShapes:
    """Ground, obstacles and regions of a scene as they are at its present frame.

    With a ``memory``, shapes that it knows are not read again.

    Raises SceneError if there is nothing that the ground could come from, if a region has no faces, or if ground or
    region are part of the character.
    """
    settings = scene.wayfarer.environment
    # Blender goes on evaluating what is in a collection that is hidden by its eye.
    shown = shown_objects(obstacle_objects(scene), depsgraph.view_layer)
    pieces, ground = read_pieces(shown, depsgraph, memory), None
    if settings.source is GroundSource.OBJECT:
        _check_stays(scene, "ground", settings.ground)
        if settings.ground is not None and settings.ground.type in REGION_TYPES:
            ground = read_own_piece(settings.ground, depsgraph, memory)
    low, high, height = _ground(settings, pieces, ground, depsgraph)
    _check_precision(settings, low, high)
    if ground is not None and ground.fills_rectangle:
        ground = None
    regions = []
    for region in settings.regions:
        if region.object is not None:
            _check_stays(scene, "region", region.object)
            triangles = read_triangles([region.object], depsgraph, memory)
            if len(triangles) == 0:
                raise SceneError(
                    f"The region '{region.object.name}' shows no faces; unhide it, give it some, or remove the region."
                )
            regions.append(triangles)
    return SceneShapes(pieces, low, high, height, ground, tuple(regions))


def obstacle_objects(scene) -> Iterator:
    """Yield what may stand in the way: the :func:`solid_objects` of the obstacles' collection, hidden ones too."""
    obstacles = scene.wayfarer.environment.obstacles
    if obstacles is not None:
        yield from solid_objects(scene, obstacles.all_objects)


def solid_objects(scene, objects: Iterable) -> Iterator:
    """Yield the objects that stay where they are: without the ground, the regions, what Wayfarer draws, and all that
    goes along with the character, a copy of it or a walk.

    What is a child of the ground, of the painted floor or of a region stands there like everything else.
    """
    settings = scene.wayfarer.environment
    ours, character = drawn_objects(scene), scene.wayfarer.character
    others = {*ours, settings.ground, *(region.object for region in settings.regions)}
    # Curves of walks may carry what follows them; the floor stays where it is.
    carriers = {character, *(obj for obj in ours if obj.type == "CURVE")}
    solid = (obj for obj in objects if obj not in others)
    yield from (obj for obj in solid if not _goes_along(obj, carriers, character))


def _goes_along(obj, carriers: set, character) -> bool:
    """Return True if an object hangs below a carrier or a copy of the character, however deep, or is deformed by it."""
    while obj is not None:
        if obj in carriers or is_copy(obj) or (character is not None and is_deformed_by(obj, character)):
            return True
        obj = obj.parent
    return False


def _check_stays(scene, what: str, obj) -> None:
    """SceneError if an object that an environment is to be made from goes where the character goes."""
    if obj in drawn_objects(scene):
        raise SceneError(
            f"The {what} '{obj.name}' is what Wayfarer draws, and changes with what it shows; choose another object."
        )
    if belongs_to(obj, scene.wayfarer.character):
        raise SceneError(
            f"The {what} '{obj.name}' is part of the character, and would be elsewhere after every walk; choose "
            "another object."
        )


def _ground(
    settings, pieces: Sequence[Piece], ground: Piece | None, depsgraph
) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Low and high corner (x, y) of the ground rectangle, and its height."""
    if settings.source is GroundSource.TYPED:
        return tuple(settings.ground_low), tuple(settings.ground_high), settings.ground_height
    if settings.source is GroundSource.OBJECT and settings.ground is not None:
        # An outline of edges alone is a ground, too.
        corners = _world_bounds(settings.ground, depsgraph) if ground is None else ground.bounds
        height = corners[:, 2].max()
        if np.any(np.ptp(corners[:, :2], axis=0) < _NARROW):
            raise SceneError(
                f"The ground '{settings.ground.name}' has no faces to walk on; choose a mesh that lies flat."
            )
    elif pieces:
        corners = np.concatenate([piece.bounds for piece in pieces])
        height = corners[:, 2].min()
    else:
        raise SceneError(
            "There is no ground; choose a ground object or a collection of obstacles in the Environment panel, or type "
            "its corners in."
        )
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    return tuple(low.tolist()), tuple(high.tolist()), float(height)


def _check_precision(settings, low: Sequence[float], high: Sequence[float]) -> None:
    """SceneError if Blender's numbers, of single precision, are too coarse for cells on a ground (m) so far away."""
    farthest = max(map(abs, (*low, *high)))
    apart = float(np.spacing(np.float32(farthest)))
    if apart <= _COARSEST * settings.cell_size:
        return
    obj = settings.ground if settings.source is GroundSource.OBJECT else None
    ground = "ground" if obj is None else f"ground '{obj.name}'"
    raise SceneError(
        f"The {ground} lies {amount(farthest / 1000)} km from the origin, where Blender's numbers are {small(apart)} "
        f"apart, too coarse for cells of {exact(settings.cell_size)} m; move the scene to the origin."
    )


def make_environment(scene, shapes: SceneShapes) -> Environment:
    """The environment that the scene's settings make of these shapes; SceneError if they make none."""
    return finish(make_environment_steps(scene, shapes))


def make_environment_steps(
    scene, shapes: SceneShapes, memory: ShapeMemory | None = None
) -> Generator[Progress, None, Environment]:
    """Make the environment in steps, for which nothing of Blender's is needed any more.

    With a ``memory``, obstacles and a ground that are where they were when it was made last are not looked at again.
    """
    settings = scene.wayfarer.environment
    grid = Grid.over_rectangle(shapes.low, shapes.high, settings.cell_size, settings.n_headings, settings.tiled)
    body, cache = settings.to_core(shapes.ground_height), memory.obstacles if memory is not None else None
    return build_environment_steps(grid, shapes.pieces, scene_regions(scene, shapes), body, cache, shapes.ground)


def scene_regions(scene, shapes: SceneShapes) -> list[Region]:
    """The scene's regions with their rules; SceneError for one without a tag."""
    present = [region for region in scene.wayfarer.environment.regions if region.object is not None]
    regions = []
    for region, triangles in zip(present, shapes.regions, strict=True):
        tag = region.tag.strip()
        if not tag:
            raise SceneError(f"The region '{region.object.name}' has no tag; name the one that it speaks of.")
        regions.append(Region(region.object.name, RegionRule[region.rule], tag, triangles, region.margin))
    return regions


def environment_settings_fingerprint(scene) -> str:
    """Return that of everything but the shapes that an embedding depends on, whatever things are called."""
    settings = scene.wayfarer
    environment = settings.environment
    regions = [
        # Nothing grows where a tag is confined.
        (region.rule, region.tag, 0.0 if region.rule == "CONFINE" else region.margin)
        for region in environment.regions
        if region.object is not None
    ]
    return fingerprint(
        environment.cell_size,
        environment.n_headings,
        environment.tiled,
        environment.to_core(0.0),
        regions,
        settings.embedding.to_core(),
    )


def _world_bounds(obj, depsgraph) -> np.ndarray:
    """(8, 3) world positions of the corners of an object's bounding box, modifiers applied."""
    evaluated = obj.evaluated_get(depsgraph)
    corners = np.array([tuple(corner) for corner in evaluated.bound_box])
    matrix = np.array(evaluated.matrix_world)
    return corners @ matrix[:3, :3].T + matrix[:3, 3]
