"""The clips that take part, and when their feet are on the ground."""

import bpy

from ...core.errors import ClipError
from ...core.motion.contacts import ContactSettings
from .definitions import BoolProperty, FloatProperty, PointerProperty, StringProperty
from .graph_names import bone_names

_CONTACTS = ContactSettings()


class WayfarerClip(bpy.types.PropertyGroup):
    """An action of the character and whether it takes part."""

    action: PointerProperty(type=bpy.types.Action, name="Action", description="A motion of the character")
    use: BoolProperty(name="Use", description="Let this action take part in the motion graph", default=True)
    weight: FloatProperty(
        name="Weight",
        description="How often this clip is played, beside others, by walks that prefer clips by weight; with 0, only "
        "where nothing else can be played",
        default=1.0,
        min=0.0,
        soft_max=10.0,
    )


class WayfarerContactSettings(bpy.types.PropertyGroup):
    """The bones of the feet, and when they count as planted."""

    left_foot: StringProperty(
        name="Left Foot",
        description="Bone of the left foot, at the ankle; its toes go with it. Found from the shape of the rig and "
        "the names of its bones where no foot is chosen",
        search=bone_names,
    )
    right_foot: StringProperty(
        name="Right Foot",
        description="Bone of the right foot, at the ankle; its toes go with it. Found from the shape of the rig and "
        "the names of its bones where no foot is chosen",
        search=bone_names,
    )
    height: FloatProperty(
        name="Planted Below",
        description="A foot is planted where it is lower than this above where it stands in the clip, and slow",
        subtype="DISTANCE",
        default=_CONTACTS.height,
        min=0.001,
        soft_max=0.3,
        precision=3,
    )
    release_height: FloatProperty(
        name="Lifted Above",
        description="A planted foot is lifted when it rises higher than this",
        subtype="DISTANCE",
        default=_CONTACTS.release_height,
        min=0.001,
        soft_max=0.5,
        precision=3,
    )
    speed: FloatProperty(
        name="Slower Than",
        description="A foot is planted where it is slower than this, and low",
        unit="VELOCITY",
        default=_CONTACTS.speed,
        min=0.01,
        soft_max=2.0,
    )
    release_speed: FloatProperty(
        name="Faster Than",
        description="A planted foot is lifted when it gets faster than this",
        unit="VELOCITY",
        default=_CONTACTS.release_speed,
        min=0.01,
        soft_max=3.0,
    )

    def values(self) -> tuple:
        """Everything that planted frames depend on, whether or not it makes sense together."""
        return (self.left_foot, self.right_foot, self.height, self.release_height, self.speed, self.release_speed)

    def feet(self, armature_object) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
        """Bones of the left and of the right foot, ankle first, then toes; None if they are to be guessed.

        Raises ClipError if only one foot is chosen, or a bone that the armature lacks.
        """
        if not self.left_foot and not self.right_foot:
            return None
        chosen = []
        for side, name in (("left", self.left_foot), ("right", self.right_foot)):
            if not name:
                raise ClipError(f"No bone is chosen for the {side} foot; choose both feet or none under Understood.")
            bone = armature_object.data.bones.get(name)
            if bone is None:
                raise ClipError(
                    f"'{armature_object.name}' has no bone '{name}' for the {side} foot; choose another one "
                    "under Understood."
                )
            # A foot that branches has fingers, not toes.
            toes = tuple(child.name for child in bone.children) if len(bone.children) == 1 else ()
            chosen.append((name, *toes))
        return chosen[0], chosen[1]

    def to_core(self, armature_object) -> ContactSettings:
        """Return the core's settings; ClipError as for :meth:`feet`, or if thresholds contradict each other."""
        return ContactSettings(
            height=self.height,
            release_height=self.release_height,
            speed=self.speed,
            release_speed=self.release_speed,
            feet=self.feet(armature_object),
        )


CLASSES = (WayfarerClip, WayfarerContactSettings)
