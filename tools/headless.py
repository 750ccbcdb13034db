"""Starting the bpy module with the extension enabled, for scripts that are run by dev.py; no part of the extension."""

import importlib
import os
import re
import sys
from pathlib import Path

EXTENSION = "bl_ext.user_default.wayfarer"


class ScriptError(Exception):
    """What stops a script, as a sentence for the person at the keyboard."""


def prepare_folder(folder: Path) -> None:
    """Make the folder that a script writes to; ScriptError if it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ScriptError(f"The folder '{folder}' cannot be made: {error.strerror}.") from None


def start_blender(command: str) -> None:
    """As :func:`enable_extension`; ScriptError names the command that prepares Blender's folders."""
    try:
        enable_extension()
    except RuntimeError as error:
        raise ScriptError(f"{error}: {command}") from None


def run_steps(module: str, *arguments):
    """Call ``run`` of a module of the started extension; what is wrong with the input becomes a ScriptError."""
    # Only now: these modules need bpy, and the name that the extension has in it.
    steps = importlib.import_module(f"{EXTENSION}.tools.{module}")
    errors = importlib.import_module(f"{EXTENSION}.core.errors")
    try:
        return steps.run(*arguments)
    except errors.MotionGraphError as error:
        raise ScriptError(str(error)) from None
    except RuntimeError as error:
        # An operator that reports an error, or cannot start, raises it in Python with the sentence at the end.
        raise ScriptError(re.split(r"Error: |poll\(\) ", str(error).strip())[-1]) from None


def enable_extension() -> None:
    """Start Blender in this process, with an empty scene; RuntimeError if its folders were not prepared."""
    if "BLENDER_USER_RESOURCES" not in os.environ:
        raise RuntimeError("Start this through dev.py, which prepares Blender's folders")
    import bpy  # the first import starts Blender

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    import addon_utils  # importable once bpy is

    def fail(*errors):
        raise errors[0]

    addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)


def leave(code: int) -> None:
    """End the process without Python's own ending, in which some versions of Blender hang."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
