"""How good a walk is, put where the panel shows it."""

from .motion import WalkMotion

_UNKNOWN = -1.0
"""Slide of feet that cannot be told."""


def fill_report(scene, motion: WalkMotion, first_frame: int) -> None:
    """Show the quality of a walk that was baked from ``first_frame`` on."""
    report, before, after = scene.wayfarer.walk.report, motion.before, motion.after
    report.clear()
    feet = before.feet_unknown or (motion.cleanup.describe() if motion.cleanup is not None else "Feet are not held.")
    report.feet = feet
    if after.feet:
        report.slide_before, report.slide_after = before.mean_slide, after.mean_slide
        report.slide_in_clips = sum(foot.source_mean for foot in after.feet) / len(after.feet)
    else:
        report.slide_before = report.slide_after = report.slide_in_clips = _UNKNOWN
    frames_per_sample = scene.render.fps / scene.render.fps_base / motion.walk.embedding.graph.frame_rate

    def frame_of(sample: int) -> int:
        return first_frame + round(sample * frames_per_sample)

    if after.largest_gap is not None:
        report.gap, report.gap_joint = after.largest_gap.angle, after.largest_gap.joint
        report.gap_frame = frame_of(after.largest_gap.frame)
    report.edit, report.turn_edit = after.position_edit, after.heading_edit
    for found in after.worst_frames:
        entry = report.worst.add()
        entry.frame, entry.what, entry.severity = frame_of(found.frame), found.what, found.severity
        entry.amount = found.amount
