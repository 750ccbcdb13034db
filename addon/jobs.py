"""Work that takes long: drained at once in scripts, advanced a slice at a time by a timer in a window.

The work is a generator of the core: it yields Progress and returns its result. Input is gathered before the first
yield and the scene is changed only in :meth:`LongOperator.apply`, so that whoever cancels has changed nothing and no
reference to Blender's data is held while other things happen.
"""

import time
from collections.abc import Generator
from typing import Any, Generic, TypeVar, cast

import bpy

from ..core.errors import MotionGraphError
from ..core.progress import Progress, finish

_SLICE = 0.03
"""Seconds of work between two looks at the keyboard: short enough for the window to feel alive."""

_TICK = 0.005
"""Seconds between two timer events."""

_FAILURES = (MotionGraphError, MemoryError)
"""Errors that are reported in a sentence; everything else is a bug."""

_Result = TypeVar("_Result")


class Slices(Generic[_Result]):
    """Long work that is advanced for some seconds at a time.

    Attributes
    ----------
    progress : Progress
        The last step.
    done : bool
        True when the work has come to its end.
    """

    def __init__(self, steps: Generator[Progress, None, _Result]):
        self.progress = Progress(0.0, "")
        self.done = False
        self._steps, self._result = steps, cast(_Result, None)

    @property
    def result(self) -> _Result:
        """The outcome of work that is done."""
        return self._result

    def advance(self, seconds: float) -> bool:
        """Work for about so many seconds, one step at least; return True when the work has come to its end."""
        until = time.perf_counter() + seconds
        while not self.done:
            try:
                self.progress = next(self._steps)
            except StopIteration as stop:
                self._result, self.done = stop.value, True
            if time.perf_counter() >= until:
                break
        return self.done

    def close(self) -> None:
        """Give the work up."""
        self._steps.close()


def clock(seconds: float) -> str:
    """Elapsed time in whole seconds: "7 s", "2:05", "1:00:00"."""
    minutes, rest = divmod(int(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


class LongOperator:
    """Mixin for operators: implement ``steps`` and ``apply``."""

    bl_options = {"REGISTER", "UNDO"}

    _running = False
    """Also of one that Blender cancels before it has begun, with its file browser."""

    def steps(self, context) -> Generator[Progress, None, Any]:
        """Gather the input, then yield Progress; return what ``apply`` needs. Must not change the scene."""
        raise NotImplementedError

    def apply(self, context, result) -> None:
        """Store the result, change the scene and report the numbers."""
        raise NotImplementedError

    def execute(self, context):
        try:
            self.apply(context, finish(self.steps(context)))
        except _FAILURES as error:
            self.report({"ERROR"}, self._sentence(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, event):
        # Timers do not fire without a window.
        if bpy.app.background or context.window is None:
            return self.execute(context)
        self._work, self._running = Slices(self.steps(context)), True
        self._started = time.monotonic()
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        context.window_manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        self._shown = ""
        self._show(context, Progress(0.0, self.bl_label))
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self._stop(context)
            self.report({"INFO"}, f"{self.bl_label} cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            # The scene must not change under the work.
            return {"RUNNING_MODAL"}
        try:
            if not self._work.advance(_SLICE):
                self._show(context, self._work.progress)
                return {"RUNNING_MODAL"}
            # Before the scene changes, because that can open windows and send events of its own.
            self._stop(context)
            self.apply(context, self._work.result)
        except _FAILURES as error:
            self._stop(context)
            self.report({"ERROR"}, self._sentence(error))
            return {"CANCELLED"}
        except BaseException:
            # Not handled here, but the timer and the status text must not outlive the operator.
            self._stop(context)
            raise
        return {"FINISHED"}

    def cancel(self, context):
        """Called by Blender when it ends the operator itself, for example on opening another file."""
        self._stop(context)

    def _sentence(self, error: MotionGraphError | MemoryError) -> str:
        if isinstance(error, MotionGraphError):
            return str(error)
        return (
            f"{self.bl_label} needs more memory than there is. Use fewer or shorter clips, a smaller ground or a "
            "larger Cell Size, or close other programs."
        )

    def _show(self, context, progress: Progress) -> None:
        elapsed = clock(time.monotonic() - self._started)
        text = f"{progress.message}: {100 * progress.fraction:.0f}%    {elapsed}    Esc to cancel"
        # Every change makes the window redraw, which can take longer than the slice of work.
        if text != self._shown:
            self._shown = text
            context.window_manager.progress_update(round(100 * progress.fraction))
            context.workspace.status_text_set(text)

    def _stop(self, context) -> None:
        if not self._running:
            return
        self._running = False
        self._work.close()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        for area in context.screen.areas:
            area.tag_redraw()
