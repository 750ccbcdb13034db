"""How panels show what was found out."""

from ...results.findings.finding import find_finding, finding_is_stale, numbers_of
from ...results.state import results
from ..text import draw_wrapped
from .step import Sidebar, draw_numbers, draw_sentences


class FindingPart(Sidebar):
    """A part of a panel about one kind of finding; its header says whether it has been found out."""

    finding = ""

    def draw_header_preset(self, context):
        if finding_is_stale(context.scene, self.finding):
            self.layout.label(text="Changed", icon="ERROR")
        elif find_finding(context.scene, self.finding) is not None:
            self.layout.label(text="", icon="CHECKMARK")


def any_stale(scene, kinds) -> bool:
    """Whether any finding of these kinds speaks of another embedding."""
    return any(finding_is_stale(scene, kind) for kind in kinds)


def any_found(scene, kinds) -> bool:
    """Whether there is a finding of any of these kinds."""
    return any(find_finding(scene, kind) is not None for kind in kinds)


def draw_next_step(context, layout) -> bool:
    """What has to be done before anything can be found out; True if nothing has."""
    embedding = results(context.scene).embedding
    if embedding is None:
        draw_sentences(context, layout, ["Embed the motion graph first, in the panel Embedding"], "INFO")
        return False
    if embedding.n_nodes == 0:
        draw_sentences(context, layout, ["The character cannot go anywhere; see the map Why Not"], "INFO")
        return False
    return True


def draw_finding_numbers(layout, scene, kind: str) -> None:
    """The numbers of a finding, if there is one."""
    kept = find_finding(scene, kind)
    if kept is not None:
        draw_numbers(layout, numbers_of(kept))


def draw_finding_rows(context, layout, kind: str, columns: str, rows: int = 4) -> None:
    """The list of a finding, if it has one, under the names of its columns, and the sentence of the chosen line."""
    kept = find_finding(context.scene, kind)
    if kept is None or not kept.rows:
        return
    shown = min(rows, len(kept.rows))
    heading = layout.row()
    heading.active = False
    heading.label(text=columns)
    layout.template_list("WAYFARER_UL_findings", kind, kept, "rows", kept, "active_row", rows=shown, maxrows=shown)
    if kept.chosen is not None and kept.chosen.sentence:
        draw_wrapped(context, layout.box(), kept.chosen.sentence)


def draw_chart_button(layout, scene, kind: str) -> None:
    """The button that draws a finding, if there is one."""
    kept = find_finding(scene, kind)
    if kept is not None:
        layout.operator("wayfarer.show_chart", icon="IMAGE_DATA").finding = kind
