"""Installs the built extension into a clean Blender, uses it, upgrades it and removes it; run by test_install.

Run as ``python install_extension.py NEW.zip OLDER.zip FOLDER`` where bpy is, or by Blender itself with
``--background --python install_extension.py -- NEW.zip OLDER.zip FOLDER``. The last line that it prints is one JSON
object with what was found; an error that nobody expected ends it with exit code 1.
"""

import importlib.util
import json
import os
import sys
import traceback
from pathlib import Path

import bpy

# isort: split
import addon_utils  # importable once bpy is

sys.path.insert(0, str(Path(__file__).parent))
from registered import EXTENSION, traces

REPOSITORY = "user_default"
# What every scene of Blender may keep of its own; the rest of the user's folder must be as it was before.
BLENDERS_OWN = (".blender_ext", ".cache")


def installed(resources: Path) -> set[str]:
    """The files in the user's folder, but for what Blender keeps for itself."""
    files = (path.relative_to(resources) for path in resources.rglob("*") if path.is_file())
    return {file.as_posix() for file in files if not set(file.parts) & set(BLENDERS_OWN)}


def install(archive: str) -> str:
    """Install a zip as Preferences > Get Extensions > Install from Disk does, and return the version that is there."""
    bpy.ops.extensions.package_install_files(filepath=archive, repo=REPOSITORY, enable_on_install=True)
    assert addon_utils.check(EXTENSION) == (True, True), "not enabled"
    manifest = folder() / "blender_manifest.toml"
    return next(line for line in manifest.read_text("utf-8").splitlines() if line.startswith("version")).split('"')[1]


def folder() -> Path:
    return Path(bpy.utils.user_resource("EXTENSIONS")) / REPOSITORY / "wayfarer"


def enable(on: bool) -> None:
    def fail(error):
        raise error

    change = addon_utils.enable if on else addon_utils.disable
    change(EXTENSION, default_set=True, handle_error=fail)


def run_sample() -> dict:
    """The workflow by the operators behind the panels' buttons, on a coarse grid."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = 30
    for step in ("add_sample_character", "add_sample_room"):
        assert getattr(bpy.ops.wayfarer, step)() == {"FINISHED"}, step
    settings = scene.wayfarer
    settings.environment.cell_size, settings.environment.n_headings = 0.25, 12
    settings.walk.duration = 5.0
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc"))
    for step in ("build_motion_graph", "embed", "paint_map", "random_walk"):
        assert getattr(bpy.ops.wayfarer, step)() == {"FINISHED"}, step
    return numbers(scene)


def numbers(scene) -> dict:
    store = sys.modules[EXTENSION + ".addon.results.store"]
    summary = store.results(scene).summary
    return {"nodes": summary.nodes, "links": summary.links, "walk_segments": summary.walk.segments}


def check(new: str, older: str, work: Path) -> dict:
    resources = Path(bpy.utils.user_resource("EXTENSIONS")).parent
    found: dict = {"blender": bpy.app.version_string, "python": sys.version.split()[0]}
    found["scipy_before"] = importlib.util.find_spec("scipy") is not None
    files, registered = installed(resources), traces()

    found["older"] = install(older)
    assert (folder() / "addon" / "gone.py").exists()
    import scipy.optimize  # one that is loaded while it is upgraded

    found["upgraded"] = install(new)
    assert not (folder() / "addon" / "gone.py").exists(), "a file of the older version is still there"
    import scipy.sparse.csgraph

    found["scipy"] = [scipy.__version__, str(Path(scipy.sparse.csgraph.__file__).resolve())]
    found["resources"] = str(resources.resolve())
    enabled = traces()
    found["numbers"] = run_sample()
    saved = str(work / "walked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=saved)

    enable(False)
    found["left_when_disabled"] = sorted(traces() - registered)
    enable(True)
    found["missing_when_enabled_again"] = sorted(enabled - traces())
    bpy.ops.wm.open_mainfile(filepath=saved)
    found["numbers_read_back"] = numbers(bpy.context.scene)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)

    repositories = bpy.context.preferences.extensions.repos
    index = next(i for i, repository in enumerate(repositories) if repository.module == REPOSITORY)
    bpy.ops.extensions.package_uninstall(repo_index=index, pkg_id="wayfarer")
    found["left_registered"] = sorted(traces() - registered)
    found["left_files"] = sorted(installed(resources) - files)
    found["left_modules"] = sorted(name for name in sys.modules if name.startswith(EXTENSION))
    found["left_in_preferences"] = EXTENSION in bpy.context.preferences.addons
    # A file that was made with it opens without it.
    bpy.ops.wm.open_mainfile(filepath=saved)
    found["actions_without_it"] = len(bpy.data.actions)
    return found


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    code = 1
    try:
        print(json.dumps(check(words[0], words[1], Path(words[2]))))
        code = 0
    except BaseException:  # whatever it was, it is told, and the process ends in the one safe way
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
