"""Draw a finding as a chart."""

import bpy
from bpy.props import EnumProperty

from ...core.report.topics import TOPICS
from ..exports.report import open_finding
from ..results.findings import find_finding

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

    def execute(self, context):
        topic = _DRAWN[self.finding]
        if find_finding(context.scene, topic) is None:
            self.report({"ERROR"}, f"'{topic.title}' has not been found out yet; press its button first")
            return {"CANCELLED"}
        page = open_finding(context.scene, topic)
        if page is None:
            self.report({"ERROR"}, f"'{topic.title}' has nothing to draw")
            return {"CANCELLED"}
        self.report({"INFO"}, f"The chart is on the page '{page}'")
        return {"FINISHED"}
