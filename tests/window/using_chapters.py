"""The second half of the session: what an artist does with a painted floor."""

import os

import addon_utils
import bpy
import hand
import numpy as np
import picture
import sidebar
from scene_facts import JOB, badges, colors, findings, keep_picture, numbers, part, results, settings, settled

SAVED = str(JOB / "session.blend")
# In the sample room: a pillar, where it is dragged to, and where the step is.
PILLAR, BESIDE_IT, STEP_Y = "Pillar B", (0.4, -1.2, 0.0), 1.45


def move_pillar(note) -> hand.Turns:
    """Live: take a pillar, drag it across the room, put it down, and take that back."""
    yield from sidebar.press_button("Map", "wayfarer.live")
    yield from hand.until(lambda: settings().live, "live evaluation")
    pillar = bpy.data.objects[PILLAR]
    start, painted = pillar.matrix_world.translation.copy(), colors()
    yield from hand.click(*hand.pixel_of(start))
    note("selected", pillar.select_get())
    yield from settled()
    before = picture.pixels()
    # From its foot, so that mouse and pillar keep together.
    foot = (start.x, start.y, 0.0)
    yield from hand.move(*hand.pixel_of(foot))
    yield from hand.press("G")
    yield from hand.until(lambda: "TRANSFORM_OT_translate" in hand.running(), "the pillar to be taken")
    # Over the floor.
    yield from hand.press("Z", shift=True)
    for share in np.linspace(0.1, 1.0, 10):
        place = [a + share * (b - a) for a, b in zip(foot, BESIDE_IT, strict=True)]
        yield from hand.move(*hand.pixel_of(place))
        if share == 0.5:
            # The hand rests, but does not let go.
            yield from hand.until(lambda: colors() != painted, "the map to follow")
            note("followed", "TRANSFORM_OT_translate" in hand.running())
    keep_picture("10_dragging")
    yield from hand.press("LEFTMOUSE")
    yield from hand.until(lambda: not hand.running(), "the pillar to be put down")
    yield from settled()
    note("moved", list(pillar.matrix_world.translation - start))
    note("changed", colors() != painted)
    note("pixels", int((np.abs(picture.pixels().astype(int) - before) > 8).any(axis=2).sum()))
    note("stale", badges())
    keep_picture("11_dropped")
    yield from hand.press_in_viewport("Z", ctrl=True)
    yield from hand.until(lambda: (bpy.data.objects[PILLAR].matrix_world.translation - start).length < 1e-5, "undo")
    yield from settled()
    yield from hand.until(lambda: colors() == painted, "the map of before")
    note("stale_after_undo", badges())
    yield from sidebar.press_button("Map", "wayfarer.live")
    note("off", not settings().live)
    # Deselect it, so that its outline is not in the pictures that follow.
    yield from hand.press_in_viewport("A", alt=True)


def ask_why_not(note) -> hand.Turns:
    settings().map.quantity = "WHY_NOT"
    yield from settled()
    floor = part("render.floor").find_floor(bpy.context.scene)
    note("legend", part("render.floor").floor_legend(floor).title)
    keep_picture("12_why_not")
    settings().map.quantity = "VARIABILITY"
    yield from settled()


def evaluate(note) -> hand.Turns:
    """Metrics, and weak spots, of which the list tells the places."""
    # Fewer than an artist would want, so that nobody waits for them.
    settings().evaluation.n_pairs = 10
    yield from sidebar.press_button("Evaluation", "wayfarer.measure")
    yield from hand.until(lambda: "METRICS" in findings(), "the metrics")
    yield from hand.work_is_done()
    note("metrics", findings()["METRICS"])
    # Down to a single cell.
    settings().evaluation.min_area = 0.01
    yield from sidebar.open_part("Evaluation", "Weak Spots")
    yield from sidebar.press_button("Evaluation", "wayfarer.find_weak_spots")
    yield from hand.until(lambda: "WEAK_SPOTS" in findings(), "the weak spots")
    yield from hand.work_is_done()
    note("weak_spots", findings()["WEAK_SPOTS"])
    keep_picture("13_evaluation")
    yield from sidebar.close_part("Evaluation", "Weak Spots")


