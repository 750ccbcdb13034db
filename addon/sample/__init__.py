"""The sample: a character with a repertoire and a room for it, as Blender objects."""
