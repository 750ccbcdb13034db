"""Makes Wayfarer available as Blender would: linked into the user's extensions and enabled.

Test modules import it by the name that it has there, ``from bl_ext.user_default.wayfarer.addon import ...``
(never ``core`` or ``addon``: the same class would exist twice), and find an empty scene at each test's start.
"""

import importlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest

from dev import link_extension

EXTENSION = "bl_ext.user_default.wayfarer"

_own_resources = None
if "BLENDER_USER_RESOURCES" not in os.environ:
    _own_resources = tempfile.mkdtemp(prefix="wayfarer-blender-")
    os.environ["BLENDER_USER_RESOURCES"] = _own_resources
link_extension(Path(os.environ["BLENDER_USER_RESOURCES"]))

# Blender reads BLENDER_USER_RESOURCES once, when it starts: that is this import.
import bpy  # noqa: E402  (only now, see above)

# isort: split
import addon_utils  # noqa: E402  (importable once bpy is)


def enable_extension():
    """Enable the extension and return its root package; an error while it registers is raised."""

    def fail(error):
        raise error

    addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)
    return importlib.import_module(EXTENSION)


def disable_extension():
    """Disable the extension; an error while it unregisters is raised."""

    def fail(error):
        raise error

    addon_utils.disable(EXTENSION, default_set=True, handle_error=fail)


# Now, because test modules import from it.
enable_extension()


@pytest.fixture(autouse=True)
def empty_scene():
    """Start each test in an empty file; unlike factory settings, this keeps extensions enabled."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


@pytest.fixture(scope="session")
def sample_file(tmp_path_factory) -> str:
    """The sample character in its room at 30 frames per second, made once: opening it is quicker."""
    path = str(tmp_path_factory.mktemp("sample") / "sample.blend")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.context.scene.render.fps = 30
    bpy.ops.wayfarer.add_sample_character()
    bpy.ops.wayfarer.add_sample_room()
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


@pytest.fixture(scope="session")
def small_file(sample_file, tmp_path_factory) -> str:
    """The sample with four clips in the near half of its room, everything coarse: each step takes a moment."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    clips = ("walk_slow", "turn_left_90", "turn_right_90", "arc_left")
    bpy.data.batch_remove([action for action in bpy.data.actions if action.name not in clips])
    bpy.data.batch_remove([bpy.data.objects[name] for name in ("Wall Right", "Pillar B", "Crate")])
    settings.refresh_clips()
    settings.graph.frame_rate = 15
    environment = settings.environment
    environment.cell_size, environment.n_headings = 0.35, 10
    environment.ground_source, environment.ground_low, environment.ground_high = "TYPED", (-3.5, -4), (1.4, 1.6)
    settings.walk.duration, settings.walk.crowd.duration, settings.walk.crowd.n_walkers = 3.0, 2.0, 2
    settings.evaluation.n_pairs = settings.evaluation.n_candidates = 3
    settings.queries.n_walks = 3
    path = str(tmp_path_factory.mktemp("small") / "small.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


@pytest.fixture
def sample_settings(sample_file, empty_scene):
    """The sample on a coarse grid, with only a few walks ticked: ``scene.wayfarer``."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    settings.environment.cell_size, settings.environment.n_headings = 0.25, 12
    settings.walk.duration = 5.0
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc"))
    return settings


@pytest.fixture
def wayfarer():
    """The extension's root package, enabled during the test and after it."""
    yield importlib.import_module(EXTENSION)
    if not addon_utils.check(EXTENSION)[1]:
        enable_extension()


_exit_code = None


def pytest_sessionfinish(session, exitstatus):
    global _exit_code
    _exit_code = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Leave without Python's own ending, in which Blender 4.5 hangs while classes are registered."""
    if _own_resources is not None:
        shutil.rmtree(_own_resources, ignore_errors=True)
    if _exit_code is not None:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_exit_code)
