"""What a study can measure, by name: every quantity of :mod:`core.evaluation` that is one number."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.network import Nodes
from ..errors import EvaluationError, StudyError
from ..evaluation.ablation import Kind, Part, ablate, parts
from ..evaluation.action_coverage import action_coverage
from ..evaluation.deletion import deletable_together
from ..evaluation.detours import detours
from ..evaluation.goals import goal_at, goal_in_region, goal_with_tag
from ..evaluation.link_utility import link_utility
from ..evaluation.maneuverability import maneuverabilities, maneuverability
from ..evaluation.occupancy import Occupancy, occupancy
from ..evaluation.path_efficiency import path_efficiency
from ..evaluation.reach import time_to_reach
from ..evaluation.turn_balance import turn_balance
from ..evaluation.weak_spots import WeakSpots, WeakSpotSettings, weak_spots
from ..evaluation.why_not import lost_links
from .subject import Subject, WholeGround

Options = Mapping[str, Any]


@dataclass(frozen=True)
class Quantity:
    """A kind of number.

    Attributes
    ----------
    meaning : str
    unit : str
        As it stands behind a column's name; empty for counts and shares.
    of_ground : callable, optional
        Subject -> number, for what maps and counts tell: also on grounds in parcels.
    of_embedding : callable, optional
        (WholeGround, options) -> number, for everything else.
    options : mapping of str to type
        What may be asked for besides.
    """

    meaning: str
    unit: str = ""
    of_ground: Callable[[Subject], float] | None = None
    of_embedding: Callable[[WholeGround, Options], float] | None = None
    options: Mapping[str, type] = field(default_factory=dict)


@dataclass(frozen=True)
class Measure:
    """A quantity that a study asks for.

    Attributes
    ----------
    name : str
        Of its column.
    quantity : str
        Key of ``QUANTITIES``.
    options : mapping
    """

    name: str
    quantity: str
    options: Options = field(default_factory=dict)

    @property
    def column(self) -> str:
        """The name with its unit."""
        unit = QUANTITIES[self.quantity].unit
        return f"{self.name} ({unit})" if unit else self.name


def measured(measure: Measure, subject: Subject) -> float:
    """The number; EvaluationError and others of our own if the question has no answer."""
    quantity = QUANTITIES[measure.quantity]
    if quantity.of_ground is not None:
        return quantity.of_ground(subject)
    if quantity.of_embedding is None or not isinstance(subject, WholeGround):
        raise EvaluationError("cannot be measured on a ground in parcels; leave parcel_size out, or the measure.")
    return quantity.of_embedding(subject, measure.options)


def checked_measure(entry: object) -> Measure:
    """A measure of a study file: a name, or a table with ``measure``, perhaps ``name``, and options.

    Raises StudyError if there is no such measure or option.
    """
    table = {"measure": entry} if isinstance(entry, str) else dict(entry) if isinstance(entry, dict) else {}
    wanted = table.pop("measure", None)
    if wanted not in QUANTITIES:
        raise StudyError(f"There is no measure {wanted!r}; there are {', '.join(QUANTITIES)}.")
    name = str(table.pop("name", wanted))
    known = QUANTITIES[wanted].options
    for option, value in table.items():
        if option not in known:
            said = f"it has {', '.join(known)}" if known else "it has none"
            raise StudyError(f"The measure '{wanted}' has no option '{option}'; {said}.")
        kinds = (int, float) if known[option] is float else known[option]
        if isinstance(value, bool) or not isinstance(value, kinds):
            raise StudyError(f"The option '{option}' of the measure '{wanted}' cannot be {value!r}.")
    return Measure(name, wanted, table)


# ------------------------------------------------------------------------------------------- maps and counts


def _area(subject: Subject, cells: np.ndarray) -> float:
    return int(np.count_nonzero(cells)) * subject.cell_size**2


def _share(subject: Subject, cells: np.ndarray) -> float:
    return int(np.count_nonzero(cells)) / max(int(np.count_nonzero(subject.free)), 1)


def _task_share(subject: Subject) -> float:
    n_places = int(np.count_nonzero(subject.free)) * subject.n_headings
    return int(subject.headings[subject.free].sum()) / max(n_places, 1)


def _of_ways(reduce: Callable[[np.ndarray], Any]) -> Callable[[Subject], float]:
    def number(subject: Subject) -> float:
        ways = subject.ways[subject.ways > 0]
        return reduce(ways).item() if len(ways) else 0

    return number


# ------------------------------------------------------------------------------------------------- embeddings


def _kind(options: Options) -> Kind:
    wanted = options.get("kind", Kind.CLIP.value)
    kinds = {kind.value: kind for kind in Kind}
    if wanted not in kinds:
        raise EvaluationError(f"There are no actions of the kind '{wanted}'; there are {', '.join(kinds)}.")
    return kinds[wanted]


def _action(embedding: Embedding, options: Options) -> Part | None:
    """The tag or clip that the options name; None if they name neither."""
    for kind in (Kind.TAG, Kind.CLIP):
        if kind.value in options:
            found = {part.name: part for part in parts(embedding.graph, kind)}
            if options[kind.value] not in found:
                known = ", ".join(f"'{name}'" for name in found) or "none"
                raise EvaluationError(
                    f"The motion graph has no {kind.value} '{options[kind.value]}' (it has: {known})."
                )
            return found[options[kind.value]]
    return None


def _prompt(ground: WholeGround, options: Options) -> float:
    embedding = ground.embedding
    action = _action(embedding, options)
    if action is not None:
        return maneuverability(embedding, action).mean
    means = np.array([found.mean for found in maneuverabilities(embedding, _kind(options))])
    means = means[np.isfinite(means)]
    return float(means.mean()) if len(means) else math.nan


def _goal(embedding: Embedding, options: Options) -> Nodes:
    if "region" in options:
        return goal_in_region(embedding, options["region"])
    if "tag" in options:
        return goal_with_tag(embedding, options["tag"])
    if "position" in options:
        place = tuple(float(x) for x in options["position"])
        if len(place) != 2:
            raise EvaluationError("A position to reach is two numbers, x and y in metres.")
        return goal_at(embedding, place, float(options.get("radius", 0.0)))
    raise EvaluationError("The time to reach what? Give a region, a tag or a position.")


def _times(embedding: Embedding, options: Options) -> np.ndarray:
    return time_to_reach(embedding, _goal(embedding, options)).histogram()


def _mean_time(ground: WholeGround, options: Options) -> float:
    counts = ground.once(_times, options)
    return float(counts @ np.arange(len(counts))) / counts.sum() / ground.graph.frame_rate


def _worst_time(ground: WholeGround, options: Options) -> float:
    return (len(ground.once(_times, options)) - 1) / ground.graph.frame_rate


def _begins(embedding: Embedding, options: Options) -> np.ndarray:
    return action_coverage(embedding, _kind(options)).shares


def _efficiency(embedding: Embedding, options: Options) -> np.ndarray:
    rng = np.random.default_rng(options.get("seed", 0))
    return path_efficiency(embedding, rng, options.get("pairs", 100), options.get("goals", 20)).efficiency


def _detour(ground: WholeGround, options: Options) -> float:
    found = detours(ground.embedding, float(options.get("spacing", 1.0)))
    return float(found.mean[found.n_near > 0].mean())


def _occupancy(embedding: Embedding, options: Options) -> Occupancy:
    return occupancy(embedding)


def _weak(embedding: Embedding, options: Options) -> WeakSpots:
    area = float(options.get("min_area", WeakSpotSettings.min_area))
    return weak_spots(embedding, WeakSpotSettings(threshold=options.get("threshold", 0), min_area=area))


def _greatest_loss(ground: WholeGround, options: Options) -> float:
    return max((loss.share for loss in ablate(ground.embedding, (_kind(options),)).losses), default=0.0)


def _spare(ground: WholeGround, options: Options) -> int:
    return len(deletable_together(ground.embedding, float(options.get("allowed", 0.01)), _kind(options)).parts)


def _blocked_links(ground: WholeGround, options: Options) -> float:
    lost = lost_links(ground.embedding)
    return (lost.obstacles + lost.regions) / max(lost.possible, 1)


_GOAL = {"region": str, "tag": str, "position": list, "radius": float}
_PAIRS = {"pairs": int, "goals": int, "seed": int}

QUANTITIES: dict[str, Quantity] = {
    "nodes": Quantity("nodes of the embedding", of_ground=lambda s: s.n_nodes),
    "links": Quantity("links of the embedding", of_ground=lambda s: s.n_links),
    "segments": Quantity("segments of the motion graph", of_ground=lambda s: len(s.graph.segments)),
    "transitions": Quantity("links of the motion graph", of_ground=lambda s: len(s.graph.links)),
    "motion": Quantity("motion in the graph", "s", of_ground=lambda s: sum(g.duration for g in s.graph.segments)),
    "coverage": Quantity("share of the free floor", of_ground=lambda s: _share(s, s.covered)),
    "covered_area": Quantity("floor that can be passed", "m2", of_ground=lambda s: _area(s, s.covered)),
    "free_area": Quantity("free floor", "m2", of_ground=lambda s: _area(s, s.free)),
    "heading_coverage": Quantity("share of positions x headings over free floor", of_ground=_task_share),
    "full_area": Quantity(
        "floor that can be passed in every heading",
        "m2",
        of_ground=lambda s: _area(s, s.free & (s.headings == s.n_headings)),
    ),
    "variability": Quantity("ways through a cell, mean over those passed", of_ground=_of_ways(np.mean)),
    "median_variability": Quantity("ways through a cell, median", of_ground=_of_ways(np.median)),
    "highest_variability": Quantity("ways through the best cell", of_ground=_of_ways(np.max)),
    "total_variability": Quantity("ways through all cells", of_ground=_of_ways(np.sum)),
    "action_coverage": Quantity(
        "share of the free floor on which an action can begin, mean over the actions",
        of_embedding=lambda g, o: float(g.once(_begins, o).mean()),
        options={"kind": str},
    ),
    "least_action_coverage": Quantity(
        "the same of the action that can begin least",
        of_embedding=lambda g, o: float(g.once(_begins, o).min(initial=1.0)),
        options={"kind": str},
    ),
    "maneuverability": Quantity(
        "time until an action can begin, mean over those that can at all",
        "s",
        of_embedding=_prompt,
        options={"kind": str, "tag": str, "clip": str},
    ),
    "time_to_reach": Quantity("time to a goal, mean over all nodes", "s", of_embedding=_mean_time, options=_GOAL),
    "worst_time_to_reach": Quantity("time to a goal, longest", "s", of_embedding=_worst_time, options=_GOAL),
    "path_efficiency": Quantity(
        "quickest ways against the shortest, mean",
        of_embedding=lambda g, o: float(g.once(_efficiency, o).mean()),
        options=_PAIRS,
    ),
    "worst_path_efficiency": Quantity(
        "quickest ways against the shortest, worst",
        of_embedding=lambda g, o: float(g.once(_efficiency, o).min()),
        options=_PAIRS,
    ),
    "detour": Quantity("delay of ways to places nearby, mean", "s", of_embedding=_detour, options={"spacing": float}),
    "effective_area": Quantity(
        "floor that random walkers would use evenly",
        "m2",
        of_embedding=lambda g, o: g.once(_occupancy, o).effective_area,
    ),
    "half_time_share": Quantity(
        "share of the floor on which random walkers spend half of their time",
        of_embedding=lambda g, o: g.once(_occupancy, o).half_time_share,
    ),
    "turn_balance": Quantity("left (1) or right (-1)", of_embedding=lambda g, _: turn_balance(g.embedding).total),
    "weak_spots": Quantity(
        "connected areas that cannot be reached, or in few ways",
        of_embedding=lambda g, o: len(g.once(_weak, o).spots),
        options={"min_area": float, "threshold": int},
    ),
    "weak_area": Quantity(
        "floor of weak spots",
        "m2",
        of_embedding=lambda g, o: g.once(_weak, o).area,
        options={"min_area": float, "threshold": int},
    ),
    "idle_transitions": Quantity(
        "links of the motion graph that are never played",
        of_embedding=lambda g, _: len(link_utility(g.embedding).idle_links),
    ),
    "blocked_links": Quantity(
        "share of the one-step links that obstacles and regions block", of_embedding=_blocked_links
    ),
    "greatest_loss": Quantity(
        "share of the floor that is lost with the action that matters most",
        of_embedding=_greatest_loss,
        options={"kind": str},
    ),
    "spare_actions": Quantity(
        "actions that can all be deleted for a small share of the floor",
        of_embedding=_spare,
        options={"kind": str, "allowed": float},
    ),
}
