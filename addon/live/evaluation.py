"""Keeping the embedding and the map of a scene up to date, a slice of work at a time."""

import gc
import time
from collections import deque
from collections.abc import Generator
from dataclasses import dataclass, replace
from math import inf
from statistics import median

from ...core.embedding.embedding import Embedding, EmbeddingSettings, embed_steps
from ...core.environment.environment import Environment
from ...core.errors import MotionGraphError
from ...core.evaluation.variability import coverage_share
from ...core.maps import FloorMap, MapOptions, PaintedMap
from ...core.motion.graph import MotionGraph
from ...core.progress import Progress
from ..jobs import Slices
from ..render.floor import find_floor
from ..results.shown import paint_floor
from ..results.store import keep_embedding, results
from ..scene.changes import shape_memory
from ..scene.inputs import SceneShapes, environment_settings_fingerprint, make_environment_steps, read_shapes

_ROUNDS = 3
"""Rounds that are remembered: one that was slow for other reasons says nothing about the next."""


@dataclass(frozen=True)
class _Round:
    """Everything that one round of work needs; nothing of Blender's.

    ``environment`` makes the environment; ``up_to_date`` is the embedding if that fits already and only the map is
    missing.
    """

    graph: MotionGraph
    shapes: SceneShapes | None
    environment: Generator[Progress, None, Environment] | None
    settings_seen: str
    settings: EmbeddingSettings
    previous: Embedding | None
    up_to_date: Embedding | None
    kind: FloorMap
    options: MapOptions
    map_key: str
    offset: float


