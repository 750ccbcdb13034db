"""Run a tool inside the bpy module, with the extension enabled for real: run.py demo|reproduce|command ARGUMENTS.

``dev.py`` arranges the folders that Blender needs. Exit code 1 and one sentence if something is wrong with the input.
"""

import contextlib
import importlib
import os
import re
import sys
import tempfile
import time
from pathlib import Path

EXTENSION = "bl_ext.user_default.wayfarer"


class Journal:
    """Runs steps, says on the terminal what happens, and keeps the seconds that each step took."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    def run(self, step: str, label: str, work, *arguments, **options):
        print(f"{label:<34}", end="", flush=True)
        start = time.perf_counter()
        try:
            result = quietly(work, *arguments, **options)
        except BaseException:
            print(flush=True)
            raise
        self._note(step, time.perf_counter() - start)
        return result

    def note(self, step: str, label: str, seconds: float) -> None:
        """Note a step that has been taken before."""
        print(f"{label:<34}", end="")
        self._note(step, seconds)

    def _note(self, step: str, seconds: float) -> None:
        self.seconds[step] = self.seconds.get(step, 0.0) + seconds
        print(f"{seconds:6.1f} s", flush=True)


def quietly(work, *arguments, **options):
    """Run without the lines that Blender and its drivers print; they are shown if the work fails unexpectedly."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = os.dup(1), os.dup(2)
    with tempfile.TemporaryFile() as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
        shown = False
        try:
            return work(*arguments, **options)
        except BaseException as error:
            # If the input is at fault, the sentence says how: no need for more.
            shown = not is_about_input(error)
            raise
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, number)
                os.close(copy)
            if shown:
                sink.seek(0)
                sys.stderr.buffer.write(sink.read())


def is_about_input(error: BaseException) -> bool:
    """Return True for what operators and the core report about their input."""
    errors = sys.modules.get(f"{EXTENSION}.core.errors")
    return isinstance(error, RuntimeError) or (errors is not None and isinstance(error, errors.MotionGraphError))


def enable_extension() -> None:
    """Start Blender in this process, with an empty scene; RuntimeError if its folders were not prepared."""
    if "BLENDER_USER_RESOURCES" not in os.environ:
        raise RuntimeError("Start this through dev.py, which prepares Blender's folders.")
    import bpy  # the first import starts Blender

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    import addon_utils  # importable once bpy is

    def fail(*errors):
        raise errors[0]

    addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)


def run_command(words: list[str]) -> int:
    """Run a command of the command line: [SCENE.blend] -- COMMAND ..."""
    blend = Path(words.pop(0)) if words[:1] and words[0] != "--" else None
    for number in (1, 2):
        try:
            os.fstat(number)
        except OSError:
            # Blender must not open its files in the place of a stream that is closed.
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)
    # Starting Blender says things on standard output that nobody asked for.
    kept = os.dup(1)
    os.dup2(2, 1)
    enable_extension()
    command = importlib.import_module(f"{EXTENSION}.addon.cli.command")
    os.dup2(kept, 1)
    return command.run(words[1:] if words[:1] == ["--"] else words, blend)


def run_tool(name: str, words: list[str]) -> int:
    """Run a module of this folder: its ``main`` gets the words, a journal and the seconds that Blender's start took."""
    try:
        start = time.perf_counter()
        enable_extension()
        tool = importlib.import_module(f"{EXTENSION}.tools.{name}")
        tool.main(words, Journal(), time.perf_counter() - start)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 2
    except Exception as error:
        if not is_about_input(error):
            raise
        # An operator that reports an error, or cannot start, raises it in Python with the sentence at the end.
        sentence = re.split(r"Error: |poll\(\) ", str(error).strip())[-1]
        print(f"{name}: {sentence}", file=sys.stderr, flush=True)
        return 1
    return 0


def leave(code: int) -> None:
    """End the process without Python's own ending, in which some versions of Blender hang."""
    for stream in (sys.stdout, sys.stderr):
        # One that is closed is None; of one that cannot be written to has been told.
        with contextlib.suppress(OSError):
            if stream is not None:
                stream.flush()
    os._exit(code)


if __name__ == "__main__":
    tool, *rest = sys.argv[1:]
    leave(run_command(rest) if tool == "command" else run_tool(tool, rest))
