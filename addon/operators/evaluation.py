"""Questions about the embedding: an operator for each topic that has one, the charts, and the clips that can go."""

import bpy
from bpy.props import EnumProperty

from ...core.errors import EvaluationError
from ...core.report.finding import Finding, Topic
from ...core.report.topics import PRUNING_CURVE, TOPICS
from ...core.wording import counted
from ..exports.report import open_finding
from ..jobs import LongOperator
from ..results.clips import deletable_actions
from ..results.findings import DELETION, find_finding, keep_finding
from ..results.store import embedding_of, whole_of
from ..session import redraw
from .mixins import AsksEmbedding, LooksAtEmbedding, Needs, reports_errors


class _FindsOut(LongOperator):
    """Mixin: what was found out on a topic is kept with the scene."""

    topic: Topic

    def steps(self, context):
        embedding = (whole_of if self.topic.of_whole else embedding_of)(context.scene)
        assert self.topic.find is not None
        return self.topic.find(embedding, context.scene.wayfarer.evaluation.to_core())

    def apply(self, context, result: Finding):
        keep_finding(context.scene, result)
        # Lists are drawn from it.
        redraw()
        self.report({"INFO"}, result.summarised())
        if self.topic is PRUNING_CURVE:
            open_finding(context.scene, self.topic)
        self.warn_if_stale(context.scene)


def _operator(topic: Topic) -> type[bpy.types.Operator]:
    asks = LooksAtEmbedding if topic.of_empty else AsksEmbedding
    members = {
        "__doc__": topic.help,
        "bl_idname": f"wayfarer.{topic.operator}",
        "bl_label": topic.button,
        "bl_description": topic.help,
        "topic": topic,
    }
    return type(f"WAYFARER_OT_{topic.operator}", (asks, _FindsOut, bpy.types.Operator), members)


_DRAWN = {topic.name: topic for topic in TOPICS if topic.chart is not None}


class WAYFARER_OT_show_chart(bpy.types.Operator):
    bl_idname = "wayfarer.show_chart"
    bl_label = "Show Chart"
    bl_description = "Draw these numbers on a page in the browser"
    bl_options = {"REGISTER", "UNDO"}

    finding: EnumProperty(
        items=[(name, topic.title, "") for name, topic in _DRAWN.items()],
        name="Finding",
        description="What to draw",
        options={"SKIP_SAVE"},
    )

    @reports_errors
    def execute(self, context):
        topic = _DRAWN[self.finding]
        if find_finding(context.scene, topic) is None:
            raise EvaluationError(f"'{topic.title}' has not been found out yet; press its button first")
        page = open_finding(context.scene, topic)
        if page is None:
            raise EvaluationError(f"'{topic.title}' has nothing to draw")
        self.report({"INFO"}, f"The chart is on the page '{page}'")


class WAYFARER_OT_untick_clips(Needs, bpy.types.Operator):
    bl_idname = "wayfarer.untick_clips"
    bl_label = "Untick These Clips"
    bl_description = (
        "Untick the deletable clips in the list of clips; then build the motion graph and embed again. The actions "
        "themselves stay"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def problem(cls, context):
        found = find_finding(context.scene, DELETION)
        if found is None:
            return "Find deletable clips first"
        return "" if found.rows else "No clip can be deleted"

    def execute(self, context):
        scene = context.scene
        names, kept = deletable_actions(scene)
        ticked = [clip for clip in scene.wayfarer.clips if clip.use and clip.action and clip.action.name in names]
        for clip in ticked:
            clip.use = False
        if not ticked:
            self.report({"WARNING"}, "None of these clips is ticked any longer")
            return {"CANCELLED"}
        if kept:
            self.report({"WARNING"}, f"Only one of the clip and its mirror image can go: {', '.join(kept)} stay ticked")
        self.report({"INFO"}, f"{counted(len(ticked), 'clip')} unticked; build the motion graph and embed again")
        return {"FINISHED"}


CLASSES = (
    *(_operator(topic) for topic in TOPICS if topic.operator),
    WAYFARER_OT_show_chart,
    WAYFARER_OT_untick_clips,
)
