"""Numbers that tell how long ways take: to a goal, to the beginning of an action, and against the shortest."""

import math
from collections.abc import Callable

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.network import Nodes
from ..errors import EvaluationError
from ..evaluation.detours import Detours, detours_steps, mean_speed
from ..evaluation.goals import facing, goal_after, goal_at, goal_in_region, goal_with_tag
from ..evaluation.maneuverability import Maneuverability, maneuverabilities_steps, maneuverability_steps
from ..evaluation.path_efficiency import PathEfficiency, path_efficiency_steps
from ..evaluation.reach import ReachField, time_from_steps, time_to_reach_steps
from ..evaluation.segment_groups import Grouping, SegmentGroup, segment_groups, segments_of_clip
from ..progress import finish
from .quantity import AMOUNT, ANGLE, COUNT, KIND, LENGTH, NATURAL, POSITION, TEXT, Options, Quantity, of_whole
from .subject import WholeGround


def _actions(embedding: Embedding, options: Options) -> list[SegmentGroup]:
    """The tag or clip that the options name; all of a kind if they name neither."""
    for kind in (Grouping.TAG, Grouping.CLIP):
        if kind.value in options:
            found = {part.name: part for part in segment_groups(embedding.graph, kind)}
            if options[kind.value] not in found:
                known = ", ".join(f"'{name}'" for name in found) or "none"
                raise EvaluationError(
                    f"The motion graph has no {kind.value} '{options[kind.value]}' (it has: {known})."
                )
            return [found[options[kind.value]]]
    return []


def _prompt(embedding: Embedding, options: Options) -> list[Maneuverability]:
    """Of the action that the options name, whether it can be played or not, or of all that can be."""
    named = _actions(embedding, options)
    if named:
        return [finish(maneuverability_steps(embedding, action)) for action in named]
    return [
        found
        for found in finish(maneuverabilities_steps(embedding, Grouping(options.get("kind", Grouping.CLIP.value))))
        if math.isfinite(found.mean)
    ]


def _of_prompt(number: Callable[[Maneuverability], float], reduce: Callable[..., float]):
    def of_embedding(ground: WholeGround, options: Options) -> float:
        found = [number(action) for action in ground.once(_prompt, options)]
        return float(reduce(found)) if found else math.nan

    return of_embedding


def _goal(embedding: Embedding, options: Options) -> Nodes:
    if "region" in options:
        goal = goal_in_region(embedding, options["region"])
    elif "tag" in options:
        goal = goal_with_tag(embedding, options["tag"])
    elif "clip" in options:
        clip = options["clip"]
        goal = goal_after(embedding, segments_of_clip(embedding.graph, clip), f"the clip '{clip}'")
    else:
        x, y = map(float, options["position"])
        goal = goal_at(embedding, (x, y), float(options.get("radius", 0.0)))
    if "heading" in options:
        goal = facing(embedding, goal, float(options["heading"]), float(options.get("tolerance", 0.0)))
    return goal


def _times_to(embedding: Embedding, options: Options) -> ReachField:
    return finish(time_to_reach_steps(embedding, _goal(embedding, options)))


def _times_from(embedding: Embedding, options: Options) -> ReachField:
    return finish(time_from_steps(embedding, _goal(embedding, options)))


def _mean_time(times: Callable[[Embedding, Options], ReachField]):
    def of_embedding(ground: WholeGround, options: Options) -> float:
        counts = ground.once(times, options).histogram()
        return float(counts @ np.arange(len(counts))) / counts.sum() / ground.graph.frame_rate

    return of_embedding


def _worst_time(times: Callable[[Embedding, Options], ReachField]):
    def of_embedding(ground: WholeGround, options: Options) -> float:
        return (len(ground.once(times, options).histogram()) - 1) / ground.graph.frame_rate

    return of_embedding


def _area_within(ground: WholeGround, options: Options) -> float:
    goal = {name: value for name, value in options.items() if name != "time"}
    return ground.once(_times_to, goal).area_within(float(options.get("time", 5.0)))


def _efficiency(embedding: Embedding, options: Options) -> PathEfficiency:
    rng = np.random.default_rng(options.get("seed", 0))
    return finish(path_efficiency_steps(embedding, rng, options.get("pairs", 100), options.get("goals", 20)))


