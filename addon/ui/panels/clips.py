"""The character's clips: which take part, what is wrong with them, when their feet are planted."""

import bpy

from ....core.wording import of, share, time, turn
from ...bridge.clip_actions import action_seconds
from ...bridge.tags import tag_names
from ...bridge.units import scene_length
from ...results.advice import clip_advice
from ...results.clips import contacts_of, health_of, motion_of
from ..drawing import Sidebar, Step, draw_numbers, draw_sentences, draw_wrapped, split_properties


class WAYFARER_PT_clips(Step, bpy.types.Panel):
    bl_label = "Clips"

    def result_is_there(self, scene):
        return any(clip.use for clip in scene.wayfarer.clips)

    def draw(self, context):
        layout, scene = self.layout, context.scene
        settings = scene.wayfarer
        layout.prop(settings, "character", text="", icon="OUTLINER_OB_ARMATURE")
        if settings.character is None:
            draw_sentences(context, layout, ["Choose an armature with actions, or add one"], "INFO")
            column = layout.column(align=True)
            column.operator("wayfarer.add_sample_character", icon="ARMATURE_DATA")
            column.operator("wayfarer.import_motion", icon="IMPORT")
            return
        draw_sentences(context, layout, clip_advice(scene))
        row = layout.row()
        row.template_list("WAYFARER_UL_clips", "", settings, "clips", settings, "active_clip", rows=5, maxrows=8)
        column = row.column(align=True)
        column.operator("wayfarer.refresh_clips", text="", icon="FILE_REFRESH")
        column.operator("wayfarer.import_motion", text="", icon="IMPORT")
        column.operator("wayfarer.append_actions", text="", icon="APPEND_BLEND")
        column.prop(settings, "use_others", text="", icon="COMMUNITY")
        if not settings.clips:
            draw_sentences(context, layout, ["No action moves its bones; import motion, or append actions"], "INFO")
            return
        used = [clip.action for clip in settings.clips if clip.use and clip.action]
        seconds = sum(action_seconds(scene, action) for action in used)
        layout.label(text=f"{of(len(used), len(settings.clips))} in use, {time(seconds)}")


class _ClipsPart(Sidebar):
    bl_parent_id = "WAYFARER_PT_clips"

    @classmethod
    def poll(cls, context):
        return context.scene.wayfarer.character is not None


class WAYFARER_PT_understood(_ClipsPart, bpy.types.Panel):
    bl_label = "Understood"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        settings, body = scene.wayfarer, scene.wayfarer.body
        if body.problem:
            draw_sentences(context, layout, [body.problem])
            return
        column = layout.column()
        column.prop(body, "root", icon="BONE_DATA", placeholder=f"{body.found_root} (found)")
        for name, found in (("left_foot", body.found_left), ("right_foot", body.found_right)):
            shown = f"{found} (found)" if found else "none found"
            column.prop(settings.contacts, name, icon="BONE_DATA", placeholder=shown)
        column.prop(body, "facing")
        used = [clip.action for clip in settings.clips if clip.use and clip.action]
        known = [(action, health) for action in used if (health := health_of(scene, action)) is not None]
        other = [action.name for action, health in known if health.doubts_character]
        agree = of(len(known) - len(other), len(known)) + " clips agree" if known else "not examined"
        draw_numbers(
            layout,
            (
                ("Faces", body.facing_words()),
                ("Up", body.found_up or "not known"),
                ("Height by Its Legs", scene_length(scene, body.height)),
                ("Motion", agree),
            ),
        )
        if other:
            draw_sentences(context, layout, [f"'{other[0]}' shows it otherwise: see Health"])
        row = layout.row(align=True)
        row.operator("wayfarer.set_height", icon="FULLSCREEN_ENTER")
        row.operator("wayfarer.refresh_clips", text="Look Again", icon="FILE_REFRESH")


class WAYFARER_PT_clip(_ClipsPart, bpy.types.Panel):
    bl_label = "Clip"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        action = scene.wayfarer.active_action()
        if action is None:
            layout.label(text="No clip is chosen", icon="INFO")
            return
        layout.prop(action, "name", text="Name")
        column = layout.column()
        column.active = action.library is None
        column.prop(action, "use_frame_range", text="Own Range")
        row = column.row(align=True)
        row.active = action.use_frame_range
        row.prop(action, "frame_start", text="Frames")
        row.prop(action, "frame_end", text="")
        motion, tags = motion_of(scene, action), tag_names(action)
        draw_numbers(
            layout,
            (
                ("Duration", time(action_seconds(scene, action))),
                ("Distance", scene_length(scene, motion.distance) if motion else "not examined"),
                ("Turn", turn(motion.turn) if motion else "not examined"),
                ("Tags", ", ".join(tags) if tags else "none"),
            ),
        )


class WAYFARER_PT_health(_ClipsPart, bpy.types.Panel):
    bl_label = "Health"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context):
        scene = context.scene
        known = [health_of(scene, clip.action) for clip in scene.wayfarer.clips if clip.use and clip.action]
        ill = sum(health is not None and not health.is_healthy for health in known)
        if ill:
            self.layout.label(text=of(ill, len(known)), icon="ERROR")
        elif known and None not in known:
            self.layout.label(text="", icon="CHECKMARK")

    def draw(self, context):
        layout, scene = self.layout, context.scene
        row = layout.row(align=True)
        row.operator("wayfarer.examine_clips", icon="VIEWZOOM")
        row.operator("wayfarer.fix_all", icon="CHECKMARK")
        action = scene.wayfarer.active_action()
        if action is None:
            layout.label(text="No clip is chosen", icon="INFO")
            return
        health = health_of(scene, action)
        if health is None:
            row = layout.row()
            row.active = False
            row.label(text=f"{action.name}: not examined", icon="QUESTION", translate=False)
        elif health.is_healthy:
            layout.label(text=f"{action.name}: nothing is wrong", icon="CHECKMARK", translate=False)
        elif health.problem:
            box = layout.box()
            box.label(text="Cannot Be Read", icon="CANCEL")
            draw_wrapped(context, box, health.problem)
        for number, (title, sentence, remedy) in enumerate(health.treatments if health else ()):
            box = layout.box()
            box.label(text=title, icon="ERROR")
            draw_wrapped(context, box, sentence)
            if remedy:
                button = box.operator("wayfarer.apply_remedy", text=remedy)
                button.action, button.finding = action.name, number


class WAYFARER_PT_contacts(_ClipsPart, bpy.types.Panel):
    bl_label = "Contacts"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        settings = scene.wayfarer.contacts
        column = layout.column(align=True)
        column.prop(settings, "height")
        column.prop(settings, "speed")
        column = layout.column(align=True)
        column.prop(settings, "release_height")
        column.prop(settings, "release_speed")
        layout.operator("wayfarer.show_contacts", icon="IMAGE_DATA")
        action = scene.wayfarer.active_action()
        shares = contacts_of(scene, action) if action else None
        if shares is None:
            return
        layout.label(text=action.name, icon="ACTION", translate=False)
        draw_numbers(
            layout,
            (
                ("Left Planted", share(shares.left)),
                ("Right Planted", share(shares.right)),
                ("Both", share(shares.both)),
                ("None", share(shares.none)),
            ),
        )


PANELS = (WAYFARER_PT_clips, WAYFARER_PT_understood, WAYFARER_PT_clip, WAYFARER_PT_health, WAYFARER_PT_contacts)
