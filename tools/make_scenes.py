"""Make the .blend files of the sample scenes anew: .venv/bin/python tools/make_scenes.py [FOLDER].

For developers; run it after changing layouts.py, in the oldest Blender that is supported, because newer ones can open
what that has written.
"""

import importlib
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def main(folder: Path) -> None:
    sys.path[:0] = [str(ROOT), str(ROOT / "tools")]
    dev, run = importlib.import_module("dev"), importlib.import_module("run")

    with dev.blender_resources() as environment:
        os.environ.update(environment)
        run.enable_extension()
        scene_file = importlib.import_module(f"{run.EXTENSION}.addon.sample.scene_file")
        layouts = importlib.import_module(f"{run.EXTENSION}.addon.sample.layouts")
        folder.mkdir(parents=True, exist_ok=True)
        for layout in layouts.LAYOUTS:
            path = scene_file.write_scene_file(folder, layout)
            sys.stdout.write(f"{path}  {path.stat().st_size / 1e3:.0f} kB\n")
    run.leave(0)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / "assets" / "scenes")
