"""Numbers that only a whole embedding tells: of its actions, places and links."""

from collections.abc import Callable

import numpy as np

from ..embedding.embedding import Embedding
from ..evaluation.ablation import Ablation, Verdict, ablate_steps
from ..evaluation.action_coverage import ActionCoverage, action_coverage
from ..evaluation.capture.director import CaptureAdvice, direct_capture_steps
from ..evaluation.deletion import JointDeletion, deletable_together_steps
from ..evaluation.link_utility import LinkUtility, link_utility
from ..evaluation.occupancy import Occupancy, occupancy_steps
from ..evaluation.segment_groups import Grouping
from ..evaluation.turn_balance import TurnBalance, turn_balance
from ..evaluation.weak_spots import Domain, WeakSpots, WeakSpotSettings, weak_spots_steps
from ..evaluation.why_not import LostLinks, Reason, lost_links_steps, why_not_steps
from ..progress import finish
from .quantity import AMOUNT, KIND, NATURAL, SHARE, Option, Options, Quantity, of_whole
from .subject import WholeGround

# ------------------------------------------------------------------------------------------------------ actions


def _kind(options: Options) -> Grouping:
    return Grouping(options.get("kind", Grouping.CLIP.value))


def _begins(embedding: Embedding, options: Options) -> ActionCoverage:
    return action_coverage(embedding, _kind(options))


def _losses(embedding: Embedding, options: Options) -> Ablation:
    return finish(ablate_steps(embedding, (_kind(options),)))


def _judged(ground: WholeGround, options: Options) -> int:
    kind = {name: value for name, value in options.items() if name == "kind"}
    verdict = Verdict[options["verdict"].upper()]
    return sum(loss.verdict is verdict for loss in ground.once(_losses, kind).losses)


def _spare(embedding: Embedding, options: Options) -> JointDeletion:
    return finish(deletable_together_steps(embedding, float(options.get("allowed", 0.01)), _kind(options)))


def _advice(embedding: Embedding, options: Options) -> CaptureAdvice:
    return finish(direct_capture_steps(embedding))


# -------------------------------------------------------------------------------------------------------- places


def _occupancy(embedding: Embedding, options: Options) -> Occupancy:
    return finish(occupancy_steps(embedding))


def _of_occupancy(number: Callable[[Occupancy], float]):
    return lambda ground, options: number(ground.once(_occupancy, options))


def _weak(embedding: Embedding, options: Options) -> WeakSpots:
    return finish(
        weak_spots_steps(
            embedding,
            WeakSpotSettings(
                domain=Domain[options.get("domain", Domain.FLOOR.name.lower()).upper()],
                threshold=options.get("threshold", 0),
                min_area=float(options.get("min_area", WeakSpotSettings.min_area)),
            ),
        )
    )


def _reasons(embedding: Embedding, options: Options) -> np.ndarray:
    return np.bincount(finish(why_not_steps(embedding)).ravel(), minlength=len(Reason))


def _of_reason(ground: WholeGround, options: Options) -> float:
    counts, wanted = ground.once(_reasons, {}), options.get("reason")
    n_places = int(np.count_nonzero(ground.free)) * ground.n_headings
    # All that is embedded lies on the free floor; what can only be crossed does not, and counts only if asked for.
    n_missing = counts[Reason[wanted.upper()]] if wanted else n_places - counts[Reason.EMBEDDED]
    return int(n_missing) / max(n_places, 1)


# --------------------------------------------------------------------------------------------------------- links


def _turns(embedding: Embedding, options: Options) -> TurnBalance:
    return turn_balance(embedding)


def _lost(embedding: Embedding, options: Options) -> LostLinks:
    return finish(lost_links_steps(embedding))


def _of_lost(number: Callable[[LostLinks], float]):
    return lambda ground, options: number(ground.once(_lost, options))


def _utility(embedding: Embedding, options: Options) -> LinkUtility:
    return link_utility(embedding)


def _of_utility(number: Callable[[LinkUtility], float]):
    return lambda ground, options: number(ground.once(_utility, options))


def _greatest_share(hanging: np.ndarray, n_nodes: int) -> float:
    return int(hanging.max(initial=0)) / max(n_nodes, 1)


_KIND = {"kind": KIND}
_DOMAINS = [domain.name.lower() for domain in Domain]
_SPOTS = {
    "min_area": AMOUNT,
    "threshold": NATURAL,
    "domain": Option(" or ".join(map(repr, _DOMAINS)), lambda value: value in _DOMAINS),
}
_REASONS = [reason.name.lower() for reason in Reason if reason not in (Reason.EMBEDDED, Reason.BLOCKED)]
_REASON = Option(f"one of {', '.join(_REASONS)}", lambda value: value in _REASONS)


_VERDICTS = [verdict.name.lower() for verdict in Verdict]
_VERDICT = Option(f"one of {', '.join(_VERDICTS)}", lambda value: value in _VERDICTS)

