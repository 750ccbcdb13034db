"""The results of each scene, in memory: what has been computed, whatever has become of the scene since.

Results are values of the core and never refer to Blender's data: scenes are known by their session id.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ...core.embedding.embedding import Embedding
from ...core.errors import MotionGraphError
from ...core.evaluation.why_not import LostLinks
from ...core.motion.doctor import ClipHealth, ClipMotion
from ...core.motion.graph import MotionGraph
from ...core.motion.graph_summary import GraphSummary
from ...core.playback.walk import Walk
from ...core.report.contact_chart import ContactShares
from ...core.tuning.pruning import Pruning
from ..session import SESSION

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class OutdatedWalk:
    """A walk that was out of date when its file was saved: nothing is known of it but why, in sentences without their
    full stops."""

    changes: tuple[str, ...]


@dataclass
class SceneResults:
    """The results of one scene; None where there is none (yet).

    ``made_from`` holds, for graph and embedding, the fingerprints of settings and of data that they were made from;
    ``present`` those of the data as last seen; ``made_for`` the character and the actions of the graph, by session id.
    ``painted`` is the embedding whose map the floor shows, with the key of the map (``scene.wayfarer.map.key``);
    None for an embedding that was another one already when the file was saved.
    ``ground_height`` is the world z (m) of the embedding's ground. ``summary`` holds the numbers that the panels show,
    ``graph_summary`` what there is to say about the graph, ``lost_links`` an embedding and the links that it lost.
    ``marked`` are what floors and walks of late show, by their mark; ``prunings`` how embeddings were pruned of late.

    ``health`` and ``contacts`` are what was found out about single actions, by name and fingerprint of the action and
    by that of the settings: whoever undoes a change finds again what was known before it. ``motions`` are how far
    actions go, by fingerprint. ``actions`` are the fingerprints of actions as last seen, by name.

    ``pending`` reads results that were saved, when they are asked for first; ``problem`` says why they could not be
    read, ``unread`` are those, as they lay in the file. ``encoded`` are results as bytes, with what they were made of,
    ``stored_bytes`` what they take in the file.
    """

    health: dict[tuple[str, str, str], ClipHealth] = field(default_factory=dict)
    contacts: dict[tuple[str, str], ContactShares] = field(default_factory=dict)
    motions: dict[str, ClipMotion] = field(default_factory=dict)
    actions: dict[str, str] = field(default_factory=dict)
    graph: MotionGraph | None = None
    graph_summary: GraphSummary | None = None
    embedding: Embedding | None = None
    lost_links: tuple[Embedding, LostLinks] | None = None
    painted: tuple[Embedding | None, str] | None = None
    walk: Walk | OutdatedWalk | None = None
    ground_height: float = 0.0
    made_for: tuple[int, tuple[int, ...]] = (0, ())
    made_from: dict[str, tuple[str, str]] = field(default_factory=dict)
    present: dict[str, str] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)
    marked: dict[str, Any] = field(default_factory=dict)
    prunings: list[Pruning] = field(default_factory=list)
    pending: Callable[[], "SceneResults"] | None = None
    problem: str = ""
    unread: dict[str, Any] = field(default_factory=dict)
    encoded: dict[str, tuple[Any, bytes]] = field(default_factory=dict)
    stored_bytes: int = 0

    @property
    def pruning(self) -> Pruning | None:
        """How the embedding was pruned; None if it was not."""
        return next((pruning for pruning in self.prunings if pruning.pruned is self.embedding), None)

    @property
    def map_was_undone(self) -> bool:
        """Whether there was a painted floor, until undo or redo took it away."""
        return self.painted is None and not all(is_walk(shown) for shown in self.marked.values())

    @property
    def whole(self) -> Embedding | None:
        """The embedding as it was before it was pruned."""
        pruning = self.pruning
        return self.embedding if pruning is None else pruning.whole


def is_walk(shown: tuple) -> bool:
    """Whether what is marked, by what it is marked with, is a walk; else it is a floor."""
    return isinstance(shown[0], Walk | OutdatedWalk)


def results(scene) -> SceneResults:
    """Return the results of a scene, empty at first."""
    found = SESSION.of(scene, SceneResults)
    if found.pending is not None:
        pending, found.pending = found.pending, None
        found = pending()
        SESSION.put(scene, found)
    return found


def graph_of(scene) -> MotionGraph:
    """The motion graph of a scene, where a poll has seen that there is one; else MotionGraphError."""
    return _there(results(scene).graph, "Build the motion graph first.")


def embedding_of(scene) -> Embedding:
    """The embedding of a scene, where a poll has seen that there is one; else MotionGraphError."""
    return _there(results(scene).embedding, "Embed the motion graph first.")


def whole_of(scene) -> Embedding:
    """The embedding as it was before it was pruned, where there is one; else MotionGraphError."""
    return _there(results(scene).whole, "Embed the motion graph first.")


def embedded_graph(scene) -> MotionGraph | None:
    """The motion graph that was embedded, which what is chosen must be of; before that, the one that there is."""
    found = results(scene)
    return found.graph if found.embedding is None else found.embedding.graph


def walk_of(scene) -> Walk:
    """The last walk of a scene, where there is one; else MotionGraphError."""
    walk = results(scene).walk
    return _there(walk if isinstance(walk, Walk) else None, "Let the character walk first.")


def _there(result: _Result | None, remedy: str) -> _Result:
    if result is None:
        raise MotionGraphError(remedy)
    return result


def has_pending(scene) -> bool:
    """Return True if results were saved with the scene that nobody has asked for yet."""
    found = SESSION.known(scene, SceneResults)
    return found is not None and found.pending is not None


def has_results(scene) -> bool:
    """Return True if there are results of a scene, read or not yet read."""
    found = SESSION.known(scene, SceneResults)
    return found is not None and (found.pending is not None or found.graph is not None or bool(found.problem))
