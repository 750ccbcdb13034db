"""Starting the bpy module with the extension enabled, for scripts that are run by dev.py; no part of the extension."""

import os
import sys

EXTENSION = "bl_ext.user_default.wayfarer"


def enable_extension() -> None:
    """Start Blender in this process, with an empty scene; RuntimeError if its folders were not prepared."""
    if "BLENDER_USER_RESOURCES" not in os.environ:
        raise RuntimeError("Start this through dev.py, which prepares Blender's folders")
    import bpy  # the first import starts Blender

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    import addon_utils  # importable once bpy is

    def fail(error):
        raise error

    addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)


def leave(code: int) -> None:
    """End the process without Python's own ending, in which some versions of Blender hang."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
