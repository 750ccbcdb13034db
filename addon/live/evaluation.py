"""Keeping the embedding and the map of a scene up to date, a slice of work at a time."""

import gc
import time
from collections import deque
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from statistics import median

from ...core.embedding.embedding import Embedding, EmbeddingSettings, embed_steps
from ...core.environment.environment import Environment
from ...core.errors import MotionGraphError
from ...core.evaluation.variability import coverage_share
from ...core.maps import FloorMap, MapOptions, PaintedMap
from ...core.motion.graph import MotionGraph
from ...core.progress import Progress
from ..bridge.read_scene import ShapeMemory
from ..render.floor import find_floor
from ..results.painting import paint_floor
from ..results.state import keep_embedding, results
from ..scene.inputs import SceneShapes, environment_settings_fingerprint, make_environment_steps, read_shapes

_ROUNDS = 3
"""Rounds that are remembered: one that was slow for other reasons says nothing about the next."""


@dataclass(frozen=True)
class _Wanted:
    """What the scene asks for: the same for the same map."""

    graph: int
    settings: str
    shapes: str
    map_key: str


@dataclass(frozen=True)
class _Round:
    """Everything that one round of work needs; nothing of Blender's.

    ``environment`` makes the environment; ``up_to_date`` is the embedding if that fits already and only the map is
    missing.
    """

    wanted: _Wanted
    graph: MotionGraph
    shapes: SceneShapes | None
    environment: Generator[Progress, None, Environment] | None
    settings: EmbeddingSettings
    previous: Embedding | None
    up_to_date: Embedding | None
    kind: FloorMap
    options: MapOptions
    offset: float


