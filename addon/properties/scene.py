"""Everything that Wayfarer keeps in a scene."""

from enum import Enum

import bpy
from bpy.props import CollectionProperty

from ..bridge.clip_actions import character_actions
from .character import WayfarerCharacterSettings
from .clips import WayfarerClip, WayfarerContactSettings
from .definitions import BoolProperty, EnumProperty, IntProperty, PointerProperty, enum_items
from .embedding import WayfarerEmbeddingSettings
from .environment import WayfarerEnvironmentSettings
from .evaluation import WayfarerEvaluationSettings
from .findings import WayfarerFinding
from .floor_map import WayfarerMapSettings, WayfarerOverlaySettings, map_changed
from .motion_graph import WayfarerGraphSettings
from .queries import WayfarerQuerySettings
from .tuning import WayfarerTuningSettings
from .walk import WayfarerWalkSettings


def _on_character(settings, _) -> None:
    settings.graph.forget_weights()
    settings.refresh_clips()


class ClipOrder(Enum):
    """In which order clips are listed."""

    NAME = "name"
    DURATION = "duration"
    DISTANCE = "distance"
    TURN = "turn"


class ClipFilter(Enum):
    """The clips that are listed."""

    ALL = "all"
    USED = "used"
    TAGGED = "tagged"
    FINDINGS = "findings"


def _on_others(settings, _) -> None:
    settings.refresh_clips()


class WayfarerSceneSettings(bpy.types.PropertyGroup):
    """Everything that Wayfarer keeps in a scene."""

    character: PointerProperty(
        type=bpy.types.Object,
        name="Character",
        description="The armature that is to walk",
        poll=lambda _, obj: obj.type == "ARMATURE",
        update=_on_character,
    )
    clips: CollectionProperty(type=WayfarerClip)
    active_clip: IntProperty(name="Active Clip", description="The clip chosen in the list")
    clip_columns: EnumProperty(
        items=[
            ("DURATION", "Duration", "Show how long each clip lasts"),
            ("DISTANCE", "Distance", "Show how far each clip goes, once the clips were examined or a graph was built"),
            ("TURN", "Turn", "Show by how much each clip turns, once the clips were examined or a graph was built"),
        ],
        name="Columns",
        description="What the list shows of each clip",
        default={"DURATION"},
        options={"ENUM_FLAG"},
    )
    clip_order: EnumProperty(
        items=enum_items(
            {
                ClipOrder.NAME: ("Name", "In the order of their names"),
                ClipOrder.DURATION: ("Duration", "The longest first"),
                ClipOrder.DISTANCE: ("Distance", "Those that go farthest first"),
                ClipOrder.TURN: ("Turn", "From the widest left turn to the widest right turn"),
            }
        ),
        name="Order",
        description="In which order the clips are listed",
        default=ClipOrder.NAME.name,
    )
    clip_filter: EnumProperty(
        items=enum_items(
            {
                ClipFilter.ALL: ("All", "All clips of the character"),
                ClipFilter.USED: ("Ticked", "Clips that are ticked"),
                ClipFilter.TAGGED: ("Tagged", "Clips of which some frames carry a tag"),
                ClipFilter.FINDINGS: ("Findings", "Clips in which something was found"),
            }
        ),
        name="Show",
        description="Which clips are listed",
        default=ClipFilter.ALL.name,
    )
    use_others: BoolProperty(
        name="Actions of Others",
        description="Also list actions that were made for other characters, if they move bones of this one",
        default=False,
        update=_on_others,
    )
    body: PointerProperty(type=WayfarerCharacterSettings)
    contacts: PointerProperty(type=WayfarerContactSettings)
    graph: PointerProperty(type=WayfarerGraphSettings)
    environment: PointerProperty(type=WayfarerEnvironmentSettings)
    embedding: PointerProperty(type=WayfarerEmbeddingSettings)
    map: PointerProperty(type=WayfarerMapSettings)
    overlay: PointerProperty(type=WayfarerOverlaySettings)
    evaluation: PointerProperty(type=WayfarerEvaluationSettings)
    tuning: PointerProperty(type=WayfarerTuningSettings)
    queries: PointerProperty(type=WayfarerQuerySettings)
    findings: CollectionProperty(type=WayfarerFinding)
    live: BoolProperty(
        name="Live",
        description="Embed again and repaint the map whenever obstacles, regions, the ground or settings change",
        default=False,
        update=map_changed,
    )
    walk: PointerProperty(type=WayfarerWalkSettings)
    keep_results: BoolProperty(
        name="Keep Results in File",
        description="Save motion graph, embedding and walk with the file, so that nothing has to be computed again "
        "when it is opened",
        default=True,
    )

    def refresh_clips(self) -> int:
        """List the actions that animate the character, keeping what was switched off; returns how many are new."""
        unused = {clip.action for clip in self.clips if not clip.use}
        weights = {clip.action: clip.weight for clip in self.clips}
        actions = character_actions(self.character, self.use_others) if self.character else []
        self.clips.clear()
        for action in actions:
            clip = self.clips.add()
            clip.action = action
            clip.use = action not in unused
            clip.weight = weights.get(action, clip.weight)
        self.active_clip = min(self.active_clip, max(len(self.clips) - 1, 0))
        self.body.look()
        return sum(action not in weights for action in actions)

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
