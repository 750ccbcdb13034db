"""Let the character walk at random and bake the walk into an action."""

import bpy
import numpy as np

from ...core.errors import WalkError
from ...core.playback.synthesis import synthesize
from ...core.playback.walk import nearest_node, random_walk
from ...core.playback.wandering import wandering_walk_steps
from ...core.progress import Progress, portion
from ..bridge.write_action import assign_action, write_clip
from ..clip_actions import WALK_PROPERTY
from ..jobs import LongOperator
from ..properties import WalkStart, WalkStyle
from ..render.walk_curve import walk_curve
from ..scene_collections import OUTPUT, ensure_collection
from ..state import results

_NAME = "Wayfarer Walk"
_FIRST_FRAME = 1
_MARKER = "Walk: "
"""Start of the names of timeline markers, by which those of an earlier walk are known."""


class WAYFARER_OT_random_walk(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.random_walk"
    bl_label = "Random Walk"
    bl_description = "Walk at random through the scene and bake the motion into an action of the character"

    @classmethod
    def poll(cls, context):
        embedding = results(context.scene).embedding
        if context.scene.wayfarer.character is None:
            cls.poll_message_set("Choose a character first")
        elif embedding is None:
            cls.poll_message_set("Embed the motion graph first")
        elif embedding.n_nodes == 0:
            cls.poll_message_set("The character cannot go anywhere in this scene; the embedding is empty")
        else:
            return True
        return False

    def steps(self, context):
        settings = context.scene.wayfarer.walk
        embedding, rng = results(context.scene).embedding, np.random.default_rng(settings.seed)
        position, duration, style = _start_position(context), settings.duration, WalkStyle[settings.style]
        yield Progress(0.1, "Finding a start")
        start = None if position is None else nearest_node(embedding, position, rng)
        if style is WalkStyle.WANDER:
            walk = yield from portion(wandering_walk_steps(embedding, rng, duration, start), 0.2, 0.4)
        else:
            yield Progress(0.2, "Walking")
            walk = random_walk(embedding, rng, duration, start)
        yield Progress(0.4, "Blending segments")
        clip = synthesize(walk, name=_NAME)
        yield Progress(0.8, "Baking the action")
        return walk, clip

    def apply(self, context, result):
        walk, clip = result
        scene, found = context.scene, results(context.scene)
        character = scene.wayfarer.character
        action = write_clip(character, clip, clip.name, _FIRST_FRAME)
        for earlier in [action for action in bpy.data.actions if action.get(WALK_PROPERTY) == character.name]:
            if not _is_kept(earlier, character):
                bpy.data.actions.remove(earlier)
        action.name = clip.name
        action[WALK_PROPERTY] = character.name
        assign_action(character, action)
        collection = ensure_collection(scene, OUTPUT)
        walk_curve(walk.root_path, found.ground_height, collection)
        _set_timeline(scene, action, walk, scene.wayfarer.walk.use_markers)

        found.walk = walk
        length = float(np.linalg.norm(np.diff(walk.root_path[:, :2], axis=0), axis=1).sum())
        found.summary.update(walk_seconds=walk.duration, walk_segments=len(walk), walk_length=length)
        self.report({"INFO"}, f"{walk.duration:.1f} s, {length:.1f} m, {len(walk)} segments")


def _is_kept(action, character) -> bool:
    """Whether the artist has use for an earlier walk: a fake user, another name, or users beside the character."""
    assigned = character.animation_data is not None and character.animation_data.action == action
    return action.use_fake_user or not action.name.startswith(_NAME) or action.users > int(assigned)


def _start_position(context) -> tuple[float, float] | None:
    """World x, y where the walk should start; None for anywhere."""
    start = WalkStart[context.scene.wayfarer.walk.start]
    if start is WalkStart.RANDOM:
        return None
    if start is WalkStart.CURSOR:
        return tuple(context.scene.cursor.location.xy)
    if context.active_object is None:
        raise WalkError("There is no active object to start at; select one, or start at random.")
    return tuple(context.active_object.matrix_world.translation.xy)


def _set_timeline(scene, action, walk, use_markers: bool) -> None:
    """Play exactly the walk; mark its seams if asked to."""
    scene.frame_start, scene.frame_end = _FIRST_FRAME, int(np.ceil(action.frame_range[1]))
    scene.frame_set(_FIRST_FRAME)
    for marker in [marker for marker in scene.timeline_markers if marker.name.startswith(_MARKER)]:
        scene.timeline_markers.remove(marker)
    if not use_markers:
        return
    graph = walk.embedding.graph
    frames_per_sample = scene.render.fps / scene.render.fps_base / graph.frame_rate
    for seam, segment in zip(walk.seams[:-1], walk.segments, strict=True):
        name = graph.clips[graph.segments[segment].clip].name
        frame = _FIRST_FRAME + round(float(seam) * frames_per_sample)
        scene.timeline_markers.new(_MARKER + name, frame=frame)
