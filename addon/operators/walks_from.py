"""Where do walks lead from a place?"""

import bpy
import numpy as np

from ...core.playback.styles import STYLES, WalkRequest
from ...core.progress import Progress, portion
from ..bridge.owned import OUTPUT, ensure_collection, find_collection, walk_fan
from ..bridge.text import counted, time
from ..bridge.text import place as place_words
from ..jobs import LongOperator
from ..render.walk_fan import draw_walk_fan, remove_walk_fan
from ..results.advice import start_advice
from ..results.store import embedding_of, results
from .asks_embedding import AsksEmbedding


class WAYFARER_OT_walks_from(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.walks_from"
    bl_label = "Walks from Place"
    bl_description = "Draw walks that start at a place as coloured curves"

    location: bpy.props.FloatVectorProperty(
        name="Location",
        description="Where the walks start, or as near to it as possible",
        size=2,
        subtype="XYZ",
        unit="LENGTH",
        options={"SKIP_SAVE"},
    )

    def steps(self, context):
        settings, embedding = context.scene.wayfarer.queries, embedding_of(context.scene)
        rng, place = np.random.default_rng(settings.seed), tuple(self.location)
        n_walks, request = settings.n_walks, WalkRequest(settings.style, duration=settings.duration, start=place)
        walks = []
        for number in range(n_walks):
            yield Progress(number / n_walks, "Walking")
            steps = STYLES[request.style].plan(embedding, request, rng)
            walks.append((yield from portion(steps, number / n_walks, (number + 1) / n_walks)))
        return walks, place

    def apply(self, context, result):
        walks, place = result
        collection = ensure_collection(context.scene, OUTPUT)
        draw_walk_fan([walk.root_path for walk in walks], results(context.scene).ground_height, collection)
        advice = start_advice(place, walks[0])
        if advice:
            self.report({"WARNING"}, advice)
        x, y = walks[0].root_path[0, :2]
        longest = max(walk.duration for walk in walks)
        self.report({"INFO"}, f"{counted(len(walks), 'walk')} of up to {time(longest)} from {place_words(x, y)}")
        self.warn_if_stale(context.scene)


class WAYFARER_OT_clear_walks_from(bpy.types.Operator):
    bl_idname = "wayfarer.clear_walks_from"
    bl_label = "Clear Walks"
    bl_description = "Remove the curves of the walks that start at a place"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        collection = find_collection(context.scene, OUTPUT)
        if collection is None or not walk_fan(collection):
            cls.poll_message_set("No walks are drawn")
            return False
        return True

    def execute(self, context):
        removed = remove_walk_fan(find_collection(context.scene, OUTPUT))
        self.report({"INFO"}, f"{counted(removed, 'curve')} removed")
        return {"FINISHED"}
