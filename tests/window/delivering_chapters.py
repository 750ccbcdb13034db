"""The fourth part of the session: what an artist takes away - walks baked in other ways, crowds, reports, files."""

import re
from pathlib import Path

import bpy
import editors
import hand
import sidebar
from scene_facts import JOB, everything, findings, keep_picture, log_browser, part, results, settings


def bake_otherwise(note) -> hand.Turns:
    """A walk as NLA strips, as a copy of the character and by the clips' weights."""
    walk, character = settings().walk, settings().character
    walk.duration = 6.0
    yield from editors.turn_to("Walk", "wayfarer.walk.output", lambda: walk.output, "STRIPS")
    yield from _walk()
    tracks = character.animation_data.nla_tracks
    note("strips", {track.name: len(track.strips) for track in tracks})
    note("action_with_strips", character.animation_data.action is not None)
    keep_picture("30_walk_as_strips")
    yield from editors.turn_to("Walk", "wayfarer.walk.output", lambda: walk.output, "COPY")
    yield from _walk()
    copies = part("bridge.copies").find_copies(bpy.context.scene, part("walks.baking").COPY_COLLECTION)
    armatures = [obj for obj in copies if obj.type == "ARMATURE"]
    note("copies", [obj.animation_data.action.name for obj in armatures])
    keep_picture("31_walk_as_copy")
    yield from editors.turn_to("Walk", "wayfarer.walk.output", lambda: walk.output, "ACTION")
    yield from editors.turn_to("Walk", "wayfarer.walk.style", lambda: walk.style, "RANDOM")
    yield from editors.turn_to("Walk", "wayfarer.walk.weighting", lambda: walk.weighting, "CLIPS")
    keep_picture("32_clip_weights")
    yield from _walk()
    note("plays", character.animation_data.action == part("results.shown").find_walk(bpy.context.scene))
    note("tracks_left", [track.name for track in character.animation_data.nla_tracks])
    yield from editors.turn_to("Walk", "wayfarer.walk.style", lambda: walk.style, "WANDER")


def _walk() -> hand.Turns:
    before = results().walk
    yield from sidebar.press_button("Walk", "wayfarer.random_walk")
    yield from hand.until(lambda: results().walk is not before, "the walk")
    yield from hand.work_is_done()


def crowd(note) -> hand.Turns:
    """A few copies walk; Esc in the middle of a larger crowd leaves them as they are; a button removes them."""
    asked, scene = settings().walk.crowd, bpy.context.scene
    asked.duration = 5.0

    def walkers() -> list:
        copies = part("bridge.copies").find_copies(scene, part("walks.crowd").CROWD_COLLECTION)
        return [obj for obj in copies if obj.type == "ARMATURE"]

    yield from sidebar.open_part("Walk", "Crowd")
    yield from editors.fill("Walk", "wayfarer.walk.crowd.n_walkers", "4")
    yield from sidebar.press_button("Walk", "wayfarer.crowd")
    yield from hand.until(walkers, "the crowd")
    yield from hand.work_is_done()
    note("walkers", len(walkers()))
    note("closest", asked.closest)
    note("left_out", len(asked.unserved.splitlines()))
    places = []
    for frame in (1, 60, 120):
        scene.frame_set(frame)
        places.append([[round(v, 2) for v in obj.matrix_world @ obj.pose.bones[0].head] for obj in walkers()])
    note("places", places)
    yield from hand.redrawn()
    keep_picture("33_crowd")
    yield from editors.fill("Walk", "wayfarer.walk.crowd.n_walkers", "15")
    asked.duration = 60.0
    yield from hand.redrawn()
    before, ran = everything(), 0
    yield from sidebar.press_button("Walk", "wayfarer.crowd")
    yield from hand.until(lambda: "WAYFARER_OT_crowd" in hand.running(), "the larger crowd to begin")
    for _ in range(4):
        yield
        ran += "WAYFARER_OT_crowd" in hand.running()
    keep_picture("34_crowd_runs")
    yield from hand.press("ESC")
    yield from hand.until(lambda: not hand.running(), "the crowd to end")
    yield from hand.redrawn()
    note("ran", ran)
    note("same", everything() == before)
    yield from sidebar.press_button("Walk", "wayfarer.remove_crowd", sidebar.BESIDE_LIST)
    yield from hand.until(lambda: not walkers(), "the crowd to be gone")
    note("collection", part("walks.crowd").CROWD_COLLECTION in bpy.data.collections)
    yield from sidebar.close_part("Walk", "Crowd")


def write_report(note) -> hand.Turns:
    """The report, into a folder that is chosen in the file browser; what opens the page writes down which."""
    folder, opened = JOB / "reports", log_browser()
    folder.mkdir()
    # In the window that the mouse is in, instead of one of its own.
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    yield from sidebar.open_part("Evaluation", "Results")
    yield from sidebar.press_button("Evaluation", "wayfarer.write_report")
    yield from editors.choose_folder(str(folder), lambda: keep_picture("35_folder_of_the_report"))
    yield from hand.until(opened.exists, "the page to be opened")
    yield from hand.work_is_done()
    page = Path(opened.read_text("utf-8").strip().removeprefix("file://"))
    text = page.read_text("utf-8")
    note("page", page.relative_to(folder).as_posix())
    note("ends", text.rstrip().endswith("</html>"))
    note("headings", re.findall("<h2>(.*?)</h2>", text))
    note("pictures", text.count("<svg") + text.count("<img"))
    note("files", {path.name: path.stat().st_size for path in page.parent.iterdir()})
    keep_picture("36_report_is_written")


def export_results(note) -> hand.Turns:
    """Everything that was found out, as files."""
    folder = JOB / "exported"
    folder.mkdir()
    yield from sidebar.press_button("Evaluation", "wayfarer.export_results")
    yield from editors.choose_folder(str(folder), lambda: keep_picture("37_folder_of_the_results"))
    yield from hand.until(lambda: (folder / "map.png").exists(), "the files")
    yield from hand.work_is_done()
    note("files", {path.name: path.stat().st_size for path in folder.iterdir()})
    note("findings", list(findings()))
    yield from sidebar.close_part("Evaluation", "Results")
