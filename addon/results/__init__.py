"""Results of each scene: kept, saved with the file, and compared with what the scene is now."""

from . import file, pruned, state, watch

# In order of registration: a module may use what those before it have registered.
_MODULES = (state, watch, file, pruned)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
