"""Numbers in sentences: those of the core, at hand for the whole add-on, its panels included."""

from ..core.wording import amount, area, counted, mean_of, place, share, share_of, short, time

__all__ = ["amount", "area", "counted", "mean_of", "place", "share", "share_of", "short", "time"]