class LiveEvaluation:
    """The embedding and the map of one scene, following its changes.

    Tell it of changes with :meth:`change`, and call :meth:`step` until it returns True. It holds no reference to
    Blender's data between two calls. What it does is no step of undo, unless there was no floor to paint.

    ``memory`` are the shapes that are known; whoever gives it sees to it that what has changed is forgotten.

    Attributes
    ----------
    seconds : dict of str to float
        How much work the phases of the last finished round were: read, environment, embed, map, paint, and count,
        which comes after the map is shown. Time of the processor, so that a busy machine does not count.
    changed_at : float
        When the last change happened that the floor shows, by ``time.perf_counter``; 0 before the first round.
    written, drawn : float
        Seconds by the clock from that change to the colours on the floor, and to the picture that shows them. The
        latter is for whoever sees Blender draw to fill in.
    error : str
        What is wrong with the scene, if it cannot be evaluated as it is.
    """

    def __init__(self, memory: ShapeMemory | None = None):
        self.seconds: dict[str, float] = {}
        self.changed_at = self.written = self.drawn = 0.0
        self.error = ""
        self._memory = ShapeMemory() if memory is None else memory
        self._last_change = time.perf_counter()
        self._uncounted: Embedding | None = None
        self._stale, self._repaint = True, False
        self._steps: Generator[Progress, None, tuple[_Round, Embedding, PaintedMap]] | None = None
        self._spent: dict[str, float] = {}
        self._shown: tuple[_Wanted, Embedding, PaintedMap] | None = None
        self._settings = ""
        self._began_at = self._last_change
        self._latencies: deque[float] = deque(maxlen=_ROUNDS)
        self._durations: deque[float] = deque(maxlen=_ROUNDS)
        self._worked = self._step_began = 0.0

    @property
    def latency(self) -> float:
        """Seconds of work from a change to the painted map, in the median of the last rounds; 0 before the first."""
        return median(self._latencies) if self._latencies else 0.0

    @property
    def takes(self) -> float:
        """The same by the clock, on a machine that may be busy with other things, but without breaks in the work; more
        than any time before the first round, and when what is shown has been exchanged.
        """
        return median(self._durations) if self._durations and not self._repaint else inf

    @property
    def working(self) -> bool:
        """Whether a round of work has begun and not come to its end."""
        return self._steps is not None

    @property
    def painted(self) -> bool:
        """Whether the map is there, or cannot be, and nothing is left of the work but to count what it shows."""
        return self._steps is None and not self._stale

    @property
    def done(self) -> bool:
        """Whether nothing is left to do."""
        return self.painted and self._uncounted is None

    @property
    def waiting(self) -> bool:
        """Whether there was a change that the work does not know of."""
        return self._stale

    def change(self, restart: bool = True) -> None:
        """Something has changed.

        A round that has begun is given up and starts again, unless ``restart`` is False: then it comes to its end
        first, so that the map follows while changes never cease.
        """
        self._stale, self._last_change = True, time.perf_counter()
        if restart:
            self.stop()

    def forget(self) -> None:
        """Blender's data has been exchanged, by undo for example: the floor may show anything."""
        self._memory.clear()
        self._repaint = True
        self.change()

    def notice_settings(self, scene) -> bool:
        """Whether settings differ from those that were seen last: Blender does not tell of them."""
        seen = f"{environment_settings_fingerprint(scene)} {scene.wayfarer.map.key}"
        seen, self._settings = self._settings, seen
        return seen != self._settings

    def stop(self) -> None:
        """Give up the round that has begun."""
        if self._steps is not None:
            self._steps.close()
            self._steps, self._stale = None, True

    def step(self, scene, depsgraph, budget: float, map_only: bool = False) -> bool:
        """Work for about ``budget`` seconds; True when the map is as the scene wants it, or cannot be.

        It also returns when the map is painted, so that this can be shown before it is counted. With ``map_only`` the
        embedding stays as it is, whatever has changed since it was made. What is wrong with the scene is told by
        ``error``; nothing is raised for it, and what is shown stays.
        """
        self._step_began = time.perf_counter()
        until = self._step_began + budget
        try:
            with _no_search_for_cycles():
                if self.painted:
                    self._count(scene)
                elif self._steps is None:
                    self._begin(scene, depsgraph, map_only)
                while self._steps is not None:
                    try:
                        next(self._steps)
                    except StopIteration as stop:
                        self._steps = None
                        self._finish(scene, *stop.value)
                    if time.perf_counter() >= until:
                        break
        except MotionGraphError as error:
            self._steps, self.error = None, str(error)
        except BaseException:
            # Not handled here, but the round is over: nothing goes on from where it broke.
            self._steps, self._stale, self._uncounted = None, False, None
            raise
        finally:
            self._worked += time.perf_counter() - self._step_began
        return self.done

    def _begin(self, scene, depsgraph, map_only: bool) -> None:
        """Gather what the scene wants, and begin to work if it is something else than it has."""
        self._stale, self._spent, self._worked = False, {}, 0.0
        found, settings = results(scene), scene.wayfarer
        if found.graph is None or found.embedding is None:
            self.error = "Embed the motion graph first"
            return
        self._began_at = self._last_change
        started = time.thread_time()
        self.notice_settings(scene)
        made_from = found.made_from["embedding"]
        shapes = None if map_only else read_shapes(scene, depsgraph, self._memory)
        if shapes is None:
            wanted = _Wanted(id(found.graph), *made_from, settings.map.key)
        else:
            described = environment_settings_fingerprint(scene), shapes.fingerprint
            wanted = _Wanted(id(found.graph), *described, settings.map.key)
        self._spent["read"] = time.thread_time() - started
        fits = map_only or (found.embedding.graph is found.graph and made_from == (wanted.settings, wanted.shapes))
        embedding, key = found.painted or (None, "")
        painted = embedding is found.embedding and key == wanted.map_key and find_floor(scene) is not None
        self.error = ""
        if fits and painted and not self._repaint:
            return
        shown = self._shown
        # What fits may have been pruned since.
        if fits and self._repaint and shown is not None and shown[0] == wanted and shown[1] is found.embedding:
            paint_floor(scene, found.embedding, shown[2], wanted.map_key, settings.map.offset)
            self._repaint = False
            return
        task = _Round(
            wanted=wanted,
            graph=found.graph,
            shapes=shapes,
            environment=None if fits or shapes is None else make_environment_steps(scene, shapes, self._memory),
            settings=settings.embedding.to_core(),
            previous=found.whole,
            up_to_date=found.embedding if fits else None,
            kind=settings.map.kind,
            options=settings.map.to_core(),
            offset=settings.map.offset,
        )
        self._steps = self._work(task)

    def _work(self, task: _Round) -> Generator[Progress, None, tuple[_Round, Embedding, PaintedMap]]:
        embedding = task.up_to_date
        if embedding is None:
            environment = yield from self._timed("environment", task.environment)
            steps = embed_steps(task.graph, environment, task.settings, task.previous)
            embedding = yield from self._timed("embed", steps)
        painted = yield from self._timed("map", task.kind.paint_steps(embedding, task.options))
        return task, embedding, painted

    def _timed(self, phase: str, steps):
        """The same steps, with the time that they take."""
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
        found, settings = results(scene), scene.wayfarer
        if task.up_to_date is not None:
            still = found.embedding is task.up_to_date
        else:
            still = environment_settings_fingerprint(scene) == task.wanted.settings and found.graph is task.graph
        if not still:
            # Changed under the work, and nobody told us.
            self._stale = True
            return
        started = time.thread_time()
        if task.up_to_date is None and task.shapes is not None:
            keep_embedding(scene, embedding, task.shapes)
            # Later: the map does not depend on it.
            self._uncounted = embedding
        paint_floor(scene, embedding, painted, task.wanted.map_key, task.offset)
        self._shown = task.wanted, embedding, painted
        self._repaint = False
        self._spent["paint"] = time.thread_time() - started
        self._latencies.append(sum(self._spent.values()))
        now = time.perf_counter()
        self._durations.append(self._worked + now - self._step_began)
        self.written, self.changed_at = now - self._began_at, self._began_at
        self.seconds = self._spent
        if settings.map.key != task.wanted.map_key:
            self._stale = True

    def _count(self, scene) -> None:
        """Bring the numbers in the panels up to date."""
        embedding, self._uncounted = self._uncounted, None
        found = results(scene)
        if embedding is None or found.embedding is not embedding:
            return
        started = time.thread_time()
        found.summary.update(nodes=embedding.n_nodes, links=embedding.n_links, coverage=coverage_share(embedding))
        self.seconds["count"] = time.thread_time() - started


@contextmanager
def _no_search_for_cycles() -> Iterator[None]:
    """Python looks for cyclic garbage after so many new objects, at times through all that Blender and its extensions
    ever made: as long again as half the work, which leaves no cycles behind.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