def walk(note) -> hand.Turns:
    yield from sidebar.press_button("Walk", "wayfarer.random_walk")
    yield from hand.until(lambda: results().walk is not None, "the walk")
    yield from hand.work_is_done()
    action, scene = part("results.shown").find_walk(bpy.context.scene), bpy.context.scene
    note("frames", list(action.frame_range))
    note("plays", settings().character.animation_data.action == action)
    places = []
    for frame in np.linspace(scene.frame_start, action.frame_range[1], 8).astype(int):
        places.append([round(v, 3) for v in _root(int(frame))])
    note("places", places)
    # While it crosses the step.
    distances = [(abs(_root(frame).y - STEP_Y), frame) for frame in range(1, int(action.frame_range[1]), 5)]
    scene.frame_set(min(distances)[1])
    yield from hand.redrawn()
    keep_picture("14_walk")
    note("stale", badges())


def _root(frame: int):
    """Where the character's root is at a frame."""
    bpy.context.scene.frame_set(frame)
    character = settings().character
    return character.matrix_world @ character.pose.bones[0].head


def undo_walk(note) -> hand.Turns:
    links, name = numbers()["walk"], part("results.shown").find_walk(bpy.context.scene).name
    yield from hand.press_in_viewport("Z", ctrl=True)
    yield from hand.until(lambda: part("results.shown").find_walk(bpy.context.scene) is None, "the walk to be gone")
    yield from hand.redrawn()
    note("gone", name not in bpy.data.actions and numbers()["walk"] == 0)
    note("map_stays", numbers()["painted"])
    yield from hand.press_in_viewport("Z", ctrl=True, shift=True)
    yield from hand.until(lambda: part("results.shown").find_walk(bpy.context.scene) is not None, "the walk to be back")
    yield from hand.redrawn()
    note("same", numbers()["walk"] == links)
    note("stale", badges())


def tune(note) -> hand.Turns:
    """Make the embedding smaller, and take that back by its button."""
    before, painted = numbers(), colors()
    yield from sidebar.press_button("Tuning", "wayfarer.prune")
    yield from hand.until(lambda: results().pruning is not None, "the pruned embedding")
    yield from hand.work_is_done()
    note("before", before)
    note("pruned", numbers())
    yield from hand.until(lambda: colors() != painted, "the map of what is left")
    keep_picture("15_tuning")
    yield from sidebar.press_button("Tuning", "wayfarer.restore_embedding")
    yield from hand.until(lambda: results().pruning is None, "the whole embedding")
    yield from hand.work_is_done()
    yield from hand.until(lambda: colors() == painted, "the map of the whole")
    note("restored", numbers())
    note("stale", badges())


def query(note) -> hand.Turns:
    """How long does it take to get to the 3D cursor?"""
    bpy.context.scene.cursor.location = (-1.6, 2.9, 0.0)
    yield from sidebar.press_button("Queries", "wayfarer.find_reach")
    yield from hand.until(lambda: "REACH" in findings(), "the times to reach")
    yield from hand.work_is_done()
    note("numbers", findings()["REACH"])
    keep_picture("17_query")


def save_and_reopen(note) -> hand.Turns:
    bpy.ops.wm.save_as_mainfile(filepath=SAVED)
    before, painted = numbers(), colors()
    # A change, so that the key has something to save.
    settings().walk.seed += 1
    os.utime(SAVED, (0, 0))
    yield from hand.press_in_viewport("S", ctrl=True)
    yield from hand.until(lambda: os.path.getmtime(SAVED) > 1e9, "the file to be saved")
    with bpy.context.temp_override(window=hand.window()):
        bpy.ops.wm.open_mainfile(filepath=SAVED)
    yield from hand.until(lambda: bpy.context.scene is not None and bpy.data.filepath == SAVED, "the file")
    hand.count_redraws()
    yield from hand.redrawn()
    # Blender tells of changes after opening; what comes of that is seen when things have come to rest.
    settle = part("results.staleness")._settle
    yield from hand.until(lambda: not bpy.app.timers.is_registered(settle), "fingerprints of the opened scene")
    yield from hand.redrawn()
    note("same", numbers() == before and colors() == painted)
    note("problem", results().problem)
    note("stale", badges())
    note("megabytes", os.path.getsize(SAVED) / 1e6)
    keep_picture("18_opened_again")


def disable(note) -> hand.Turns:
    """Nothing of ours is drawn any more, and nothing complains."""
    addon_utils.disable(hand.EXTENSION, default_set=True)
    yield from hand.redrawn()
    note("objects", len(bpy.data.objects))
    keep_picture("19_disabled")
