"""The scene of a command: its file, its character, and its settings by name and text (``cell_size=0.1``)."""

import math
from difflib import get_close_matches
from pathlib import Path

import bpy

from ...core.errors import SceneError

_GROUPS = ("environment", "embedding", "graph", "contacts", "walk", "map")
_YES, _NO = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def open_blend(path: Path) -> None:
    """Open a .blend file in place of the present one."""
    if not path.is_file():
        raise SceneError(f"There is no file '{path}'; name a .blend file.")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    except RuntimeError as error:
        raise SceneError(
            f"'{path}' cannot be opened: it is no .blend file, is damaged, or comes from a later version of Blender."
        ) from error


def find_scene(name: str | None):
    """The scene of this name; the open one without a name."""
    if name is None:
        return bpy.context.scene
    scene = bpy.data.scenes.get(name)
    if scene is None:
        raise SceneError(f"There is no scene '{name}'; the file has {listed(bpy.data.scenes)}.")
    return scene


def choose_character(scene, name: str | None, how: str = "say --character NAME") -> None:
    """Make the armature of this name the scene's character; without a name the chosen one stays, or the only one.

    ``how`` tells in the message of the SceneError how a character can be named.
    """
    rigs = [obj for obj in scene.objects if obj.type == "ARMATURE"]
    if name is not None:
        chosen = scene.objects.get(name)
        if chosen not in rigs:
            raise SceneError(f"The scene '{scene.name}' has no armature '{name}'; it has {listed(rigs)}.")
        if scene.wayfarer.character != chosen:
            scene.wayfarer.character = chosen
    elif scene.wayfarer.character is None:
        if len(rigs) != 1:
            raise SceneError(f"No character is chosen in the scene '{scene.name}'; {how}: it has {listed(rigs)}.")
        scene.wayfarer.character = rigs[0]


def listed(datablocks) -> str:
    """Names for a sentence."""
    names = [f"'{datablock.name}'" for datablock in datablocks]
    return ", ".join(names) if names else "none"


def apply_override(settings, text: str) -> str:
    """Set one setting of ``scene.wayfarer``; returns what is wrong with the text, as a sentence, or nothing.

    ``text`` is NAME=VALUE, or GROUP.NAME=VALUE for a name that several groups have. Values are in the units of the
    interface: metres, seconds, degrees.
    """
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name:
        return f"'{text}' is no setting; write NAME=VALUE, for example cell_size=0.1."
    group_name, dot, rest = name.partition(".")
    groups = [group_name] if dot else _GROUPS
    wanted = rest if dot else name
    if dot and group_name not in _GROUPS:
        return f"There are no settings '{group_name}'; there are {', '.join(_GROUPS)}."
    owners = [group for group in groups if wanted in _names(getattr(settings, group))]
    if not owners:
        known = [known for group in groups for known in _names(getattr(settings, group))]
        near = get_close_matches(wanted, known)
        return f"There is no setting '{name}'; " + (
            f"say {' or '.join(near)}." if near else f"there are {', '.join(known)}."
        )
    if len(owners) > 1:
        return f"Several settings are called '{name}'; say {' or '.join(f'{owner}.{name}' for owner in owners)}."
    group = getattr(settings, owners[0])
    prop = group.bl_rna.properties[wanted]
    try:
        setattr(group, wanted, _parsed(prop, value))
    except SceneError as problem:
        return f"'{value}' is no value for '{name}': {problem}."
    return ""


def _names(group) -> list[str]:
    """Settings that a text can give: neither lists nor places in them."""
    return [
        name
        for name, prop in group.bl_rna.properties.items()
        if name not in ("rna_type", "name")
        and not name.startswith("active_")
        and prop.type != "COLLECTION"
        and not (prop.type == "POINTER" and prop.fixed_type.identifier not in ("Object", "Collection"))
    ]


def _parsed(prop, text: str):
    """The value of a property that a text stands for; SceneError says what is expected."""
    if prop.type == "BOOLEAN":
        if text.lower() not in _YES + _NO:
            raise SceneError("say yes or no")
        return text.lower() in _YES
    if prop.type in ("INT", "FLOAT"):
        texts = text.split(",") if prop.is_array else [text]
        if prop.is_array and len(texts) != prop.array_length:
            raise SceneError(f"{prop.array_length} numbers with a comma between them are needed")
        numbers = [_number(prop, number) for number in texts]
        return numbers if prop.is_array else numbers[0]
    if prop.type == "ENUM":
        known = prop.enum_items.keys()
        wanted = text.upper().replace(" ", "_").replace("-", "_")
        if wanted not in known:
            raise SceneError(f"there are {', '.join(known)}")
        return wanted
    if prop.type == "POINTER":
        kind = "objects" if prop.fixed_type.identifier == "Object" else "collections"
        found = getattr(bpy.data, kind).get(text)
        if found is None:
            raise SceneError(f"the file has no {kind[:-1]} of that name")
        return found
    return text


def _number(prop, text: str) -> float | int:
    try:
        number = int(text) if prop.type == "INT" else float(text)
    except ValueError:
        raise SceneError("a whole number is needed" if prop.type == "INT" else "a number is needed") from None
    if not math.isfinite(number):
        raise SceneError("a finite number is needed")
    if prop.unit == "ROTATION":
        number = math.radians(number)
    if not prop.hard_min <= number <= prop.hard_max:
        raise SceneError(f"it must be from {prop.hard_min:g} to {prop.hard_max:g}")
    return number
