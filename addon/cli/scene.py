"""What the commands of the command line do first: open a file, find its scene and its character."""

from pathlib import Path

import bpy


class CommandError(Exception):
    """What stops a command, as a sentence for the person at the keyboard."""


def open_blend(path: Path) -> None:
    """Open a .blend file in place of the present one."""
    if not path.is_file():
        raise CommandError(f"There is no file '{path}'; name a .blend file.")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    except RuntimeError as error:
        raise CommandError(f"'{path}' cannot be opened: {str(error).strip().splitlines()[-1]}") from None


def find_scene(name: str | None):
    """The scene of this name; the open one without a name."""
    if name is None:
        return bpy.context.scene
    scene = bpy.data.scenes.get(name)
    if scene is None:
        raise CommandError(f"There is no scene '{name}'; the file has {listed(bpy.data.scenes)}.")
    return scene


def choose_character(scene, name: str | None, how: str = "say --character NAME") -> None:
    """Make the armature of this name the scene's character; without a name the chosen one stays, or the only one.

    ``how`` tells in the message of the CommandError how a character can be named.
    """
    rigs = [obj for obj in scene.objects if obj.type == "ARMATURE"]
    if name is not None:
        chosen = scene.objects.get(name)
        if chosen not in rigs:
            raise CommandError(f"The scene '{scene.name}' has no armature '{name}'; it has {listed(rigs)}.")
        if scene.wayfarer.character != chosen:
            scene.wayfarer.character = chosen
    elif scene.wayfarer.character is None:
        if len(rigs) != 1:
            raise CommandError(f"No character is chosen in the scene '{scene.name}'; {how}: it has {listed(rigs)}.")
        scene.wayfarer.character = rigs[0]


def listed(datablocks) -> str:
    """Names for a sentence."""
    names = [f"'{datablock.name}'" for datablock in datablocks]
    return ", ".join(names) if names else "none"
