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
from ..bridge.clip_actions import character_problem
from ..scene.inputs import SceneShapes, environment_settings_fingerprint
from ..session import SESSION

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class WalkNumbers:
    """Duration (s), length (m) and number of segments of a walk."""

    seconds: float = 0.0
    length: float = 0.0
    segments: int = 0


@dataclass(frozen=True)
class Summary:
    """The numbers that panels show beside a graph, an embedding and a walk; zero before there is one.

    ``coverage`` is a share of the free floor, ``outside`` are the names of obstacles that make no difference, and
    ``uneven`` are the name and the lowest and highest z (m) of a ground that is not flat.
    """

    clips: int = 0
    clips_played: int = 0
    motion_seconds: float = 0.0
    dropped_seconds: float = 0.0
    nodes: int = 0
    links: int = 0
    coverage: float = 0.0
    outside: tuple[str, ...] = ()
    uneven: tuple[str, float, float] | None = None
    walk: WalkNumbers = field(default_factory=WalkNumbers)


@dataclass(frozen=True)
class OutdatedWalk:
    """A walk that was out of date when its file was saved: nothing is known of it but why, in sentences without their
    full stops."""

    changes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class ShownMap:
    """A map that was painted: its embedding, None if that had been replaced when its file was saved, its key
    (``scene.wayfarer.map.key``), and its numbers."""

    embedding: Embedding | None
    key: str
    numbers: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ShownWalk:
    """A walk that was baked, and its numbers."""

    walk: Walk | OutdatedWalk
    numbers: WalkNumbers


@dataclass
class SceneResults:
    """The results of one scene; None where there is none (yet).

    ``made_from`` holds, for graph and embedding, the fingerprints of settings and of data that they were made from;
    ``present`` those of the data as last read; ``made_for`` the character and the actions of the graph, by session id.
    ``painted`` is the map on the floor, ``ground_height`` the world z (m) of the embedding's ground,
    ``graph_summary`` what there is to say about the graph, ``lost_links`` an embedding and the links that it lost.
    ``marked`` are what floors and walks of late show, by their mark; ``prunings`` how embeddings were pruned of late.

    ``health`` and ``contacts`` are what was found out about single actions, by name and fingerprint of the action and
    by that of the settings: whoever undoes a change finds again what was known before it. ``motions`` are how far
    actions go, by fingerprint. ``actions`` are the fingerprints of actions as last read, by name.

    ``pending`` reads results that were saved, when they are asked for first; ``problem`` says why they could not be
    read, ``unread`` are those, as they lay in the file. ``encoded`` are results as bytes, with what they were made of,
    ``stored_bytes`` their size in the file.
    """

    health: dict[tuple[str, str, str], ClipHealth] = field(default_factory=dict)
    contacts: dict[tuple[str, str], ContactShares] = field(default_factory=dict)
    motions: dict[str, ClipMotion] = field(default_factory=dict)
    actions: dict[str, str] = field(default_factory=dict)
    graph: MotionGraph | None = None
    graph_summary: GraphSummary | None = None
    embedding: Embedding | None = None
    lost_links: tuple[Embedding, LostLinks] | None = None
    painted: ShownMap | None = None
    walk: Walk | OutdatedWalk | None = None
    ground_height: float = 0.0
    made_for: tuple[int, tuple[int, ...]] = (0, ())
    made_from: dict[str, tuple[str, str]] = field(default_factory=dict)
    present: dict[str, str] = field(default_factory=dict)
    summary: Summary = field(default_factory=Summary)
    marked: dict[str, ShownMap | ShownWalk] = field(default_factory=dict)
    prunings: list[Pruning] = field(default_factory=list)
    pending: Callable[[], "SceneResults"] | None = None
    problem: str = ""
    unread: dict[str, Any] = field(default_factory=dict)
    encoded: dict[str, tuple[Any, bytes]] = field(default_factory=dict)
    stored_bytes: int = 0

    @property
    def pruning(self) -> Pruning | None:
        """The pruning that the embedding has undergone; None if there was none."""
        return next((pruning for pruning in self.prunings if pruning.pruned is self.embedding), None)

    @property
    def map_was_undone(self) -> bool:
        """True if there was a painted floor, until undo or redo took it away."""
        return self.painted is None and any(isinstance(shown, ShownMap) for shown in self.marked.values())

    @property
    def whole(self) -> Embedding | None:
        """The embedding as it was before it was pruned."""
        pruning = self.pruning
        return self.embedding if pruning is None else pruning.whole


def results(scene) -> SceneResults:
    """Return the results of a scene, empty at first."""
    found = SESSION.of(scene, SceneResults)
    if found.pending is not None:
        pending, found.pending = found.pending, None
        found = pending()
        SESSION.put(scene, found)
    return found


def has_pending(scene) -> bool:
    """Return True if results were saved with the scene that nobody has asked for yet."""
    found = SESSION.known(scene, SceneResults)
    return found is not None and found.pending is not None


def graph_of(scene) -> MotionGraph:
    """Return the motion graph of a scene, where a poll has seen that there is one; else MotionGraphError."""
    return _there(results(scene).graph, "Build the motion graph first.")


def embedding_of(scene) -> Embedding:
    """Return the embedding of a scene, where a poll has seen that there is one; else MotionGraphError."""
    return _there(results(scene).embedding, "Embed the motion graph first.")


def whole_of(scene) -> Embedding:
    """Return the embedding as it was before it was pruned, where there is one; else MotionGraphError."""
    return _there(results(scene).whole, "Embed the motion graph first.")


def embedded_graph(scene) -> MotionGraph | None:
    """Return the graph that was embedded, which what is chosen must be of; before that, the one that there is."""
    found = results(scene)
    return found.graph if found.embedding is None else found.embedding.graph


def walk_of(scene) -> Walk:
    """Return the last walk of a scene, where there is one; else MotionGraphError."""
    walk = results(scene).walk
    return _there(walk if isinstance(walk, Walk) else None, "Let the character walk first.")


def _there(result: _Result | None, remedy: str) -> _Result:
    if result is None:
        raise MotionGraphError(remedy)
    return result


def lost_links(scene) -> LostLinks | None:
    """Return the links that the scene's embedding lost, if they have been counted."""
    found = results(scene)
    if found.lost_links is None or found.lost_links[0] is not found.embedding:
        return None
    return found.lost_links[1]


def played_by(scene) -> tuple[int, tuple[int, ...]]:
    """Return the session ids of the scene's character, 0 if it cannot be used, and of the actions in use."""
    settings = scene.wayfarer
    character = 0 if character_problem(scene) else settings.character.session_uid
    return character, tuple(sorted(action.session_uid for action in settings.used_actions()))


def keep_embedding(scene, embedding: Embedding, shapes: SceneShapes) -> None:
    """Keep an embedding made in these shapes."""
    found = results(scene)
    found.embedding, found.ground_height = embedding, shapes.ground_height
    # They are large, and undo does not come back to what they were made of.
    found.prunings = []
    found.made_from["embedding"] = (environment_settings_fingerprint(scene), shapes.fingerprint)
    found.present["embedding"] = shapes.fingerprint