EMBEDDING_QUANTITIES: dict[str, Quantity] = {
    "action_coverage": of_whole(
        "share of the free floor on which an action can begin, mean over the actions",
        lambda g, o: float(g.once(_begins, o).shares.mean()),
        options=_KIND,
    ),
    "least_action_coverage": of_whole(
        "the same of the action that can begin least",
        lambda g, o: float(g.once(_begins, o).shares.min(initial=1.0)),
        options=_KIND,
    ),
    "idle_actions": of_whole(
        "actions that can begin nowhere",
        lambda g, o: int(np.count_nonzero(g.once(_begins, o).areas == 0)),
        options=_KIND,
    ),
    "visited_area": of_whole("floor that random walkers pass", _of_occupancy(lambda found: found.visited_area), "m2"),
    "effective_area": of_whole(
        "floor that random walkers would use evenly", _of_occupancy(lambda found: found.effective_area), "m2"
    ),
    "half_time_share": of_whole(
        "share of the floor on which random walkers spend half of their time",
        _of_occupancy(lambda found: found.half_time_share),
    ),
    "crowding": of_whole(
        "time spent at the busiest place, times the mean over the floor passed",
        _of_occupancy(lambda found: float(found.density.max()) * found.visited_area),
    ),
    "turn_balance": of_whole("left (1) or right (-1)", lambda g, o: g.once(_turns, o).total),
    "left_links": of_whole("links that turn left", lambda g, o: g.once(_turns, o).n_left),
    "right_links": of_whole("links that turn right", lambda g, o: g.once(_turns, o).n_right),
    "straight_links": of_whole("links that do not turn", lambda g, o: g.once(_turns, o).n_straight),
    "weak_spots": of_whole(
        "connected areas that cannot be reached, or in few ways",
        lambda g, o: len(g.once(_weak, o).spots),
        options=_SPOTS,
    ),
    "weak_area": of_whole("floor of weak spots", lambda g, o: g.once(_weak, o).area, "m2", options=_SPOTS),
    "largest_weak_area": of_whole(
        "floor of the largest weak spot",
        lambda g, o: max((spot.area for spot in g.once(_weak, o).spots), default=0.0),
        "m2",
        options=_SPOTS,
    ),
    "missing": of_whole(
        "positions x headings not in the embedding, for any reason or one, against those of the free floor",
        _of_reason,
        options={"reason": _REASON},
    ),
    "idle_transitions": of_whole(
        "links of the motion graph that are never played", _of_utility(lambda found: len(found.idle_links))
    ),
    "spare_transitions": of_whole(
        "links of the motion graph without which no node dies at once",
        _of_utility(lambda found: int(np.count_nonzero(found.link_dependents == 0))),
    ),
    "vital_transition": of_whole(
        "share of the nodes that die at once without the link of the motion graph that most hangs on",
        _of_utility(lambda found: _greatest_share(found.link_dependents, found.n_nodes)),
    ),
    "vital_segment": of_whole(
        "share of the nodes that die at once without the segment that most hangs on",
        _of_utility(lambda found: _greatest_share(found.segment_dependents, found.n_nodes)),
    ),
    "possible_links": of_whole("one-step links of an empty ground", _of_lost(lambda found: found.possible)),
    "obstacle_links": of_whole("one-step links that obstacles block", _of_lost(lambda found: found.obstacles)),
    "region_links": of_whole("one-step links that regions forbid", _of_lost(lambda found: found.regions)),
    "free_links": of_whole("one-step links that are left", _of_lost(lambda found: found.free)),
    "blocked_links": of_whole(
        "share of the one-step links that obstacles and regions block",
        _of_lost(lambda found: (found.obstacles + found.regions) / max(found.possible, 1)),
    ),
    "greatest_loss": of_whole(
        "share of the floor that is lost with the action that matters most",
        lambda g, o: max((loss.share for loss in g.once(_losses, o).losses), default=0.0),
        options=_KIND,
    ),
    "greatest_places_loss": of_whole(
        "share of the positions x headings that is lost with one action, at most",
        lambda g, o: max((loss.places_share for loss in g.once(_losses, o).losses), default=0.0),
        options=_KIND,
    ),
    "judged_actions": of_whole(
        "actions of which a verdict says how much hangs on each by itself",
        _judged,
        options={"verdict": _VERDICT, "kind": KIND},
        one_of=("verdict",),
    ),
    "spare_actions": of_whole(
        "actions that can all be deleted for a small share of the floor",
        lambda g, o: len(g.once(_spare, o).groups),
        options={"kind": KIND, "allowed": SHARE},
    ),
    "spare_loss": of_whole(
        "share of the floor that is lost without all of these",
        lambda g, o: g.once(_spare, o).share,
        options={"kind": KIND, "allowed": SHARE},
    ),
    "spare_places_loss": of_whole(
        "share of the positions x headings that is lost without them",
        lambda g, o: g.once(_spare, o).places_share,
        options={"kind": KIND, "allowed": SHARE},
    ),
    "capture_area": of_whole(
        "floor that the one motion to capture next would open",
        lambda g, o: max((gain.floor for gain in g.once(_advice, o).gains), default=0.0),
        "m2",
    ),
    "capture_places": of_whole(
        "positions x headings that it would open at most",
        lambda g, o: max((gain.places for gain in g.once(_advice, o).gains), default=0),
    ),
    "capture_motions": of_whole(
        "motions of those tried that would open any floor",
        lambda g, o: sum(gain.floor > 0 for gain in g.once(_advice, o).gains),
    ),
}
