"""The sample character and its repertoire: motion from a procedural walk, to be used like motion capture.

The paper's section 6 suggests it: run a procedural controller through its repertoire and treat the result as
motion data. Everything here is made by these few files, so that the sample can be shipped under any licence.
"""

from .character import sample_bone_lengths, sample_skeleton
from .clips import STEP_OBSTACLE, STEP_TAG, sample_repertoire

__all__ = ["STEP_OBSTACLE", "STEP_TAG", "sample_bone_lengths", "sample_repertoire", "sample_skeleton"]
