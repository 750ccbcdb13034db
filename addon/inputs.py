"""What a scene gives to the core: clips, shapes and settings as arrays and values, and their fingerprints."""

import hashlib
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..core.environment.environment import Environment, build_environment
from ..core.environment.grid import Grid
from ..core.environment.regions import Region, RegionRule
from ..core.errors import ClipError, SceneError
from ..core.motion.clip import MotionClip
from ..core.motion.doctor import DoctorSettings
from ..core.motion.graph_settings import MotionGraphSettings
from ..core.motion.heading import with_steady_heading
from ..core.motion.mirror import mirrored
from ..core.progress import Progress
from .bridge.action_curves import action_curves
from .bridge.read_actions import FRAME_RATE_PROPERTY, read_clips
from .bridge.read_scene import ShapeMemory, read_triangles
from .clip_actions import character_problem
from .properties.environment import GroundSource


def fingerprint(*parts) -> str:
    """A digest of arrays, numbers and texts: equal for equal input."""
    digest = hashlib.blake2b(digest_size=16)
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(repr((part.shape, part.dtype.str)).encode())
            digest.update(np.ascontiguousarray(part))
        else:
            digest.update(repr(part).encode())
        digest.update(b";")
    return digest.hexdigest()


# ------------------------------------------------------------------------------------------------ motion


def read_character(scene) -> tuple[list[MotionClip], list[tuple[str, str]]]:
    """The clips in use, and (action name, reason) of those that cannot be read.

    Raises ClipError if the scene has no character, or no action of it is in use.
    """
    settings = scene.wayfarer
    problem = character_problem(scene)
    if problem:
        raise ClipError(f"{problem}.")
    actions = settings.used_actions()
    if not actions:
        raise ClipError(f"No action of '{settings.character.name}' is in use; refresh the clips or tick at least one.")
    return read_clips(settings.character, actions)


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
    """How the scene wants its motion graph built; ClipError if the settings contradict the character."""
    settings = scene.wayfarer
    return settings.graph.to_core(settings.contacts.to_core(settings.character))


def doctor_settings(scene) -> DoctorSettings:
    """What counts as a defect in the scene; ClipError if its feet are none of the character's."""
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


def actions_fingerprint(scene) -> str:
    """Of the character's rest pose and of the keys and tags of the actions in use, whatever they are called."""
    used = scene.wayfarer.used_actions()
    return fingerprint(_rest_fingerprint(scene), *sorted(action_fingerprint(scene, action) for action in used))


def _rest_fingerprint(scene) -> str:
    """Of the bones and the size of the character; not of its place, which changes with every walk."""
    character = scene.wayfarer.character
    if character is None:
        return ""
    bones = character.data.bones
    matrices = np.empty(16 * len(bones), dtype=np.float32)
    bones.foreach_get("matrix_local", matrices)
    scale = [f"{factor:.4g}" for factor in character.matrix_world.to_scale()]
    return fingerprint([(bone.name, bone.parent.name if bone.parent else "") for bone in bones], matrices, scale)


def action_fingerprint(scene, action) -> str:
    """Of what the scene's character plays of an action: its keys, frame range and tags, but not of its name."""
    character = scene.wayfarer.character
    if character is None:
        return ""
    try:
        curves = action_curves(character, action)
    except ClipError as error:
        return str(error)
    parts = [
        (action.use_frame_range, tuple(action.frame_range)),
        (action.get(FRAME_RATE_PROPERTY), scene.render.fps / scene.render.fps_base),
        (sorted((m.name, m.frame) for m in action.pose_markers), action.get("wayfarer_tags")),
    ]
    for place, curve in (*curves.bones.items(), *curves.placement.items()):
        keys = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
        curve.keyframe_points.foreach_get("co", keys)
        parts += [place, keys]
    return fingerprint(*parts)


# ----------------------------------------------------------------------------------------------- ground


@dataclass(frozen=True)
class SceneShapes:
    """What stands in a scene.

    Attributes
    ----------
    obstacles : (T, 3, 3) float array
        World-space triangles in metres.
    low, high : (x, y)
        Corners of the ground rectangle in metres.
    ground_height : float
        World z of the ground in metres.
    regions : tuple of (T, 3, 3) float array
        Triangles of each of the scene's regions, in their order; those without an object are left out.
    """

    obstacles: np.ndarray
    low: tuple[float, float]
    high: tuple[float, float]
    ground_height: float
    regions: tuple[np.ndarray, ...]

    @cached_property
    def fingerprint(self) -> str:
        return fingerprint(self.obstacles, self.low, self.high, self.ground_height, *self.regions)


def read_shapes(scene, depsgraph, memory: ShapeMemory | None = None) -> SceneShapes:
    """Ground, obstacles and regions of a scene as they are at its present frame.

    With a ``memory``, shapes that it knows are not read again.

    Raises SceneError if there is nothing that the ground could come from, or if a region has no faces.
    """
    settings = scene.wayfarer.environment
    others = {settings.ground, scene.wayfarer.character, *(region.object for region in settings.regions)}
    solid = [
        obj
        for obj in (settings.obstacles.all_objects if settings.obstacles else ())
        if obj not in others and obj.parent not in others - {None}
    ]
    obstacles = read_triangles(solid, depsgraph, memory)
    low, high, height = _ground(settings, obstacles, depsgraph)
    regions = []
    for region in settings.regions:
        if region.object is not None:
            triangles = read_triangles([region.object], depsgraph, memory)
            if len(triangles) == 0:
                raise SceneError(
                    f"The region '{region.object.name}' shows no faces; unhide it, give it some, or remove the region."
                )
            regions.append(triangles)
    return SceneShapes(obstacles, low, high, height, tuple(regions))


def _ground(settings, obstacles: np.ndarray, depsgraph) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Low and high corner (x, y) of the ground rectangle, and its height."""
    if settings.source is GroundSource.TYPED:
        return tuple(settings.ground_low), tuple(settings.ground_high), settings.ground_height
    if settings.source is GroundSource.OBJECT and settings.ground is not None:
        corners = _world_bounds(settings.ground, depsgraph)
        height = corners[:, 2].max()
    elif len(obstacles):
        corners = obstacles.reshape(-1, 3)
        height = corners[:, 2].min()
    else:
        raise SceneError(
            "There is no ground; choose a ground object or a collection of obstacles in the Environment panel, or type "
            "its corners in."
        )
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    return tuple(low.tolist()), tuple(high.tolist()), float(height)


def make_environment(scene, shapes: SceneShapes) -> Environment:
    """The environment that the scene's settings make of these shapes; SceneError if they make none."""
    settings = scene.wayfarer.environment
    grid = Grid.over_rectangle(shapes.low, shapes.high, settings.cell_size, settings.n_headings, settings.tiled)
    return build_environment(
        grid, shapes.obstacles, scene_regions(scene, shapes), settings.to_core(shapes.ground_height)
    )


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
    """Of everything but the shapes that an embedding depends on; what things are called makes no difference."""
    settings = scene.wayfarer
    environment = settings.environment
    regions = [(region.rule, region.tag, region.margin) for region in environment.regions if region.object is not None]
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
