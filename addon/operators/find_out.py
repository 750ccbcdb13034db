"""Find something out about the embedding: an operator for each topic that has one."""

import bpy

from ...core.report.finding import Finding, Topic
from ...core.report.topics import PRUNING_CURVE, TOPICS
from ..exports.report import open_finding
from ..jobs import LongOperator
from ..results.findings import keep_finding
from ..results.store import embedding_of, whole_of
from ..session import redraw
from .asks_embedding import AsksEmbedding, LooksAtEmbedding


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


CLASSES = tuple(_operator(topic) for topic in TOPICS if topic.operator)
