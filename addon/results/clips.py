"""Findings about single actions, until they or the settings change, and the actions that a finding is about."""

from ...core.motion.doctor import ClipHealth, ClipMotion
from ...core.motion.mirror import MIRRORED
from ...core.report.contact_chart import ContactShares
from ..scene.inputs import contacts_fingerprint, doctor_settings_fingerprint
from .findings import DELETION, find_finding, table_of
from .staleness import present_action
from .store import results


def keep_health(scene, action: str, seen: str, health: ClipHealth) -> None:
    """Keep the findings in the action of this name, of fingerprint ``seen``."""
    _keep(scene, results(scene).health, (action, seen, doctor_settings_fingerprint(scene)), health, action, seen)


def keep_contacts(scene, action: str, seen: str, shares: ContactShares) -> None:
    """Keep for how long the feet are planted in the action of this name, of fingerprint ``seen``."""
    _keep(scene, results(scene).contacts, (seen, contacts_fingerprint(scene)), shares, action, seen)


def keep_motion(scene, action: str, seen: str, motion: ClipMotion) -> None:
    """Keep how far the character goes in the action of this name, of fingerprint ``seen``."""
    _keep(scene, results(scene).motions, seen, motion, action, seen)


def _keep(scene, known: dict, key, value, action: str, seen: str) -> None:
    found = results(scene)
    known[key], found.actions[action] = value, seen
    # Forget the oldest, beyond what undo may come back to.
    while len(known) > 8 * len(found.actions) + 100:
        del known[next(iter(known))]


def motion_of(scene, action) -> ClipMotion | None:
    """Return how far the character goes in an action; None if it was not measured since it has changed."""
    return results(scene).motions.get(present_action(scene, action))


def health_of(scene, action) -> ClipHealth | None:
    """Return the findings in an action; None if it was not examined since it or the settings have changed."""
    known = action.name, present_action(scene, action), doctor_settings_fingerprint(scene)
    return results(scene).health.get(known)


def contacts_of(scene, action) -> ContactShares | None:
    """Return for how long the feet are planted in an action; None as for :func:`health_of`."""
    return results(scene).contacts.get((present_action(scene, action), contacts_fingerprint(scene)))


def deletable_actions(scene) -> tuple[set[str], list[str]]:
    """Return the names of actions that can be deleted, and of those whose mirror image, or the original, must stay.

    Where clips are mirrored, an action is both: it can go only if both can.
    """
    found, graph = find_finding(scene, DELETION), results(scene).graph
    clips = {row[1] for row in table_of(found).rows} if found is not None else set()
    played = {graph.clips[segment.clip].name for segment in graph.segments} if graph is not None else set()
    names, kept = set(), []
    for name in sorted({str(clip).removesuffix(MIRRORED) for clip in clips}):
        if ({name, name + MIRRORED} & played) <= clips:
            names.add(name)
        else:
            kept.append(name)
    return names, kept
