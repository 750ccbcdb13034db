"""Results of each scene: kept, saved with the file, and compared with what the scene is now."""

from ..properties.graph_names import SOURCE
from . import file, pruned, shown, staleness
from .store import embedded_graph

# In order of registration: a module may use what those before it have registered.
_MODULES = (shown, staleness, file, pruned)


def register():
    SOURCE.graph_of = embedded_graph
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
    SOURCE.clear()
