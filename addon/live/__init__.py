"""Maps and drawings that follow the scene while it changes."""

from . import environment, live

# In order of registration: a module may use what those before it have registered.
_MODULES = (live, environment)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
