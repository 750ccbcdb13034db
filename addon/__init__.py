"""Everything of Wayfarer that knows Blender.

Each module listed here has its own ``register`` and ``unregister``; the root package calls the two below.
"""

from . import operators, properties, state, ui

# In order of registration: a module may use what those before it have registered.
_MODULES = (properties, state, operators, ui)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
