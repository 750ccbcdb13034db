"""Advice on what is likely to disappoint, in sentences without their full stops, for panels and the command line.

Nothing here stops anybody: what cannot be done at all is an error of the core.
"""

import bpy

from ...core.wording import length, number, rough, share
from ..bridge.clip_actions import character_problem
from ..bridge.read_scene import shown_objects
from ..bridge.tags import tag_names
from ..properties.environment import REGION_TYPES
from ..scene.inputs import obstacle_objects
from ..scene.unlisted import unlisted_objects
from .staleness import embedding_changes
from .store import results

_SMALLEST = 0.4
_LARGEST = 20.0
"""Metres: characters beyond these are rather in other units."""

_NEARLY_NOTHING = 0.05
_FAR = 1.0
"""Metres between the place asked for and the nearest that the character can be at."""

_STEP = 0.1
"""Metres that the ground may lie above or below the character's origin, which is not always between its feet."""

_LOOKED_AT = 1000
"""Objects of a scene up to which panels look at each of them whenever they are drawn."""

_NAMED = 3
"""Objects named in a sentence."""


def clip_advice(scene) -> list[str]:
    """About the character and its clips."""
    settings = scene.wayfarer
    if settings.character is None:
        return []
    problem = character_problem(scene)
    if problem:
        return [problem]
    height = _height(settings.character)
    if 0 < height < _SMALLEST or height > _LARGEST:
        return [
            f"'{settings.character.name}' is {rough(height)} m tall in its rest pose, and everything here is in "
            "metres; scale its armature object to its real size"
        ]
    return []


def environment_advice(scene) -> list[str]:
    """About ground, obstacles and regions."""
    settings = scene.wayfarer.environment
    advice = []
    tags = _known_tags(scene)
    for region in settings.regions:
        if region.object is None:
            advice.append("A region has no object and makes no difference; choose one or remove the region")
        elif scene not in region.object.users_scene:
            advice.append(f"The region '{region.object.name}' is no longer in this scene; remove it or bring it back")
        elif region.tag.strip() and tags is not None and region.tag.strip() not in tags:
            outcome = {
                "REQUIRE": "nothing can be played inside it",
                "FORBID": "it forbids nothing",
                "CONFINE": "it confines nothing",
            }[region.rule]
            advice.append(
                f"The region '{region.object.name}' speaks of '{region.tag.strip()}', but no ticked clip carries that "
                f"tag: {outcome}"
            )
    ground = settings.ground if settings.ground_source == "OBJECT" else None
    if ground is not None and scene not in ground.users_scene:
        advice.append(f"The ground '{ground.name}' is no longer in this scene; choose another or bring it back")
    return advice


def unlisted_advice(scene, drawing: bool = False) -> list[str]:
    """About objects that stand on the ground, but are no obstacles; of scenes with many objects not while drawing."""
    if drawing and len(scene.objects) > _LOOKED_AT:
        return []
    names = [f"'{obj.name}'" for obj in unlisted_objects(scene)]
    if not names:
        return []
    more = f" and {number(len(names) - _NAMED)} more" if len(names) > _NAMED else ""
    verb = "stands" if len(names) == 1 else "stand"
    return [
        f"{', '.join(names[:_NAMED])}{more} {verb} on the ground, but not in the collection of obstacles, so that "
        "walks pass through; press Add to Obstacles, or hide what does not count"
    ]


def embedding_advice(scene) -> list[str]:
    """About what came of the embedding."""
    found = results(scene)
    if found.embedding is None:
        return []
    advice = []
    if found.pruning is not None:
        if found.embedding.n_nodes == 0:
            advice.append("Pruning has left nothing: keep more, or press Restore in Tuning")
    elif found.embedding.n_nodes == 0:
        advice.append("The character cannot go anywhere: no endless walk fits into this scene")
    elif found.summary.coverage < _NEARLY_NOTHING:
        advice.append(
            f"Only {share(found.summary.coverage)} of the free floor is covered; see the map Why Not, or add clips "
            "that turn, start and stop"
        )
    uneven = _uneven_advice(found)
    advice += uneven or _height_advice(scene.wayfarer.character, found.ground_height)
    advice += _hidden_advice(scene)
    outside = found.summary.outside
    if outside:
        names = ", ".join(f"'{name}'" for name in outside[:_NAMED])
        more = f" and {len(outside) - _NAMED} more" if len(outside) > _NAMED else ""
        advice.append(f"Obstacles outside the ground make no difference: {names}{more}")
    return advice


def _uneven_advice(found) -> list[str]:
    """About a ground that was not flat when it was embedded."""
    name, low, high = found.summary.uneven or ("", 0.0, 0.0)
    # Live evaluation may have seen the ground elsewhere since.
    if not name or high != found.ground_height:
        return []
    return [
        f"The ground '{name}' is not flat ({length(low)} to {length(high)}), and walks are planned on its highest "
        "point; choose a flat ground"
    ]


def _hidden_advice(scene) -> list[str]:
    """About obstacles of which none can be seen: none counts."""
    solid = []
    for obj in obstacle_objects(scene):
        if obj.type in REGION_TYPES or obj.instance_type != "NONE":
            # Panels ask at each redraw, and the first of many objects is mostly seen.
            if shown_objects([obj], bpy.context.view_layer):
                return []
            solid.append(obj)
    if not solid:
        return []
    name = scene.wayfarer.environment.obstacles.name
    none = f"None of the {number(len(solid))} objects" if len(solid) > 1 else "The only object"
    visible = "is visible" if len(solid) > 1 else "is not visible"
    return [
        f"{none} of '{name}' {visible} in this view layer, so that nothing stands in the way; show "
        f"{'them' if len(solid) > 1 else 'it'}, or choose another collection"
    ]


def _height_advice(character, ground_height: float) -> list[str]:
    """About a ground at another height (m) than the character, if there is one."""
    if character is None:
        return []
    above = ground_height - character.matrix_world.translation.z
    if abs(above) <= _STEP:
        return []
    where = "above" if above > 0 else "below"
    return [
        f"The ground is {length(abs(above))} {where} '{character.name}', and walks keep the height of the clips; "
        "move the character there and build the motion graph anew"
    ]


def stale_advice(scene) -> list[str]:
    """About an embedding that was made before something changed: what is asked of it, or walked in it, is of then."""
    changes = embedding_changes(scene)
    if not changes:
        return []
    first = changes[0][0].lower() + changes[0][1:]
    return [f"The embedding is out of date, because {first}; embed again"]


def start_advice(wanted, walk) -> str:
    """About a walk that was to start at ``wanted`` (x, y), but could not; empty if it starts near enough."""
    if wanted is None:
        return ""
    x, y = walk.root_path[0, :2]
    distance = ((x - wanted[0]) ** 2 + (y - wanted[1]) ** 2) ** 0.5
    if distance <= _FAR:
        return ""
    return f"The walk starts {length(distance)} from the place that was asked for, the nearest that can be reached"


def _known_tags(scene) -> set[str] | None:
    """Tags of the clips in use; None if there are no clips to ask."""
    actions = scene.wayfarer.used_actions()
    return {tag for action in actions for tag in tag_names(action)} if actions else None


def _height(character) -> float:
    """Metres from the lowest to the highest point of the bones at rest, along whichever axis is longest."""
    points = [point for bone in character.data.bones for point in (bone.head_local, bone.tail_local)]
    if not points:
        return 0.0
    scale = character.matrix_world.to_scale()
    return max(abs(scale[axis]) * (max(p[axis] for p in points) - min(p[axis] for p in points)) for axis in range(3))
