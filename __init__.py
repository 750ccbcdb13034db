"""Wayfarer, the Blender extension.

The imports stand inside the two functions, so that importing this package, as test runners and packagers
do, needs no Blender.
"""


def register():
    """Called by Blender when the extension is enabled."""
    from . import addon

    addon.register()


def unregister():
    """Called by Blender when the extension is disabled."""
    from . import addon

    addon.unregister()
