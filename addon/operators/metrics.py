"""Measure how good the embedding is."""

from collections.abc import Sequence

import bpy
import numpy as np

from ..results.findings.finding import Finding, keep_finding
from ..results.findings.metrics import measure_steps
from ..results.state import embedding_of
from .asks_embedding import AsksEmbedding, FindsOut


class WAYFARER_OT_measure(AsksEmbedding, FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.measure"
    bl_label = "Measure"
    bl_description = (
        "Coverage of the floor and of the clips, turns to the left and right, how direct the ways are, how soon each "
        "clip can begin, and which links are used (metrics of Reitsma and Pollard, 2007)"
    )

    def steps(self, context):
        settings = context.scene.wayfarer.evaluation
        return measure_steps(embedding_of(context.scene), np.random.default_rng(settings.seed), settings.n_pairs)

    def summary(self, finding):
        return finding.sentences[0].rstrip(".")

    def apply(self, context, result: Sequence[Finding]):
        numbers, *others = result
        for finding in others:
            keep_finding(context.scene, finding)
        super().apply(context, numbers)
