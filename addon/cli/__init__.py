"""Blender's command line: ``blender scene.blend --background --command wayfarer ...``."""
