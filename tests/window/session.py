"""An artist's session, from installing the extension to opening the saved file again; run by Blender, in a window.

What was found is written as JSON, chapter by chapter; test_window reads it. The first chapter that fails ends the
session. Pictures of all that an artist sees on the way lie beside the file.
"""

import json
import os
import sys
import time
import traceback

import bpy

# The other scripts lie beside this one.
sys.path.insert(0, os.environ["WAYFARER_JOB"])
import asking_chapters
import delivering_chapters
import live_chapters
import making_chapters
import managing_chapters
import using_chapters
from scene_facts import JOB, keep_picture

facts: dict[str, dict] = {}

CHAPTERS = (
    making_chapters.install,
    making_chapters.look_around,
    making_chapters.add_character,
    making_chapters.add_room,
    making_chapters.show_environment,
    making_chapters.cancel_building,
    making_chapters.build,
    making_chapters.embed,
    making_chapters.cancel_embedding,
    making_chapters.paint,
    making_chapters.look_at_legend,
    making_chapters.undo_map,
    using_chapters.move_pillar,
    live_chapters.time_changes,
    live_chapters.time_few_links,
    live_chapters.drag_without_floor,
    using_chapters.ask_why_not,
    using_chapters.evaluate,
    using_chapters.walk,
    using_chapters.undo_walk,
    using_chapters.tune,
    using_chapters.query,
    asking_chapters.untick_clip,
    asking_chapters.choose_map,
    asking_chapters.pick_place,
    asking_chapters.reach_region,
    asking_chapters.walks_from,
    asking_chapters.charts,
    delivering_chapters.bake_otherwise,
    delivering_chapters.crowd,
    delivering_chapters.write_report,
    delivering_chapters.export_results,
    managing_chapters.add_region,
    managing_chapters.keep_preset,
    managing_chapters.light_theme,
    managing_chapters.large_interface,
    using_chapters.save_and_reopen,
    using_chapters.disable,
)


def session():
    for chapter in CHAPTERS:
        found = facts[chapter.__name__] = {}
        started = time.monotonic()
        try:
            yield from chapter(found.__setitem__)
        except Exception:
            found["failed"] = traceback.format_exc()
            keep_picture(f"failed_in_{chapter.__name__}")
            return
        finally:
            found["seconds"] = round(time.monotonic() - started, 1)
            (JOB / "facts.json").write_text(json.dumps(facts, indent=1), "utf-8")


def main() -> None:
    turns = session()
    # At once: the splash screen opens before the first turn.
    bpy.context.preferences.view.show_splash = False
    # Software draws this window: smooth edges cost seconds.
    bpy.context.preferences.system.viewport_aa = "OFF"

    def turn() -> float | None:
        try:
            next(turns)
        except StopIteration:
            bpy.ops.wm.quit_blender()
            return None
        return 0.005

    bpy.app.timers.register(turn, first_interval=0.5, persistent=True)


if __name__ == "__main__":
    main()
