"""The list of clips, and when their feet are on the ground."""

from dataclasses import astuple

import bpy

from ...core.motion.contacts import foot_contacts
from ...core.progress import Progress, portion
from ...core.report.contact_chart import ClipContacts, contact_chart
from ...core.report.page import Figure, Section
from ...core.report.table import Table, table
from ...core.wording import counted
from ..exports.report import open_page
from ..jobs import LongOperator
from ..results.clips import keep_contacts
from ..scene.inputs import check_any, read_character_steps
from .mixins import NeedsClips, NeedsRig


class WAYFARER_OT_refresh_clips(NeedsRig, bpy.types.Operator):
    bl_idname = "wayfarer.refresh_clips"
    bl_label = "Refresh Clips"
    bl_description = "Find all actions that animate the character"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.wayfarer
        new = settings.refresh_clips()
        if len(settings.clips) == 0:
            self.report({"WARNING"}, f"No action animates '{settings.character.name}'")
        else:
            self.report({"INFO"}, f"{counted(len(settings.clips), 'clip')}, {new} new")
        return {"FINISHED"}


class WAYFARER_OT_show_contacts(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.show_contacts"
    bl_label = "Show Contacts"
    bl_description = (
        "Draw when the left foot (blue) and the right foot (orange) of each ticked clip are planted, on a page in the "
        "browser"
    )

    def steps(self, context):
        scene = context.scene
        settings = scene.wayfarer.contacts.to_core(scene.wayfarer.character)
        read = yield from portion(read_character_steps(scene), 0.0, 0.5)
        check_any(scene, read)
        found = []
        for done, clip in enumerate(read.clips):
            yield Progress(0.5 + 0.5 * done / len(read.clips), f"Watching the feet of {clip.name}")
            found.append(ClipContacts(clip.name, clip.frame_rate, foot_contacts(clip, settings)))
        return found, read.seen

    def apply(self, context, result):
        found, seen = result
        for clip in found:
            keep_contacts(context.scene, clip.name, seen[clip.name], clip.shares)
        section = Section("When the left foot (blue) and the right foot (orange) are planted", _blocks(found))
        page = open_page("Contacts", context.scene.name, [section])
        self.report({"INFO"}, f"Contacts of {counted(len(found), 'clip')} are on the page '{page}'")


def _blocks(found: list[ClipContacts]) -> tuple[Figure, Table]:
    columns = ("clip", "share left planted", "share right planted", "share both", "share none")
    return Figure(contact_chart(found)), table(columns, [(clip.name, *astuple(clip.shares)) for clip in found])


CLASSES = (
    WAYFARER_OT_refresh_clips,
    WAYFARER_OT_show_contacts,
)
