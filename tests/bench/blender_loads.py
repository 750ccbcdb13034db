"""One load in the real add-on, told as JSON: ``python blender_loads.py actions 500``, started by :mod:`.loads`.

What counts is that the window would stay alive: between two yields of long work nothing may take seconds.
"""

import json
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Generator
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from dev import link_extension  # noqa: E402  (only now, see above)

MOTION_NOISE = 0.02
"""Radians by which copies of a motion differ."""


def start_blender() -> Path:
    """Blender in this process, with the extension enabled and nothing in the scene; the folder of its resources."""
    resources = Path(tempfile.mkdtemp(prefix="wayfarer-load-"))
    os.environ["BLENDER_USER_RESOURCES"] = str(resources)
    link_extension(resources)
    import bpy

    # isort: split
    import addon_utils

    addon_utils.enable("bl_ext.user_default.wayfarer", default_set=True)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.context.scene.render.fps = 30
    return resources


class Watch:
    """Runs long work and tells how long it took, and for how long a window would have stood still."""

    def __init__(self):
        self.record: dict = {}

    def run(self, name: str, steps: Generator):
        started = last = time.perf_counter()
        longest = 0.0
        while True:
            try:
                next(steps)
            except StopIteration as stop:
                result = stop.value
                break
            finally:
                now = time.perf_counter()
                longest, last = max(longest, now - last), now
        self.record[f"{name}_seconds"] = round(last - started, 2)
        self.record[f"{name}_longest"] = round(longest, 2)
        return result

    def time(self, name: str, work) -> None:
        started = time.perf_counter()
        work()
        self.record[f"{name}_seconds"] = round(time.perf_counter() - started, 2)


def many_actions(n_actions: int) -> dict:
    """The sample's clips, each many times, a little differently performed: listed, examined, made a graph of."""
    import bpy

    from bl_ext.user_default.wayfarer.addon.operators.health import WAYFARER_OT_examine_clips
    from bl_ext.user_default.wayfarer.addon.results import staleness, store, workflow
    from bl_ext.user_default.wayfarer.core.errors import MotionGraphError

    bpy.ops.wayfarer.add_sample_character()
    scene, watch = bpy.context.scene, Watch()
    settings = scene.wayfarer
    sample, rng = [clip.action for clip in settings.clips], np.random.default_rng(0)
    for number in range(n_actions - len(sample)):
        _perform_differently(sample[number % len(sample)].copy(), f"take {number:03}", rng)
    watch.time("list", bpy.ops.wayfarer.refresh_clips)
    watch.run("doctor", WAYFARER_OT_examine_clips.steps(None, bpy.context))
    watch.record["clips"] = len(settings.clips)
    try:
        watch.run("build", workflow.build_graph_steps(scene))
    except MotionGraphError as refusal:
        watch.record["refused"] = str(refusal)
    # What can be held in memory is built, for the rest of the work.
    settings.graph.max_cost, settings.graph.frame_rate = 0.08, 15.0
    workflow.keep_built(scene, watch.run("smaller_build", workflow.build_graph_steps(scene)))
    watch.record["segments"] = len(store.results(scene).graph.segments)
    watch.record["links"] = len(store.results(scene).graph.links)
    # What the timer does once changes have come to an end.
    watch.run("look", staleness._look_steps(scene))
    return watch.record


def _perform_differently(action, name: str, rng: np.random.Generator) -> None:
    action.name, action.use_fake_user = name, True
    for slot in action.slots:
        for curve in action.layers[0].strips[0].channelbag(slot).fcurves:
            points = curve.keyframe_points
            if "rotation" in curve.data_path and len(points):
                keys = np.empty(2 * len(points), np.float32)
                points.foreach_get("co", keys)
                keys[1::2] += rng.normal(0, MOTION_NOISE)
                points.foreach_set("co", keys)


def many_files(n_files: int) -> dict:
    """The sample's clips as BVH files: imported by us and, every tenth of them, by Blender's own importer."""
    import addon_utils
    import bpy

    from bl_ext.user_default.wayfarer.addon.bridge.import_bvh import bvh_files, import_bvh_files_steps
    from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_repertoire
    from tests.core.bvh_writer import bvh_text

    addon_utils.enable("io_anim_bvh")
    watch, sample = Watch(), sample_repertoire(100)
    with tempfile.TemporaryDirectory(prefix="wayfarer-load-") as name:
        folder = Path(name)
        texts = [bvh_text(clip) for clip in sample]
        for number in range(n_files):
            (folder / f"take_{number:03}.bvh").write_text(texts[number % len(texts)])
        paths = bvh_files(folder)
        made = watch.run("import", import_bvh_files_steps(paths))
        n_keys = sum(int(action.frame_range[1]) for action in made.actions)
        started = time.perf_counter()
        for path in paths[::10]:
            bpy.ops.import_anim.bvh(filepath=str(path), global_scale=0.01)
        reference = n_files / len(paths[::10]) * (time.perf_counter() - started)
    seconds = watch.record["import_seconds"]
    return {
        "files": len(made.actions),
        "frames": n_keys,
        "longest": watch.record["import_longest"],
        "seconds": seconds,
        "reference": "Blender's importer, by a tenth of the files",
        "reference_seconds": reference,
        "ratio": reference / seconds,
    }


LOADS = {"actions": many_actions, "files": many_files}

if __name__ == "__main__":
    folder = start_blender()
    found = LOADS[sys.argv[1]](*map(int, sys.argv[2:]))
    found["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    sys.stdout.write(f"\nRECORD {json.dumps(found)}\n")
    sys.stdout.flush()
    shutil.rmtree(folder, ignore_errors=True)
    # Without Python's own ending, in which Blender may hang while classes are registered.
    os._exit(0)
