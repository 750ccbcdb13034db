"""Files from which things were appended."""

from pathlib import Path

import bpy


def forget_file(path: Path) -> None:
    """Remove what Blender keeps of a file from which things were appended, unless something is linked from it."""
    for library in list(bpy.data.libraries):
        if not library.users_id and Path(bpy.path.abspath(library.filepath)).resolve() == path.resolve():
            bpy.data.libraries.remove(library)
