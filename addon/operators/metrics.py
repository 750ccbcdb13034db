"""Measure how good the embedding is."""

import bpy
import numpy as np

from ..findings.finding import keep_finding
from ..findings.metrics import measure_steps
from ..state import results
from .asks_embedding import FindsOut


class WAYFARER_OT_measure(FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.measure"
    bl_label = "Measure"
    bl_description = (
        "Coverage of the floor and of the clips, turns to the left and right, how direct the ways are, how soon each "
        "clip can begin, and which links are used (the metrics of Reitsma and Pollard, 2007)"
    )

    def steps(self, context):
        settings = context.scene.wayfarer.evaluation
        return measure_steps(results(context.scene).embedding, np.random.default_rng(settings.seed), settings.n_pairs)

    def apply(self, context, result):
        numbers, *others = result
        for finding in others:
            keep_finding(context.scene, finding)
        super().apply(context, numbers)
