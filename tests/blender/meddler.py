"""Someone who changes whatever is in a file, at random, without regard to what is made of it."""

import math
import os
import random
from pathlib import Path

import bmesh
import bpy

NAMES = ["Ünïcode 名", "x" * 60, "a.001", "Walk", "Wayfarer", "Wayfarer Floor", "", "50 %/\\:*?"]

OWN_MATERIAL = "Artist's Own"


class Meddler:
    """Does one random thing to the file at a time; remembers what, for the message of a failure.

    Attributes
    ----------
    done : list of str
    """

    def __init__(self, seed: int, folder: Path):
        self.random = random.Random(seed)
        self.folder, self.done = folder, []
        self.file, self.library = str(folder / "saved again.blend"), str(folder / "library.blend")

    @property
    def scene(self):
        return bpy.context.scene

    @property
    def settings(self):
        return bpy.context.scene.wayfarer

    def note(self, what: object) -> None:
        self.done[-1] += f" {what}"

    def choose(self, things):
        things = list(things)
        return self.random.choice(things) if things else None

    def push(self) -> None:
        bpy.ops.ed.undo_push(message=self.done[-1][:60])

    def undo(self) -> None:
        for _ in range(self.random.randint(1, 3)):
            if bpy.ops.ed.undo.poll():
                bpy.ops.ed.undo()

    def redo(self) -> None:
        if bpy.ops.ed.redo.poll():
            bpy.ops.ed.redo()

    def move(self) -> None:
        obj = self.choose(obj for obj in self.scene.objects if obj.library is None)
        if obj is None:
            return
        what = self.random.choice(["move", "move", "turn", "tilt", "grow", "hide"])
        self.note(f"{what} {obj.name}")
        if what == "move":
            obj.location.x += self.random.choice([-0.5, 0.25, 2.0])
        elif what == "turn":
            obj.rotation_euler.z += 0.5
        elif what == "tilt":
            obj.rotation_euler.x += self.random.choice([-0.4, 0.02, math.pi / 2])
        elif what == "grow":
            obj.scale = [factor * self.random.choice([0.5, 1.5]) for factor in (1,) * 3]
        else:
            obj.hide_viewport = not obj.hide_viewport
        self.push()

    def reshape(self) -> None:
        obj = self.choose(obj for obj in self.scene.objects if obj.type == "MESH" and obj.library is None)
        if obj is None:
            return
        self.note(obj.name)
        chance = self.random.random()
        if chance < 0.1 and obj.mode == "OBJECT" and obj.data.library is None:
            self.note("merge")
            shape = bmesh.new()
            shape.from_mesh(obj.data)
            bmesh.ops.remove_doubles(shape, verts=shape.verts, dist=1e-4)
            shape.to_mesh(obj.data)
            shape.free()
        elif chance < 0.4 and not obj.modifiers:
            obj.modifiers.new("Array", "ARRAY").count = 2
        elif obj.modifiers and self.random.random() < 0.5:
            obj.modifiers.clear()
        elif len(obj.data.vertices) and obj.mode == "OBJECT" and obj.data.library is None:
            obj.data.vertices[0].co.x += 0.2
            obj.data.update()
        self.push()

    def color(self) -> None:
        """Change what an object looks like: its materials, and the colours that are painted on it."""
        kinds = ("MESH", "CURVE")
        obj = self.choose(obj for obj in self.scene.objects if obj.type in kinds and obj.mode == "OBJECT")
        if obj is None or obj.data is None or obj.data.library is not None:
            return
        what = self.random.choice(["clear", "none", "own", "attribute", "unpaint"])
        self.note(f"{what} {obj.name}")
        if what == "clear":
            obj.data.materials.clear()
        elif what in ("none", "own"):
            material = bpy.data.materials.new(OWN_MATERIAL) if what == "own" else None
            if len(obj.data.materials):
                obj.data.materials[0] = material
            else:
                obj.data.materials.append(material)
        elif obj.type == "MESH":
            attributes = obj.data.color_attributes
            if what == "attribute":
                attributes.active_color = attributes.new("Own", "BYTE_COLOR", "CORNER")
            elif len(attributes):
                attributes.remove(attributes[0])
        self.push()

    def purge(self) -> None:
        """Remove what nobody uses, as in File > Clean Up."""
        bpy.data.orphans_purge(do_recursive=True)
        self.push()

    def point(self) -> None:
        """Choose other objects and collections in the panels."""
        groups = (self.settings, self.settings.environment, self.settings.walk, self.settings.queries)
        pointers = [
            (group, prop)
            for group in groups
            for prop in group.bl_rna.properties
            if prop.type == "POINTER" and prop.fixed_type.identifier in ("Object", "Collection")
        ]
        group, prop = self.random.choice(pointers)
        things = bpy.data.objects if prop.fixed_type.identifier == "Object" else bpy.data.collections
        fitting = [thing for thing in things if prop.identifier != "character" or thing.type == "ARMATURE"]
        thing = self.choose([*fitting, None]) if self.random.random() < 0.3 else self.choose(fitting)
        self.note(f"{prop.identifier} = {thing.name if thing else None}")
        setattr(group, prop.identifier, thing)
        self.push()

    def frame(self) -> None:
        if self.random.random() < 0.2:
            self.scene.render.fps = self.random.choice([24, 30, 60])
        self.scene.frame_set(self.random.randint(-5, 200))
        self.push()

    def edit_mode(self) -> None:
        obj = self.choose(obj for obj in bpy.context.view_layer.objects if obj.type == "MESH" and obj.visible_get())
        if obj is not None and obj.library is None and obj.data.library is None:
            self.note(obj.name)
            if bpy.context.mode == "OBJECT":
                bpy.context.view_layer.objects.active = obj
            if bpy.ops.object.mode_set.poll():
                bpy.ops.object.mode_set(mode="EDIT" if bpy.context.mode == "OBJECT" else "OBJECT")
                self.push()

    def key(self) -> None:
        """Change what a clip plays: keys, how they are joined, modifiers, frame range, tags."""
        clip = self.choose(clip for clip in self.settings.clips if clip.action and clip.action.library is None)
        if clip is None or not clip.action.layers:
            return
        action = clip.action
        curves = [curve for slot in action.slots for curve in action.layers[0].strips[0].channelbag(slot).fcurves]
        curve = self.choose(curve for curve in curves if len(curve.keyframe_points) > 2)
        what = self.random.choice(["value", "interpolation", "thin", "handle", "modifier", "mute", "range", "tag"])
        self.note(f"{what} {action.name}")
        if what == "range":
            action.use_frame_range = not action.use_frame_range
            action.frame_start, action.frame_end = 5, 50
        elif what == "tag":
            action.pose_markers.new(self.random.choice(["step", "/step"])).frame = self.random.randint(1, 40)
        elif curve is not None:
            points = curve.keyframe_points
            if what == "value":
                points[self.random.randrange(len(points))].co.y += 0.05
            elif what == "interpolation":
                for point in points:
                    point.interpolation = self.random.choice(["CONSTANT", "LINEAR", "BEZIER"])
            elif what == "thin":
                for index in range(len(points) - 2, 0, -1):
                    if index % 4:
                        points.remove(points[index], fast=True)
            elif what == "handle":
                for point in points:
                    point.interpolation = "BEZIER"
                    point.handle_right_type = point.handle_left_type = "FREE"
                    point.handle_right.y += 0.3
            elif what == "modifier":
                if curve.modifiers:
                    curve.modifiers.remove(curve.modifiers[0])
                else:
                    curve.modifiers.new("NOISE").strength = 0.2
            else:
                curve.mute = not curve.mute
            curve.update()
        self.push()

    def rig(self) -> None:
        """Change what the character is made of."""
        rig = self.settings.character
        if rig is None or rig.library is not None or rig.data.library is not None:
            return
        bone = self.choose(rig.pose.bones)
        what = self.random.choice(["mode", "constraint", "inherit", "forward", "muted", "deform"])
        self.note(f"{what} {bone.name}")
        if what == "mode":
            bone.rotation_mode = self.random.choice(["QUATERNION", "XYZ"])
        elif what == "constraint":
            if bone.constraints:
                bone.constraints[0].influence = 0.5
            else:
                bone.constraints.new("LIMIT_ROTATION").use_limit_x = True
        elif what == "muted":
            for constraint in (c for each in rig.pose.bones for c in each.constraints):
                constraint.mute = True
        elif what == "inherit":
            bone.bone.use_inherit_rotation = not bone.bone.use_inherit_rotation
        elif what == "deform":
            bone.bone.use_deform = not bone.bone.use_deform
        elif "wayfarer_forward" in rig:
            del rig["wayfarer_forward"]
        else:
            rig["wayfarer_forward"] = [0.0, 1.0, 0.0]
        self.push()

    # ------------------------------------------------------------------------------------ datablocks and files

    def rename(self) -> None:
        clips = [clip.action for clip in self.settings.clips if clip.action]
        blocks = [*bpy.data.objects, *clips, *bpy.data.collections, *bpy.data.scenes]
        block = self.choose(block for block in blocks if block.library is None)
        if block is not None:
            self.note(block.name)
            block.name = self.random.choice([name for name in NAMES if name])
            self.push()

    def delete(self) -> None:
        blocks = [obj for obj in bpy.data.objects if obj.type != "ARMATURE" or self.random.random() < 0.1]
        blocks += [clip.action for clip in self.settings.clips if clip.action and self.random.random() < 0.3]
        blocks += [collection for collection in bpy.data.collections if self.random.random() < 0.3]
        block = self.choose(blocks)
        if block is not None:
            self.note(block.name)
            bpy.data.batch_remove([block])
            self.push()

    def copy_scene(self) -> None:
        if len(bpy.data.scenes) < 4:
            kind = self.random.choice(["LINK_COPY", "FULL_COPY", "EMPTY"])
            self.note(kind)
            bpy.ops.scene.new(type=kind)
            self.push()

    def change_scene(self) -> None:
        scene = self.choose(scene for scene in bpy.data.scenes if scene.library is None)
        if bpy.context.mode == "OBJECT":
            self.note(scene.name)
            bpy.context.window.scene = scene
            self.push()

    def delete_scene(self) -> None:
        if bpy.ops.scene.delete.poll() and bpy.context.mode == "OBJECT":
            self.note(self.scene.name)
            bpy.ops.scene.delete()
            self.push()

    def second_character(self) -> None:
        rig = self.settings.character
        if rig is not None and len(bpy.data.armatures) < 3:
            other = rig.copy()
            other.data = rig.data.copy()
            self.scene.collection.objects.link(other)
            if self.random.random() < 0.5:
                self.settings.character = other
            self.push()

    def link(self) -> None:
        """Link something of another file, with an override or without."""
        if not os.path.exists(self.library):
            bpy.ops.wm.save_as_mainfile(filepath=self.library, copy=True)
        kind = self.random.choice(["collections", "collections", "scenes", "actions"])
        self.note(kind)
        with bpy.data.libraries.load(self.library, link=self.random.random() < 0.7) as (there, here):
            setattr(here, kind, list(getattr(there, kind))[:2])
        for thing in getattr(here, kind):
            if kind == "collections" and thing is not None and thing.name not in self.scene.collection.children:
                if thing.library is not None and self.random.random() < 0.6:
                    thing.override_hierarchy_create(self.scene, bpy.context.view_layer)
                else:
                    self.scene.collection.children.link(thing)
        self.push()

    def save(self) -> None:
        if bpy.context.mode == "OBJECT" or self.random.random() < 0.5:
            bpy.ops.wm.save_as_mainfile(filepath=self.file)

    def reopen(self) -> None:
        if os.path.exists(self.file):
            bpy.ops.wm.open_mainfile(filepath=self.file)
