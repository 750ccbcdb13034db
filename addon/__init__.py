"""Everything of Wayfarer that knows Blender.

Each room listed here has its own ``register`` and ``unregister``; the root package calls the two below.
"""

from . import live, operators, properties, results, session, ui
from .cli import command
from .scene import changes

# In order of registration: a room may use what those before it have registered.
_ROOMS = (properties, session, changes, results, live, operators, ui, command)


def register():
    for room in _ROOMS:
        room.register()


def unregister():
    for room in reversed(_ROOMS):
        room.unregister()
