"""Why the character cannot go where it cannot go."""

from collections.abc import Generator

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.why_not import Reason, floor_reasons, reason_shares, rule_labels, why_not_steps
from ..progress import Progress
from ..wording import counted
from .floor_map import FloorMap, MapOptions, PaintedMap
from .legend import MapLegend, Swatch
from .reasons import reason_colors, reason_legend


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    reasons = yield from why_not_steps(embedding)
    floor = floor_reasons(reasons)
    shares = reason_shares(floor)
    legend, rules = reason_legend(), rule_labels(embedding.environment)
    swatches = tuple(
        Swatch(legend[name][1], rules if name == Reason.RULE.name else legend[name][0], wording.share(share))
        for name, share in sorted(shares.items(), key=lambda item: -item[1])
    )
    missing = 1 - shares.get(Reason.EMBEDDED.name, 0.0)
    return PaintedMap(
        colors=reason_colors(floor),
        legend=MapLegend(title="Why Not", swatches=swatches),
        numbers={"reasons": shares},
        report=f"The character cannot go to {wording.share(missing)} of {counted(floor.size, 'cell')}",
    )


MAPS = (
    FloorMap(
        name="WHY_NOT",
        number=2,
        label="Why Not",
        description="Why the character cannot go where it cannot go",
        paint_steps=_steps,
    ),
)
