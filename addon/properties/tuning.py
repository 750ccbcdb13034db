"""Settings of pruning."""

import bpy

from ...core.tuning.budget import BudgetSettings, Limit
from ...core.tuning.pruning import PruningMethod, PruningSettings
from ...core.tuning.spanning import Places
from .definitions import EnumProperty, FloatProperty, IntProperty, StringProperty, enum_items

_BUDGET = BudgetSettings()


class WayfarerTuningSettings(bpy.types.PropertyGroup):
    """Settings of pruning."""

    method: EnumProperty(
        items=enum_items(
            {
                PruningMethod.LOCAL: ("Local", "At each place keep the segments that offer most ways through"),
                PruningMethod.GLOBAL: ("Global", "Drop the segments that offer fewest ways on the whole ground"),
                PruningMethod.BUDGET: ("Budget", "Fit into a number of links or bytes, and lose little of the floor"),
            }
        ),
        name="Method",
        description="How the embedding is made smaller",
        default=PruningMethod.LOCAL.name,
    )
    k: IntProperty(
        name="Keep Best",
        description="Segments kept at each place and heading: the k of local pruning",
        default=16,
        min=1,
        soft_max=50,
    )
    n_segments: IntProperty(
        name="Segments",
        description="Segments of the motion graph that are kept; the others are dropped everywhere",
        default=20,
        min=1,
        soft_max=200,
    )
    limit: EnumProperty(
        items=enum_items(
            {
                Limit.LINKS: ("Links", "Count the links of the embedding"),
                Limit.BYTES: ("Memory", "Count the memory of a table of nodes and links in a game engine"),
            }
        ),
        name="Limit",
        description="What the budget counts",
        default=_BUDGET.limit.name,
    )
    max_links: IntProperty(
        name="Links", description="Links that may be left", default=_BUDGET.budget, min=0, soft_max=10**7
    )
    max_megabytes: FloatProperty(
        name="Megabytes",
        description="Millions of bytes that the table may take: 12 bytes for each node, 4 for each link",
        default=1.0,
        min=0.0,
        soft_max=1000.0,
        precision=2,
    )
    places: EnumProperty(
        items=enum_items(
            {
                Places.CELLS: ("Floor", "Cells that are covered in any heading"),
                Places.ELEMENTS: ("Floor and Headings", "Cells and headings that are covered"),
            }
        ),
        name="Keep Covered",
        description="Of what the allowed loss is a part",
        default=_BUDGET.places.name,
    )
    coverage_loss: FloatProperty(
        name="May Lose",
        description="Part of what is covered that may be lost, even if the budget cannot be met otherwise",
        subtype="PERCENTAGE",
        default=100 * _BUDGET.coverage_loss,
        min=0.0,
        max=100.0,
        precision=1,
    )
    pruned: StringProperty(
        name="Pruned",
        description="Which pruned embedding the scene has; empty if it was not pruned",
        options={"HIDDEN"},
    )

    def to_settings(self) -> PruningSettings:
        """Return the core's settings."""
        limit = Limit[self.limit]
        budget = self.max_links if limit is Limit.LINKS else round(1e6 * self.max_megabytes)
        places, loss = Places[self.places], self.coverage_loss / 100
        return PruningSettings(
            PruningMethod[self.method], self.k, self.n_segments, BudgetSettings(limit, budget, places, loss)
        )


CLASSES = (WayfarerTuningSettings,)
