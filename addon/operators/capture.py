"""Ask the capture director what is missing."""

import bpy

from ..results.findings.capture import capture_finding_steps
from ..results.state import whole_of
from .asks_embedding import FindsOut


class WAYFARER_OT_direct_capture(FindsOut, bpy.types.Operator):
    # Also for an embedding that is empty: that is when most is missing.
    bl_idname = "wayfarer.direct_capture"
    bl_label = "Find What Is Missing"
    bl_description = (
        "Try steps, turns and mirror images that nobody has recorded, one at a time, and list those that would open "
        "floor or headings that the character cannot reach now"
    )

    def steps(self, context):
        n_candidates = context.scene.wayfarer.evaluation.n_candidates
        return capture_finding_steps(whole_of(context.scene), n_candidates)

    def summary(self, finding):
        return finding.sentences[0].rstrip(".")
