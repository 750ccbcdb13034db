"""Draw a finding as a chart."""

import bpy
from bpy.props import EnumProperty

from ..render.image_editor import show_in_editor
from ..results.findings.charts import CHARTS, show_chart
from ..results.findings.finding import TITLES, find_finding


class WAYFARER_OT_show_chart(bpy.types.Operator):
    bl_idname = "wayfarer.show_chart"
    bl_label = "Show Chart"
    bl_description = "Draw these numbers as an image and show it in the Image Editor"
    bl_options = {"REGISTER", "UNDO"}

    finding: EnumProperty(
        items=[(kind, TITLES[kind], "") for kind in CHARTS],
        name="Finding",
        description="What to draw",
        options={"SKIP_SAVE"},
    )

    def execute(self, context):
        if find_finding(context.scene, self.finding) is None:
            self.report({"ERROR"}, f"'{TITLES[self.finding]}' has not been found out yet; press its button first")
            return {"CANCELLED"}
        image = show_chart(context.scene, self.finding)
        if image is None:
            self.report({"ERROR"}, f"'{TITLES[self.finding]}' has nothing to draw")
            return {"CANCELLED"}
        shown = show_in_editor(context, image)
        self.report(
            {"INFO"}, f"The chart is the image '{image.name}'" + ("" if shown else "; open an Image Editor to see it")
        )
        return {"FINISHED"}
