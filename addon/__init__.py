"""Everything of Wayfarer that knows Blender.

Each module listed here has its own ``register`` and ``unregister``; the root package calls the two below.
"""

from . import (
    command,
    data_watch,
    environment_sight,
    environment_view,
    live,
    operators,
    presets,
    properties,
    pruned_embedding,
    scene_changes,
    state,
    storage,
    ui,
)

# In order of registration: a module may use what those before it have registered.
_MODULES = (
    properties,
    state,
    data_watch,
    storage,
    scene_changes,
    live,
    pruned_embedding,
    environment_sight,
    environment_view,
    operators,
    presets,
    ui,
    command,
)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
