"""Files from which things were appended."""

from pathlib import Path

import bpy

from ...core.files import full_path


def forget_file(path: Path) -> None:
    """Remove what Blender keeps of a file from which things were appended, unless something is linked from it."""
    for library in list(bpy.data.libraries):
        if not library.users_id and full_path(bpy.path.abspath(library.filepath)) == full_path(path):
            bpy.data.libraries.remove(library)
