"""The only place that converts between Blender's data and the core's arrays.

Bulk data passes through ``foreach_get`` and ``foreach_set`` only. Nothing in here knows operators, panels or
settings, and nothing keeps a reference to Blender's data after a function returns: bindings hold names.

One Blender unit is taken as one metre, as the viewport shows it; the scene's unit scale changes labels, not
sizes.
"""
