"""Enumerations of the core as items of Blender's properties."""

from enum import Enum


def enum_items(texts: dict[Enum, tuple[str, str]]) -> list[tuple[str, str, str]]:
    """Items of an EnumProperty: the members' names, with label and description."""
    return [(member.name, label, description) for member, (label, description) in texts.items()]
