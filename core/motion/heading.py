"""The heading of a character, whatever its hips do at each step."""

from dataclasses import replace

import numpy as np
from scipy.signal import butter, filtfilt

from ..errors import ClipError
from .clip import MotionClip
from .joint_roles import JointRole
from .mirror import mirror_normal

DEFAULT_BANDWIDTH = 1.0
"""Hz. Rounds off 3 degrees of a turn of 90 degrees within one second, and flattens what repeats at every step."""


def steady_heading(clip: MotionClip, bandwidth: float | None = DEFAULT_BANDWIDTH) -> np.ndarray:
    """Return the (F,) unwrapped heading in radians that neither hips nor shoulders sway.

    In a walk hips and shoulders turn against each other once a stride, 4 to 8 degrees each way and too slowly for
    any filter that still follows turns. Their mean stands still; the rest is taken by a low-pass filter.

    Parameters
    ----------
    clip : MotionClip
    bandwidth : float, optional
        Hz at which the filter, which delays nothing, passes 71 % of an oscillation; None to leave it out.

    Without shoulders that are recognized, the heading of the root alone is smoothed. Of a turn of 90 degrees in one
    second a bandwidth of 1 Hz rounds off 3 degrees, one of 0.7 Hz 7. ClipError for a bandwidth that is not
    positive, or a root whose forward axis points straight up or down.
    """
    if bandwidth is not None and not bandwidth > 0:
        raise ClipError(f"The bandwidth of the heading is {bandwidth} Hz; it must be positive.")
    hips = clip.root_heading
    direction = np.exp(1j * hips) + _shoulder_direction(clip)
    # Where both oppose each other, hips decide.
    mean = np.where(np.abs(direction) > 0.1, np.angle(direction), hips)
    heading = np.unwrap(mean)
    heading += 2 * np.pi * np.round((hips[0] - heading[0]) / (2 * np.pi))
    return heading if bandwidth is None else _low_pass(heading, bandwidth / clip.frame_rate)


def with_steady_heading(clip: MotionClip, bandwidth: float | None = DEFAULT_BANDWIDTH) -> MotionClip:
    """Return the clip with its :func:`steady_heading` as the heading of its ground path; its poses stay."""
    return replace(clip, heading=steady_heading(clip, bandwidth))


def _shoulder_direction(clip: MotionClip) -> np.ndarray:
    """(F,) complex: where the shoulders face, as long as their line looks from above; 0 if there are none known."""
    roles = clip.skeleton.roles
    keys = [(JointRole.UPPER_ARM, side) for side in ("left", "right")]
    if not all(key in roles for key in keys):
        return np.zeros(clip.n_frames, dtype=complex)
    left, right = (roles[key][0] for key in keys)
    rest = clip.skeleton.rest_world[1]
    rest_line, line = rest[left] - rest[right], clip.world[1][:, left] - clip.world[1][:, right]
    normal = mirror_normal(clip.skeleton)
    # Nobody's shoulders are quite square in the rest pose.
    rest_line = complex(rest_line[0], rest_line[1]) / complex(normal[0], normal[1])
    if abs(rest_line) < 1e-6:
        return np.zeros(clip.n_frames, dtype=complex)
    return (line[:, 0] + 1j * line[:, 1]) / rest_line * -1j


def _low_pass(values: np.ndarray, bandwidth: float) -> np.ndarray:
    """Zero-phase low-pass; ``bandwidth`` in cycles per frame at -3 dB for both passes together."""
    order = 2
    cutoff = 2 * bandwidth / (np.sqrt(2) - 1) ** (1 / (2 * order))  # of one pass, in units of the Nyquist frequency
    if cutoff >= 1 or len(values) < 8:
        return values
    numerator, denominator = np.asarray(butter(order, cutoff, output="ba"))
    # Continued beyond its ends by point reflection, a steady turn stays one.
    n_continued = min(len(values) - 1, int(np.ceil(2 / bandwidth)))
    return filtfilt(numerator, denominator, values, padtype="odd", padlen=n_continued)