class LiveEvaluation:
    """The embedding and the map of one scene, following its changes.

    Call :meth:`change` for each change, and :meth:`step` until it returns True. No reference to Blender's data is held
    between two calls. What is done is no step of undo, unless there was no floor to paint.

    Attributes
    ----------
    seconds : dict of str to float
        Work of the phases of the last finished round: read, environment, embed, map, paint, and count, which comes
        after the map is shown. Time of the processor, so that a busy machine does not count.
    changed_at : float
        The moment of the last change that the floor shows, by ``time.perf_counter``; 0 before the first round.
    written, drawn : float
        Seconds by the clock from that change to the colours on the floor, and to the picture that shows them.
    error : str
        What is wrong with the scene, if it cannot be evaluated as it is.
    last_change, left : float
        The moments of the last change, and of the end of the last piece of work.
    wants_map : bool
        True if the map is to be painted once although live evaluation is switched off.
    """

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self.changed_at = self.written = self.drawn = self.left = 0.0
        self.error = ""
        self.last_change = self._began_at = time.perf_counter()
        self.wants_map = False
        self._uncounted: Embedding | None = None
        self._stale, self._repaint, self._undrawn = True, False, False
        self._work: Slices[tuple[_Round, Embedding, PaintedMap]] | None = None
        self._spent: dict[str, float] = {}
        self._settings = ""
        self._latencies: deque[float] = deque(maxlen=_ROUNDS)

    @property
    def latency(self) -> float:
        """Seconds of work from a change to the painted map, in the median of the last rounds; 0 before the first."""
        return median(self._latencies) if self._latencies else 0.0

    @property
    def takes(self) -> float:
        """Seconds that the next round is known to take at most: infinity before the first round, and when what is
        shown has been exchanged.
        """
        return self.latency if self._latencies and not self._repaint else inf

    @property
    def working(self) -> bool:
        """True while a round of work has begun and not come to its end."""
        return self._work is not None

    @property
    def painted(self) -> bool:
        """True if the map is there, or cannot be, and nothing is left of the work but to count what it shows."""
        return self._work is None and not self._stale

    @property
    def done(self) -> bool:
        """True if nothing is left to do."""
        return self.painted and self._uncounted is None

    def change(self, restart: bool = True) -> None:
        """Note that something has changed.

        A round that has begun is given up and starts again, unless ``restart`` is False: then it comes to its end
        first, so that the map follows while changes never cease.
        """
        self._stale, self.last_change = True, time.perf_counter()
        if restart:
            self.stop()

    def forget(self) -> None:
        """Note that undo or redo has exchanged Blender's data: the floor may show anything."""
        self._repaint = True
        self.change()

    def note_picture(self) -> None:
        """Note that Blender has drawn, the first time after the floor was painted."""
        if self._undrawn:
            self._undrawn, self.drawn = False, time.perf_counter() - self.changed_at

    def notice_settings(self, scene) -> bool:
        """Return True if settings differ from those seen last, of whose changes Blender does not notify anybody."""
        seen = f"{environment_settings_fingerprint(scene)} {scene.wayfarer.map.key}"
        seen, self._settings = self._settings, seen
        return seen != self._settings

    def stop(self) -> None:
        """Give up the round that has begun."""
        if self._work is not None:
            self._work.close()
            self._work, self._stale = None, True

    def step(self, scene, depsgraph, budget: float, map_only: bool = False) -> bool:
        """Work for about ``budget`` seconds; return True when the map is as the scene wants it, or cannot be.

        It also returns when the map is painted, so that this can be shown before it is counted. With ``map_only`` the
        embedding stays as it is, whatever has changed since it was made. What is wrong with the scene is in ``error``;
        nothing is raised for it, and what is shown stays.
        """
        until = time.perf_counter() + budget
        # The search for cyclic garbage goes through all that Blender and its extensions ever made, which takes half as
        # long as the work, and the work leaves no cycles behind.
        collects = gc.isenabled()
        gc.disable()
        try:
            if self.painted:
                self._count(scene)
            elif self._work is None:
                self._begin(scene, depsgraph, map_only)
            if self._work is not None and self._work.advance(until - time.perf_counter()):
                done, self._work = self._work.result, None
                self._finish(scene, *done)
        except MotionGraphError as error:
            self._work, self.error = None, str(error)
        except BaseException:
            # Not handled here, but the round is over: nothing goes on from where it broke.
            self._work, self._stale, self._uncounted = None, False, None
            raise
        finally:
            if collects:
                gc.enable()
            self.left = time.perf_counter()
        return self.done

    def _begin(self, scene, depsgraph, map_only: bool) -> None:
        """Gather what the scene wants, and begin to work if it is something else than it has."""
        self._stale, self._spent, self.error = False, {}, ""
        found, settings, memory = results(scene), scene.wayfarer, shape_memory(scene)
        if found.graph is None or found.embedding is None:
            self.error = "Embed the motion graph first"
            return
        self._began_at = self.last_change
        started = time.thread_time()
        self.notice_settings(scene)
        described, shapes = found.made_from["embedding"], None
        if not map_only:
            shapes = read_shapes(scene, depsgraph, memory)
            described = environment_settings_fingerprint(scene), shapes.fingerprint
        self._spent["read"] = time.thread_time() - started
        fits = map_only or (found.embedding.graph is found.graph and found.made_from["embedding"] == described)
        shown = found.painted
        is_painted = shown is not None and shown.embedding is found.embedding and shown.key == settings.map.key
        if fits and is_painted and find_floor(scene) is not None and not self._repaint:
            return
        task = _Round(
            graph=found.graph,
            shapes=shapes,
            environment=None if fits or shapes is None else make_environment_steps(scene, shapes, memory),
            settings_seen=described[0],
            settings=settings.embedding.to_core(),
            previous=found.whole,
            up_to_date=found.embedding if fits else None,
            kind=settings.map.kind,
            options=settings.map.to_core(),
            map_key=settings.map.key,
            offset=settings.map.offset,
        )
        self._work = Slices(self._steps(task))

    def _steps(self, task: _Round) -> Generator[Progress, None, tuple[_Round, Embedding, PaintedMap]]:
        embedding = task.up_to_date
        if embedding is None:
            environment = yield from self._timed("environment", task.environment)
            steps = embed_steps(task.graph, environment, task.settings, task.previous)
            embedding = yield from self._timed("embed", steps)
        painted = yield from self._timed("map", task.kind.paint_steps(embedding, task.options))
        return task, embedding, painted

    def _timed(self, phase: str, steps):
        """Yield from the steps of a phase, and add up the time that they take."""
        while True:
            started = time.thread_time()
            try:
                progress = next(steps)
            except StopIteration as stop:
                return stop.value
            finally:
                self._spent[phase] = self._spent.get(phase, 0.0) + time.thread_time() - started
            yield progress

    def _finish(self, scene, task: _Round, embedding: Embedding, painted: PaintedMap) -> None:
        found = results(scene)
        if task.up_to_date is not None:
            still = found.embedding is task.up_to_date
        else:
            still = environment_settings_fingerprint(scene) == task.settings_seen and found.graph is task.graph
        if not still:
            # Changed under the work, without a call of change.
            self._stale = True
            return
        started = time.thread_time()
        if task.up_to_date is None and task.shapes is not None:
            keep_embedding(scene, embedding, task.shapes)
            # Later: the map does not depend on it.
            self._uncounted = embedding
        paint_floor(scene, embedding, painted, task.map_key, task.offset)
        self._repaint, self._undrawn = False, True
        self._spent["paint"] = time.thread_time() - started
        self._latencies.append(sum(self._spent.values()))
        self.written, self.changed_at = time.perf_counter() - self._began_at, self._began_at
        self.seconds = self._spent
        if scene.wayfarer.map.key != task.map_key:
            self._stale = True

    def _count(self, scene) -> None:
        """Bring the numbers in the panels up to date."""
        embedding, self._uncounted = self._uncounted, None
        found = results(scene)
        if embedding is None or found.embedding is not embedding:
            return
        started = time.thread_time()
        nodes, links, share = embedding.n_nodes, embedding.n_links, coverage_share(embedding)
        found.summary = replace(found.summary, nodes=nodes, links=links, coverage=share)
        self.seconds["count"] = time.thread_time() - started
