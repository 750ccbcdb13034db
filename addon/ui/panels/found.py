"""Findings in panels."""

from ...results.findings import Topic, find_finding, finding_is_stale, numbers_of
from ...results.store import results
from ..text import draw_wrapped
from .step import Sidebar, draw_numbers, draw_sentences

_ROWS = 5
"""Lines of a list that are seen at once."""


class FindingPart(Sidebar):
    """A part of a panel about one topic; its header says whether it has been found out."""

    topic: Topic

    def draw_header_preset(self, context):
        if finding_is_stale(context.scene, self.topic):
            self.layout.label(text="Changed", icon="ERROR")
        elif find_finding(context.scene, self.topic) is not None:
            self.layout.label(text="", icon="CHECKMARK")


def any_stale(scene, topics) -> bool:
    """Test for a finding on any of these topics that is about another embedding."""
    return any(finding_is_stale(scene, topic) for topic in topics)


def any_found(scene, topics) -> bool:
    """Test for a finding on any of these topics."""
    return any(find_finding(scene, topic) is not None for topic in topics)


def draw_next_step(context, layout) -> bool:
    """Say what has to be done before anything can be found out; True if nothing has."""
    embedding = results(context.scene).embedding
    if embedding is None:
        draw_sentences(context, layout, ["Embed the motion graph first, in the panel Embedding"], "INFO")
        return False
    if embedding.n_nodes == 0:
        draw_sentences(context, layout, ["The character cannot go anywhere; see the map Why Not"], "INFO")
        return False
    return True


def draw_finding_numbers(layout, scene, topic: Topic) -> None:
    """Draw the numbers of a finding, if there is one."""
    kept = find_finding(scene, topic)
    if kept is not None:
        draw_numbers(layout, numbers_of(kept))


def draw_finding(context, layout, topic: Topic) -> None:
    """Draw a finding, if there is one: numbers, list, the sentence of the chosen line, and the button of the chart.

    What has nothing to list says so.
    """
    kept = find_finding(context.scene, topic)
    if kept is None:
        return
    draw_finding_numbers(layout, context.scene, topic)
    if topic.columns and not kept.rows:
        draw_wrapped(context, layout, kept.sentences)
        return
    if topic.columns:
        shown = min(_ROWS, len(kept.rows))
        heading = layout.row()
        heading.active = False
        heading.label(text=topic.columns)
        names = ("WAYFARER_UL_findings", topic.name, kept, "rows", kept, "active_row")
        layout.template_list(*names, rows=shown, maxrows=shown)
        if kept.chosen is not None and kept.chosen.sentence:
            draw_wrapped(context, layout.box(), kept.chosen.sentence)
    draw_chart_button(layout, topic)


def draw_chart_button(layout, topic: Topic) -> None:
    """Draw the button that opens the chart of a topic, if it has one."""
    if topic.chart is not None:
        layout.operator("wayfarer.show_chart", icon="URL").finding = topic.name
