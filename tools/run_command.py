"""One command in the bpy module: python3 dev.py command SCENE.blend -- COMMAND ..."""

import importlib
import os
import sys
from pathlib import Path

from headless import EXTENSION, enable_extension, leave


def main(arguments: list[str]) -> int:
    blend = Path(arguments[0]) if arguments[:1] and arguments[0] != "--" else None
    words = arguments[0 if blend is None else 1 :]
    words = words[1:] if words[:1] == ["--"] else words
    # Starting Blender says things on standard output that nobody asked for.
    kept = os.dup(1)
    os.dup2(2, 1)
    enable_extension()
    command = importlib.import_module(f"{EXTENSION}.addon.cli.command")
    os.dup2(kept, 1)
    return command.run(words, blend)


if __name__ == "__main__":
    leave(main(sys.argv[1:]))
