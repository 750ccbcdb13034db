"""From a walk to its motion: blended, with the feet held, and measured."""

from collections.abc import Generator
from dataclasses import dataclass, replace

from ..motion.clip import MotionClip
from ..motion.contacts import ContactSettings
from ..progress import Progress
from .cleanup import CleanupSettings, FootCleanup, clean_feet
from .quality import WalkQuality, walk_quality
from .spikes import graph_roughness
from .synthesis import SynthesisSettings, synthesize
from .walk import Walk


@dataclass(frozen=True)
class MotionRequest:
    """The way in which a walk becomes motion.

    ``cleanup`` is None where feet are left as they are; ``closed`` says that the walk returns to its start and is
    repeated.
    """

    synthesis: SynthesisSettings
    cleanup: CleanupSettings | None
    contacts: ContactSettings
    closed: bool = False


@dataclass(frozen=True)
class WalkMotion:
    """The motion of a walk, and how good it was before the feet were held (``cleanup``) and is now."""

    walk: Walk
    clip: MotionClip
    closed: bool
    cleanup: FootCleanup | None
    before: WalkQuality
    after: WalkQuality


def motion_steps(
    walk: Walk, request: MotionRequest, name: str = "Wayfarer Walk"
) -> Generator[Progress, None, WalkMotion]:
    """Make a walk's motion and measure it."""
    yield Progress(0.0, "Blending segments")
    clip = synthesize(walk, request.synthesis, name, closed=request.closed)
    yield Progress(0.3, "Measuring the motion")
    rough = graph_roughness(walk.embedding.graph, request.contacts)
    before = after = walk_quality(walk, clip, request.contacts, rough=rough)
    cleanup = None
    if request.cleanup is not None:
        yield Progress(0.5, "Holding planted feet")
        cleanup = clean_feet(walk, clip, request.cleanup, request.closed)
        clip = cleanup.clip
        yield Progress(0.8, "Measuring the motion")
        after = walk_quality(walk, clip, request.contacts, lifted=cleanup.lifted, rough=rough)
    return WalkMotion(walk, clip, request.closed, cleanup, before, after)


def blended_motion(walk: Walk, request: MotionRequest, name: str, n_frames: int) -> MotionClip:
    """Make the first frames of a walk's motion, blended and with the feet held, but not measured."""
    clip = synthesize(walk, request.synthesis, name)
    if request.cleanup is not None:
        clip = clean_feet(walk, clip, request.cleanup).clip
    return replace(
        clip,
        rotations=clip.rotations[:n_frames],
        translations=clip.translations[:n_frames],
        tags={tag: mask[:n_frames] for tag, mask in clip.tags.items()},
        heading=clip.ground_path[:n_frames, 2],
    )
