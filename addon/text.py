"""Numbers in sentences: those of the core, at hand for the whole add-on, its panels included."""

from ..core.wording import amount, area, counted, place, share, share_of, short, time

__all__ = ["amount", "area", "counted", "place", "share", "share_of", "short", "time"]
