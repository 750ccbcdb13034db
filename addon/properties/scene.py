"""Everything that Wayfarer keeps in a scene."""

import bpy
from bpy.props import CollectionProperty, IntProperty, PointerProperty

from ..clip_actions import character_actions
from .clips import WayfarerClip, WayfarerContactSettings
from .embedding import WayfarerEmbeddingSettings
from .environment import WayfarerEnvironmentSettings
from .floor_map import WayfarerMapSettings
from .motion_graph import WayfarerGraphSettings
from .walk import WayfarerWalkSettings


def _on_character(settings, _) -> None:
    settings.graph.forget_weights()
    settings.refresh_clips()


class WayfarerSceneSettings(bpy.types.PropertyGroup):
    """Everything that Wayfarer keeps in a scene."""

    character: PointerProperty(
        type=bpy.types.Object,
        name="Character",
        description="The armature that is to walk",
        poll=lambda _, obj: obj.type == "ARMATURE",
        update=_on_character,
        options=set(),
    )
    clips: CollectionProperty(type=WayfarerClip)
    active_clip: IntProperty(name="Active Clip", description="The clip chosen in the list", options=set())
    contacts: PointerProperty(type=WayfarerContactSettings)
    graph: PointerProperty(type=WayfarerGraphSettings)
    environment: PointerProperty(type=WayfarerEnvironmentSettings)
    embedding: PointerProperty(type=WayfarerEmbeddingSettings)
    map: PointerProperty(type=WayfarerMapSettings)
    walk: PointerProperty(type=WayfarerWalkSettings)

    def refresh_clips(self) -> int:
        """List the actions that animate the character, keeping what was switched off; returns how many are new."""
        unused = {clip.action for clip in self.clips if not clip.use}
        known = {clip.action for clip in self.clips}
        actions = character_actions(self.character) if self.character else []
        self.clips.clear()
        for action in actions:
            clip = self.clips.add()
            clip.action = action
            clip.use = action not in unused
        self.active_clip = min(self.active_clip, max(len(self.clips) - 1, 0))
        return sum(action not in known for action in actions)

    def used_actions(self) -> list[bpy.types.Action]:
        return [clip.action for clip in self.clips if clip.use and clip.action is not None]

    def active_action(self) -> bpy.types.Action | None:
        """The action chosen in the list of clips."""
        return self.clips[self.active_clip].action if 0 <= self.active_clip < len(self.clips) else None

    def replace_clip(self, action, others) -> None:
        """Untick ``action`` and list ``others`` right after it, ticked, the first of them chosen."""
        place = next(i for i, clip in enumerate(self.clips) if clip.action == action)
        self.clips[place].use = False
        for offset, other in enumerate(others, start=1):
            self.clips.add().action = other
            self.clips.move(len(self.clips) - 1, place + offset)
        self.active_clip = min(place + 1, len(self.clips) - 1) if others else place


CLASSES = (WayfarerSceneSettings,)
