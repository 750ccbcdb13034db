"""Tags on an action's frames: what a region of the environment may require, forbid or confine.

A pose marker ``step`` begins the tag "step", a pose marker ``/step`` ends it: the frame of the end marker no
longer carries the tag. A tag that does not end lasts to the end of the action; one that does not begin
starts with it. The custom property ``wayfarer_tags``, names separated by commas, tags the whole action.
"""

from collections.abc import Mapping

import numpy as np

TAGS_PROPERTY = "wayfarer_tags"


def read_tags(action, frames: np.ndarray) -> dict[str, np.ndarray]:
    """For each tag of the action, a (F,) bool array: which of the frame numbers ``frames`` carry it."""
    tags = {name: np.ones(len(frames), dtype=bool) for name in _whole_action_tags(action)}
    markers: dict[str, list[tuple[float, bool]]] = {}
    for marker in action.pose_markers:
        name = marker.name.strip()
        begins = not name.startswith("/")
        name = name.removeprefix("/").strip()
        if name and name not in tags:
            markers.setdefault(name, []).append((marker.frame, begins))
    for name, changes in markers.items():
        # At the same frame an end comes first, so that a tag may end and begin anew.
        changes.sort()
        times = np.array([time for time, _ in changes])
        begins = np.array([begin for _, begin in changes])
        latest = np.searchsorted(times, frames, side="right") - 1
        tags[name] = np.where(latest >= 0, begins[np.maximum(latest, 0)], not begins[0])
    return tags


def tag_names(action) -> list[str]:
    """The tags that any frame of the action may carry, in alphabetical order."""
    names = {marker.name.strip().removeprefix("/").strip() for marker in action.pose_markers}
    return sorted(names.union(_whole_action_tags(action)) - {""})


def write_tags(action, masks: Mapping[str, np.ndarray], first_frame: int = 1) -> None:
    """Make the action carry these tags and no others.

    ``masks`` hold one bool for each frame from ``first_frame`` on.
    """
    for marker in list(action.pose_markers):
        action.pose_markers.remove(marker)
    whole = [name for name, mask in masks.items() if np.all(mask)]
    if whole:
        action[TAGS_PROPERTY] = ", ".join(whole)
    elif TAGS_PROPERTY in action:
        del action[TAGS_PROPERTY]
    for name, mask in masks.items():
        if name in whole:
            continue
        steps = np.diff(np.concatenate([[0], np.asarray(mask, dtype=int)]))
        for offset in np.flatnonzero(steps):
            marker = action.pose_markers.new(name if steps[offset] > 0 else f"/{name}")
            marker.frame = first_frame + int(offset)


def _whole_action_tags(action) -> list[str]:
    return [name.strip() for name in str(action.get(TAGS_PROPERTY, "")).split(",") if name.strip()]
