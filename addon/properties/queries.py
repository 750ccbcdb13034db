"""Questions to an embedding: how long it takes to get somewhere, and where walks lead from a place."""

from enum import Enum
from typing import cast

import bpy

from ...core.evaluation.query import GoalKind, Query
from ...core.evaluation.reach import PAPER_TIMES
from .definitions import (
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
    enum_items,
)
from .floor_map import map_changed
from .graph_names import clip_names, matching, tag_names

_QUERY = Query()


class Direction(Enum):
    """The direction of a question."""

    TO = "to"
    FROM = "from"


def _region_names(settings, context, typed: str) -> list[str]:
    regions = settings.id_data.wayfarer.environment.regions
    return matching([region.object.name for region in regions if region.object is not None], typed)


class WayfarerQuerySettings(bpy.types.PropertyGroup):
    """Questions to an embedding."""

    direction: EnumProperty(
        items=enum_items(
            {
                Direction.TO: ("To", "How long it takes from everywhere to get there"),
                Direction.FROM: ("From", "How long it takes from there to get everywhere"),
            }
        ),
        name="Direction",
        description="Which way is meant",
        default=Direction.TO.name,
        update=map_changed,
    )
    goal: EnumProperty(
        items=enum_items(
            {
                GoalKind.CURSOR: ("3D Cursor", "The place of the 3D cursor"),
                GoalKind.OBJECT: ("Object", "The place of an object, such as an empty"),
                GoalKind.REGION: ("Region", "Everywhere in a region of the environment"),
                GoalKind.TAG: ("Tag", "Right after doing something that carries a tag, such as a jump"),
                GoalKind.CLIP: ("Clip", "Where a clip can begin; from it: where it has ended"),
            }
        ),
        name="Goal",
        description="What the times count to, or from",
        default=_QUERY.kind.name,
        update=map_changed,
    )
    object: PointerProperty(
        type=bpy.types.Object, name="Object", description="The object whose origin is the goal", update=map_changed
    )
    region: StringProperty(
        name="Region", description="The object of the region that is the goal", search=_region_names, update=map_changed
    )
    tag: StringProperty(name="Tag", description="The tag that is the goal", search=tag_names, update=map_changed)
    clip: StringProperty(name="Clip", description="The clip that is to begin", search=clip_names, update=map_changed)
    radius: FloatProperty(
        name="Radius",
        description="Who is as near to the goal as this has arrived",
        subtype="DISTANCE",
        default=_QUERY.radius,
        min=0.0,
        soft_max=3.0,
        update=map_changed,
    )
    times: FloatVectorProperty(
        name="Times",
        description="Times for which the area within reach is told, and painted in a colour of its own",
        size=len(PAPER_TIMES),
        unit="TIME_ABSOLUTE",
        default=PAPER_TIMES,
        min=0.0,
        soft_max=60.0,
        update=map_changed,
    )
    n_walks: IntProperty(name="Walks", description="How many walks start at the place", default=12, min=1, soft_max=100)
    duration: FloatProperty(
        name="Duration",
        description="How long each walk lasts at least; it ends with a whole segment",
        subtype="TIME_ABSOLUTE",
        default=7.0,
        min=0.1,
        soft_max=60.0,
    )
    style: EnumProperty(
        items=[
            ("WANDER", "Wander", "From place to place, all parts of the floor alike"),
            ("RANDOM", "Random Links", "Every link is equally likely, also those that only shuffle"),
        ],
        name="Style",
        description="How the walks choose their way",
        default="WANDER",
    )
    seed: IntProperty(name="Seed", description="Another number, other walks", default=0, min=0)

    def to_query(self) -> Query:
        """The question as it is at this moment."""
        kind, scene = GoalKind[self.goal], cast(bpy.types.Scene, self.id_data)
        obj = self.object if kind is GoalKind.OBJECT else None
        place = obj.matrix_world.translation if obj is not None else scene.cursor.location
        names = {
            GoalKind.CURSOR: "",
            GoalKind.OBJECT: obj.name if obj is not None else "",
            GoalKind.REGION: self.region,
            GoalKind.TAG: self.tag,
            GoalKind.CLIP: self.clip,
        }
        placed = kind in (GoalKind.CURSOR, GoalKind.OBJECT)
        return Query(
            kind=kind,
            name=names[kind],
            place=(float(place[0]), float(place[1])) if placed else (0.0, 0.0),
            radius=self.radius if placed else 0.0,
            forwards=self.direction == Direction.FROM.name,
            times=tuple(sorted({round(time, 4) for time in self.times})),
        )


CLASSES = (WayfarerQuerySettings,)
