"""Times to a goal, and walks from a place."""

import bpy
import numpy as np

from ...core.evaluation.query import query_steps
from ...core.maps import QUERY
from ...core.maps.times import paint_query
from ...core.playback.styles import STYLES, WalkRequest
from ...core.progress import Progress, portion
from ...core.report.topics.times import reach_finding
from ...core.wording import counted, time
from ...core.wording import place as place_words
from ..bridge.owned import OUTPUT, ensure_collection, find_collection, walk_fan
from ..jobs import LongOperator
from ..render.viewport import show_colors
from ..render.walk_fan import draw_walk_fan, remove_walk_fan
from ..results.advice import start_advice
from ..results.findings import keep_finding
from ..results.shown import paint_floor
from ..results.store import embedding_of, results
from .mixins import AsksEmbedding, Needs, PicksOnFloor, clicked, ground_under, viewport_under


class WAYFARER_OT_find_reach(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.find_reach"
    bl_label = "Find Times"
    bl_description = (
        "Find out how long it takes at least to get to the goal, or from it, paint the times on the floor and tell the "
        "area within reach"
    )

    def steps(self, context):
        settings = context.scene.wayfarer
        embedding, options = embedding_of(context.scene), settings.map.to_core()
        field = yield from query_steps(embedding, options.query)
        return reach_finding(field, options.query), paint_query(field, options)

    def apply(self, context, result):
        finding, painted = result
        scene, settings = context.scene, context.scene.wayfarer.map
        # First, because it may be refused: then nothing has changed.
        key = settings.key_of(QUERY)
        paint_floor(scene, finding.embedding, painted, key, settings.offset, in_operator=True)
        keep_finding(scene, finding)
        settings.quantity = QUERY.name
        show_colors(context.screen, scene)
        self.report({"INFO"}, painted.report)
        self.warn_if_stale(scene)


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


class WAYFARER_OT_clear_walks_from(Needs, bpy.types.Operator):
    bl_idname = "wayfarer.clear_walks_from"
    bl_label = "Clear Walks"
    bl_description = "Remove the curves of the walks that start at a place"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def problem(cls, context):
        collection = find_collection(context.scene, OUTPUT)
        return "" if collection is not None and walk_fan(collection) else "No walks are drawn"

    def execute(self, context):
        removed = remove_walk_fan(find_collection(context.scene, OUTPUT))
        self.report({"INFO"}, f"{counted(removed, 'curve')} removed")
        return {"FINISHED"}


class WAYFARER_OT_pick_walks_from(PicksOnFloor, AsksEmbedding, bpy.types.Operator):
    bl_idname = "wayfarer.pick_walks_from"
    bl_label = "Walks from Here"
    bl_description = "Click a place on the floor: walks that start there are drawn as coloured curves"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        """Without a mouse: from the 3D cursor."""
        return bpy.ops.wayfarer.walks_from(location=context.scene.cursor.location.xy)

    def begin(self, context):
        context.workspace.status_text_set("Click: Walks from Here    Esc: Cancel")

    def handle(self, context, event):
        region = viewport_under(context, event) if clicked(event) else None
        if region is None:
            # A click on the sidebar, or on another editor, is theirs.
            return {"PASS_THROUGH"}
        mouse = event.mouse_x - region.x, event.mouse_y - region.y
        place = ground_under(region, context.space_data.region_3d, mouse, results(context.scene).ground_height)
        self.stop(context)
        if place is None:
            self.report({"WARNING"}, "That place is above the horizon; click on the floor")
            return {"CANCELLED"}
        # The walks are an operator, and a step of undo, of their own.
        bpy.ops.wayfarer.walks_from("INVOKE_DEFAULT", True, location=place)
        return {"CANCELLED"}


CLASSES = (WAYFARER_OT_find_reach, WAYFARER_OT_walks_from, WAYFARER_OT_clear_walks_from, WAYFARER_OT_pick_walks_from)
