"""Settings of the evaluation."""

import bpy

from ...core.evaluation.segment_groups import Grouping
from ...core.evaluation.weak_spots import Domain, WeakSpotSettings
from ...core.report.finding import Questions
from .definitions import BoolProperty, EnumProperty, FloatProperty, IntProperty, enum_items

_WEAK = WeakSpotSettings()


class WayfarerEvaluationSettings(bpy.types.PropertyGroup):
    """Settings of the evaluation."""

    n_pairs: IntProperty(
        name="Pairs of Places",
        description="Pairs of places, drawn at random, between which the quickest way is compared with the shortest",
        default=100,
        min=1,
        soft_max=1000,
    )
    seed: IntProperty(name="Seed", description="Another number, other pairs", default=0, min=0)
    domain: EnumProperty(
        items=enum_items(
            {
                Domain.FLOOR: ("Floor", "Places that are weak in all headings together"),
                Domain.HEADINGS: ("Floor and Headings", "Also places that are passed, but never in some heading"),
            }
        ),
        name="Look At",
        description="Where weak spots are looked for",
        default=_WEAK.domain.name,
    )
    few_ways: IntProperty(
        name="Few Ways",
        description="Variability under which a place that is reached counts as weak; with 0, only places that are not "
        "reached do",
        default=_WEAK.threshold,
        min=0,
    )
    min_area: FloatProperty(
        name="Smallest Area",
        description="Area that a weak spot needs to be listed",
        unit="AREA",
        default=_WEAK.min_area,
        min=0.0,
        soft_max=5.0,
    )
    parts: EnumProperty(
        items=enum_items(
            {
                Grouping.CLIP: ("Clips", "Take away one clip at a time, with all of its segments"),
                Grouping.SEGMENT: ("Segments", "Take away one segment at a time"),
                Grouping.TAG: ("Tags", "Take away all segments with a tag, one tag at a time"),
            }
        ),
        name="Without",
        description="What is taken away at a time",
        default=Grouping.CLIP.name,
    )
    allowed_loss: FloatProperty(
        name="May Cost",
        description="Part of the covered floor that may be lost when all deletable clips are gone; of its positions "
        "and headings five times as much",
        subtype="PERCENTAGE",
        default=1.0,
        min=0.0,
        max=100.0,
        precision=1,
    )
    n_candidates: IntProperty(
        name="Motions to Try",
        description="Steps, turns and mirror images that are tried, one at a time: the more, the longer it takes",
        default=60,
        min=1,
        soft_max=200,
    )
    use_json: BoolProperty(name="JSON", description="Write one file with everything", default=True)
    use_csv: BoolProperty(name="CSV", description="Write a table for each finding", default=True)
    use_pictures: BoolProperty(
        name="Pictures", description="Write charts (SVG) and the painted map (SVG and PNG)", default=True
    )

    def to_core(self) -> Questions:
        return Questions(
            seed=self.seed,
            n_pairs=self.n_pairs,
            allowed_loss=self.allowed_loss / 100,
            parts=Grouping[self.parts],
            weak_spots=WeakSpotSettings(Domain[self.domain], self.few_ways, self.min_area),
            n_candidates=self.n_candidates,
        )


CLASSES = (WayfarerEvaluationSettings,)