def _of_efficiency(number: Callable[[PathEfficiency], float]):
    return lambda ground, options: float(number(ground.once(_efficiency, options)))


def _detours(embedding: Embedding, options: Options) -> Detours:
    return finish(detours_steps(embedding, float(options.get("spacing", 1.0))))


def _mean_detour(ground: WholeGround, options: Options) -> float:
    found = ground.once(_detours, options)
    return float(found.mean[found.n_near > 0].mean())


def _worst_detour(ground: WholeGround, options: Options) -> float:
    found = ground.once(_detours, options)
    return float(found.worst[found.n_near > 0].max())


_ACTION = {"kind": KIND, "tag": TEXT, "clip": TEXT}
_PLACES = ("region", "tag", "clip", "position")
_GOAL = {
    "region": TEXT,
    "tag": TEXT,
    "clip": TEXT,
    "position": POSITION,
    "radius": AMOUNT,
    "heading": ANGLE,
    "tolerance": AMOUNT,
}
_GOAL_DETAILS = {"radius": "position", "tolerance": "heading"}
_PAIRS = {"pairs": COUNT, "goals": COUNT, "seed": NATURAL}


def _times_quantity(meaning: str, of_embedding: Callable[[WholeGround, Options], float]) -> Quantity:
    return of_whole(meaning, of_embedding, "s", options=_GOAL, one_of=_PLACES, details=_GOAL_DETAILS)


WAY_QUANTITIES: dict[str, Quantity] = {
    "maneuverability": of_whole(
        "time until an action can begin, mean over those that can at all",
        _of_prompt(lambda action: action.mean, np.mean),
        "s",
        options=_ACTION,
        at_most_one=tuple(_ACTION),
    ),
    "worst_maneuverability": of_whole(
        "time until an action can begin, longest",
        _of_prompt(lambda action: action.worst, max),
        "s",
        options=_ACTION,
        at_most_one=tuple(_ACTION),
    ),
    "at_once": of_whole(
        "share of the nodes from which an action can begin at once, mean over the actions",
        _of_prompt(lambda action: action.at_once, np.mean),
        options=_ACTION,
        at_most_one=tuple(_ACTION),
    ),
    "promptly": of_whole(
        "share of the nodes from which it can begin within a second",
        _of_prompt(lambda action: action.promptly, np.mean),
        options=_ACTION,
        at_most_one=tuple(_ACTION),
    ),
    "time_to_reach": _times_quantity("time to a goal, mean over all nodes", _mean_time(_times_to)),
    "worst_time_to_reach": _times_quantity("time to a goal, longest", _worst_time(_times_to)),
    "time_from": _times_quantity("time from a place, mean over all nodes", _mean_time(_times_from)),
    "worst_time_from": _times_quantity("time from a place, longest", _worst_time(_times_from)),
    "area_within": of_whole(
        "floor from which a goal is reached within a time (5 s if none is given)",
        _area_within,
        "m2",
        options={**_GOAL, "time": AMOUNT},
        one_of=_PLACES,
        details=_GOAL_DETAILS,
    ),
    "path_efficiency": of_whole(
        "shortest ways against the quickest ones, mean", _of_efficiency(lambda found: found.mean), options=_PAIRS
    ),
    "path_efficiency_error": of_whole(
        "standard error of that mean", _of_efficiency(lambda found: found.standard_error), options=_PAIRS
    ),
    "median_path_efficiency": of_whole(
        "shortest ways against the quickest ones, median",
        _of_efficiency(lambda found: float(np.median(found.efficiency))),
        options=_PAIRS,
    ),
    "worst_path_efficiency": of_whole(
        "shortest ways against the quickest ones, worst",
        _of_efficiency(lambda found: float(found.efficiency.min())),
        options=_PAIRS,
    ),
    "speed": of_whole("mean speed over all segments, one after the other", lambda g, _: mean_speed(g.graph), "m/s"),
    "detour": of_whole("delay of ways to places nearby, mean", _mean_detour, "s", options={"spacing": LENGTH}),
    "worst_detour": of_whole(
        "delay of ways to places nearby, longest", _worst_detour, "s", options={"spacing": LENGTH}
    ),
}
