"""A crowd of copies of the scene's character, each with a walk of its own."""

from collections.abc import Generator
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.errors import WalkError
from ...core.playback.crowd import Crowd, CrowdSettings, scattered_crowd_steps
from ...core.playback.walk_motion import blended_motion
from ...core.progress import Progress, portion
from ..bridge.copies import add_copy, remove_copies, remove_if_empty
from ..bridge.owned import WALK_PROPERTY
from ..bridge.rig import bind_rig
from ..bridge.write_action import walk_channels, write_clip
from ..results.store import embedding_of
from .baking import FIRST_FRAME, set_timeline
from .request import read_motion_request, read_weighting

CROWD_COLLECTION = "Wayfarer Crowd"
_ACTION_NAME = "Wayfarer Walker"
_PLANNED = 0.2
"""Share of the work after which all walks are planned."""


@dataclass(frozen=True)
class BakedCrowd:
    """A crowd, and by name the actions of its walks, which nobody plays yet."""

    crowd: Crowd
    n_wanted: int
    actions: tuple[str, ...]


def crowd_walk_steps(scene) -> Generator[Progress, None, BakedCrowd]:
    """Plan the walks that the scene asks for and bake each into an action; those go again if this is cancelled.

    WalkError if the ground has no room for so many; ClipError if their motion does not fit the character.
    """
    settings = scene.wayfarer.walk.crowd
    embedding, rng = embedding_of(scene), np.random.default_rng(settings.seed)
    n_walkers, duration, spacing = settings.n_walkers, settings.duration, settings.spacing
    weighting, request = read_weighting(scene, settings.weighting), read_motion_request(scene)
    character = scene.wayfarer.character.name
    planned = scattered_crowd_steps(embedding, n_walkers, duration, rng, CrowdSettings(spacing / 2, weighting))
    crowd = yield from portion(planned, 0.0, _PLANNED)
    if not crowd.walks:
        raise WalkError(crowd.unserved[0].reason if crowd.unserved else "Nobody found a place to start from.")
    made: list[str] = []
    try:
        binding = bind_rig(bpy.data.objects[character])
        for number, walk in enumerate(crowd.walks):
            done = _PLANNED + (1 - _PLANNED) * number / len(crowd.walks)
            yield Progress(done, f"Baking walker {number + 1} of {len(crowd.walks)}")
            name = f"{_ACTION_NAME} {number + 1:0{len(str(n_walkers))}d}"
            clip = blended_motion(walk, request, name, crowd.n_frames)
            action = write_clip(bpy.data.objects[character], clip, name, FIRST_FRAME, binding)
            action[WALK_PROPERTY] = character
            made.append(action.name)
    except BaseException:
        # Given up, or cancelled: the actions are nobody's.
        bpy.data.batch_remove([bpy.data.actions[name] for name in made])
        raise
    return BakedCrowd(crowd, n_walkers, tuple(made))


def keep_crowd(scene, baked: BakedCrowd) -> None:
    """Put the crowd into the scene, in place of an earlier one."""
    remove_copies(scene, CROWD_COLLECTION)
    crowd, settings, character = baked.crowd, scene.wayfarer.walk.crowd, scene.wayfarer.character
    walked = walk_channels(character)
    for number, name in enumerate(baked.actions, 1):
        action = bpy.data.actions[name]
        action.name = f"{_ACTION_NAME} {number:0{len(str(baked.n_wanted))}d}"
        add_copy(scene, CROWD_COLLECTION, action, f"{character.name} {action.name.rpartition(' ')[2]}", walked)
    settings.n_walking, settings.n_wanted = len(crowd.walks), baked.n_wanted
    settings.closest = crowd.closest if len(crowd.walks) > 1 else 0.0
    settings.unserved = "\n".join(unserved.reason for unserved in crowd.unserved)
    rate = scene.render.fps / scene.render.fps_base / crowd.embedding.graph.frame_rate
    set_timeline(scene, FIRST_FRAME + round((crowd.n_frames - 1) * rate))


def remove_crowd(scene) -> int:
    """Remove the crowd of the scene; return how many walkers it had."""
    settings = scene.wayfarer.walk.crowd
    for name in ("n_walking", "n_wanted", "closest", "unserved"):
        settings.property_unset(name)
    n_walkers = remove_copies(scene, CROWD_COLLECTION)
    remove_if_empty(scene, CROWD_COLLECTION)
    return n_walkers
