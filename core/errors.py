"""What can be wrong with the input, as exceptions whose text is shown to the artist.

Each message is a full sentence that names the clip, bone, object or setting, and the remedy. A setting is called what
the interface calls it: "use a larger Cell Size".
"""

NOTHING_FITS = (
    "no endless walk fits into this scene. Use more clips, a shorter Min Segment, a smaller Radius or more Position "
    "Edit, or remove obstacles."
)
"""Why an embedding is empty, and what helps."""


class MotionGraphError(Exception):
    """Base of everything that Wayfarer reports about its input."""


class ClipError(MotionGraphError):
    """A clip cannot be used: no frames, NaN, another skeleton, no root motion."""


class SceneError(MotionGraphError):
    """The ground, an obstacle or a region cannot be used."""


class EmbeddingError(MotionGraphError):
    """The motion graph cannot be unrolled into the environment, or not within the memory allowed."""


class WalkError(MotionGraphError):
    """No walk answers the request."""


class TuningError(MotionGraphError):
    """An embedding cannot be pruned as asked."""


class EvaluationError(MotionGraphError):
    """A question to an embedding has no answer: an empty goal, or nothing to measure."""


class StorageError(EmbeddingError):
    """A file cannot be written: the disk is full, or the folder not ours. What was written before is kept."""


class StudyError(MotionGraphError):
    """A study cannot be read, or cannot go on."""


class ExportError(MotionGraphError):
    """An embedding cannot be written for engines."""
