"""Telling whether what a result was made from has changed since."""

import hashlib
from collections.abc import Set
from functools import cache

import bpy
import numpy as np

_SHOWN = {"active", "name", "show_expanded", "rna_type", "select"}
_SHOWN |= {"select_control_point", "select_left_handle", "select_right_handle"}
"""Values of constraints, modifiers, strips and points that make no difference to what they do."""


def fingerprint(*parts) -> str:
    """A digest of arrays, numbers and texts: equal for equal input."""
    digest = hashlib.blake2b(digest_size=16)
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(repr((part.shape, part.dtype.str)).encode())
            digest.update(np.ascontiguousarray(part).data)
        else:
            digest.update(repr(part).encode())
        digest.update(b";")
    return digest.hexdigest()


def setting_values(thing, path: str = "", moving: Set[str] = frozenset()) -> list:
    """The settings of a constraint, a strip or a modifier of a curve, with the names of what they refer to, but for
    those whose data path is among the ``moving``.
    """
    names = [name for name in settings_of(type(thing)) if f"{path}.{name}" not in moving]
    return [(thing.type, *((name, plain(getattr(thing, name), f"{path}.{name}", moving)) for name in names))]


@cache
def settings_of(kind: type) -> tuple[str, ...]:
    """Names of the properties of a kind of thing that can be set and make a difference."""
    properties = kind.bl_rna.properties
    return tuple(
        prop.identifier
        for prop in properties
        if prop.identifier not in _SHOWN and (not prop.is_readonly or prop.type == "COLLECTION")
    )


def plain(value, path: str = "", moving: Set[str] = frozenset()):
    """A value of a property as one that can be told from others by its text."""
    if isinstance(value, bpy.types.bpy_prop_collection):
        return [
            [(name, plain(getattr(item, name))) for name in settings_of(type(item)) if f"{own}.{name}" not in moving]
            for own, item in ((f"{path}[{place}]", item) for place, item in enumerate(value))
        ]
    if isinstance(value, bpy.types.ID):
        return named(value)
    if isinstance(value, set):
        return sorted(value)
    if isinstance(value, bpy.types.bpy_struct):
        return ""
    if hasattr(value, "to_dict"):  # custom properties within one
        return repr(value.to_dict())
    return list(map(plain, value)) if hasattr(value, "__len__") and not isinstance(value, str) else value


def named(block) -> str:
    """A data-block's name; empty for none."""
    return block.name if block is not None else ""
