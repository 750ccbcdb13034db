"""Which actions the clips of a finding come from."""

from ...core.motion.mirror import MIRRORED
from .findings import DELETION, find_finding, table_of
from .store import results


def deletable_actions(scene) -> tuple[set[str], list[str]]:
    """Names of the actions that can be deleted, and of those of which a mirror image, or the original, must stay.

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
