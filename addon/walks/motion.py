"""From a walk to its motion: blended, with the feet held, and measured."""

from collections.abc import Generator
from dataclasses import dataclass

from ...core.motion.clip import MotionClip
from ...core.motion.contacts import ContactSettings
from ...core.playback.cleanup import CleanupSettings, FootCleanup, clean_feet
from ...core.playback.quality import WalkQuality, walk_quality
from ...core.playback.synthesis import SynthesisSettings, synthesize
from ...core.playback.walk import Walk
from ...core.progress import Progress

WALK_NAME = "Wayfarer Walk"


@dataclass(frozen=True)
class MotionRequest:
    """How a walk becomes motion; ``cleanup`` is None where feet are left as they are.

    ``closed`` says that the walk returns to its start and is repeated.
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


def read_motion_request(scene, closed: bool = False) -> MotionRequest:
    """How the scene's settings want motion made; ClipError if its feet are none of the character's."""
    settings = scene.wayfarer
    contacts = settings.contacts.to_core(settings.character)
    cleanup = settings.walk.cleanup_settings(contacts) if settings.walk.hold_feet else None
    return MotionRequest(settings.walk.synthesis_settings(), cleanup, contacts, closed)


def motion_steps(walk: Walk, request: MotionRequest, name: str = WALK_NAME) -> Generator[Progress, None, WalkMotion]:
    """Make a walk's motion and measure it, as a generator."""
    yield Progress(0.0, "Blending segments")
    clip = synthesize(walk, request.synthesis, name, closed=request.closed)
    yield Progress(0.3, "Measuring the motion")
    before = after = walk_quality(walk, clip, request.contacts)
    cleanup = None
    if request.cleanup is not None:
        yield Progress(0.5, "Holding planted feet")
        cleanup = clean_feet(walk, clip, request.cleanup, request.closed)
        clip = cleanup.clip
        yield Progress(0.8, "Measuring the motion")
        after = walk_quality(walk, clip, request.contacts, lifted=cleanup.lifted)
    return WalkMotion(walk, clip, request.closed, cleanup, before, after)
