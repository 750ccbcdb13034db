"""Show when the feet of each clip are on the ground."""

import bpy

from ...core.motion.contacts import foot_contacts
from ...core.progress import Progress, portion
from ..bridge.text import counted
from ..jobs import LongOperator
from ..render.contact_strip import ClipContacts, contact_strip
from ..render.image_editor import show_in_editor
from ..render.raster import put_in_image
from ..results.state import keep_contacts
from ..scene.inputs import read_character_steps
from .mixins import NeedsClips

IMAGE_NAME = "Wayfarer Contacts"


class WAYFARER_OT_show_contacts(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.show_contacts"
    bl_label = "Show Contacts"
    bl_description = (
        "Draw when the left foot (blue) and the right foot (orange) of each ticked clip are planted, as an image in "
        "the Image Editor"
    )

    def steps(self, context):
        scene = context.scene
        settings = scene.wayfarer.contacts.to_core(scene.wayfarer.character)
        read = yield from portion(read_character_steps(scene), 0.0, 0.5)
        found = []
        for done, clip in enumerate(read.clips):
            yield Progress(0.5 + 0.5 * done / len(read.clips), f"Watching the feet of {clip.name}")
            found.append(ClipContacts(clip.name, clip.frame_rate, foot_contacts(clip, settings)))
        return found, read.seen

    def apply(self, context, result):
        found, seen = result
        for clip in found:
            keep_contacts(context.scene, clip.name, seen[clip.name], clip.shares)
        image = put_in_image(IMAGE_NAME, contact_strip(found))
        shown = show_in_editor(context, image)
        self.report(
            {"INFO"},
            f"Contacts of {counted(len(found), 'clip')} are in the image '{image.name}'"
            + ("" if shown else "; open an Image Editor to see it"),
        )
