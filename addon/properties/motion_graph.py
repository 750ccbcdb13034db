"""Settings of the motion graph."""

import bpy
from bpy.props import CollectionProperty

from ...core.motion.contacts import ContactSettings
from ...core.motion.distance import CostSettings
from ...core.motion.graph_settings import HIGHEST_RATE, MotionGraphSettings, ThresholdMode
from .definitions import BoolProperty, EnumProperty, FloatProperty, IntProperty, enum_items

_GRAPH = MotionGraphSettings()

_THRESHOLD_ITEMS = enum_items(
    {
        ThresholdMode.COST: ("Cost", "Link all poses that are alike enough"),
        ThresholdMode.LINKS: ("Links", "As many links as possible, up to a number"),
        ThresholdMode.COVERAGE: ("Coverage", "As smooth as possible, while enough of the motion is kept"),
    }
)


class WayfarerJointWeight(bpy.types.PropertyGroup):
    """A bone, by its name, and how much its pose counts."""

    weight: FloatProperty(
        name="Weight",
        description="How much the angle of this bone counts when two poses are compared",
        subtype="FACTOR",
        default=1.0,
        min=0.0,
        max=1.0,
    )


class WayfarerGraphSettings(bpy.types.PropertyGroup):
    """Settings of the motion graph."""

    frame_rate: FloatProperty(
        name="Frame Rate",
        description="Samples per second at which motion is compared and cut",
        default=_GRAPH.frame_rate,
        min=5.0,
        max=HIGHEST_RATE,
        soft_max=120.0,
        precision=1,
    )
    min_segment_duration: FloatProperty(
        name="Min Segment",
        description="Shortest time between two cuts of a clip; shorter segments respond faster, longer ones keep "
        "more of the recorded motion",
        subtype="TIME_ABSOLUTE",
        default=_GRAPH.min_segment_duration,
        min=0.05,
        soft_max=2.0,
    )
    threshold_mode: EnumProperty(
        items=_THRESHOLD_ITEMS,
        name="Threshold",
        description="What decides how different two poses may be to be linked",
        default=_GRAPH.threshold_mode.name,
    )
    max_cost: FloatProperty(
        name="Max Cost",
        description="How different two poses may be to be linked; lower makes smoother transitions, higher more "
        "of them (squared angles of the joints, in square radians)",
        default=_GRAPH.max_cost,
        min=0.001,
        soft_max=1.0,
        step=1,
        precision=3,
    )
    max_links: IntProperty(
        name="Max Links",
        description="The motion graph gets as many links as possible, but not more than this",
        default=_GRAPH.max_links,
        min=1,
        soft_max=5000,
    )
    min_coverage: FloatProperty(
        name="Motion Kept",
        description="The transitions are as smooth as they can be while at least this part of the motion is kept",
        subtype="FACTOR",
        default=_GRAPH.min_coverage,
        min=0.01,
        max=1.0,
    )
    mirror_clips: BoolProperty(
        name="Mirror Clips",
        description="Also use every clip with left and right exchanged; needs bones named as left and right, and a "
        "symmetric rest pose",
        default=False,
    )
    steady_heading: BoolProperty(
        name="Steady Heading",
        description="Take the character to head where it goes, not where its hips swing at each step",
        default=False,
    )
    use_custom_weights: BoolProperty(
        name="Custom Weights",
        description="Compare poses by the weights in this list instead of those guessed from the names of the bones",
        default=False,
    )
    joint_weights: CollectionProperty(type=WayfarerJointWeight)
    active_joint_weight: IntProperty(name="Active Weight", description="The bone chosen in the list")

    @property
    def mode(self) -> ThresholdMode:
        return ThresholdMode[self.threshold_mode]

    def to_core(self, contacts: ContactSettings | None = None) -> MotionGraphSettings:
        """Return the core's settings; what the threshold mode does not heed keeps its default."""
        heeded = {}
        if self.mode is ThresholdMode.LINKS:
            heeded["max_links"] = self.max_links
        elif self.mode is ThresholdMode.COVERAGE:
            heeded["min_coverage"] = self.min_coverage
        weights = {item.name: item.weight for item in self.joint_weights} if self.use_custom_weights else None
        return MotionGraphSettings(
            frame_rate=self.frame_rate,
            min_segment_duration=self.min_segment_duration,
            max_cost=self.max_cost,
            threshold_mode=self.mode,
            cost=CostSettings(joint_weights=weights),
            contacts=contacts or ContactSettings(),
            **heeded,
        )

    def set_weights(self, weights: dict[str, float]) -> None:
        """Fill the list; bones in the order given."""
        self.joint_weights.clear()
        for name, weight in weights.items():
            item = self.joint_weights.add()
            item.name, item.weight = name, weight
        self.active_joint_weight = 0

    def forget_weights(self) -> None:
        """Another character has other bones."""
        self.joint_weights.clear()
        self.use_custom_weights = False


CLASSES = (WayfarerJointWeight, WayfarerGraphSettings)
