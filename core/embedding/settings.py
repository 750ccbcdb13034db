"""Settings of :mod:`.embedding`, which unrolls a motion graph into an environment."""

from dataclasses import dataclass, field

from .footprint import FootprintSettings


@dataclass(frozen=True)
class EmbeddingSettings:
    """Limits of edits and of memory with which a motion graph is unrolled.

    Attributes
    ----------
    footprint : FootprintSettings
    memory_limit : float
        Bytes that the embedding's planes may take; above it ``embed`` refuses before it starts.
    """

    footprint: FootprintSettings = field(default_factory=FootprintSettings)
    memory_limit: float = 4e9
