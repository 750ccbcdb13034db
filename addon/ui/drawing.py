"""Mixins of panels, and functions that draw text, tables and findings."""

import blf
import bpy

from ..properties.presets import draw_presets
from ..results.findings import Topic, find_finding, finding_is_stale, numbers_of
from ..results.store import results

_FONT, _POINTS = 0, 11
_FALLBACK_WIDTH = 260
"""Pixels, where there is no region to draw in."""


def draw_wrapped(context, layout, text: str, margin: float = 70.0) -> None:
    """Draw ``text`` on as many lines as the region's width asks for, ``margin`` (units of 1x) being taken up."""
    scale = context.preferences.system.ui_scale
    width = context.region.width if context.region else _FALLBACK_WIDTH
    column = layout.column(align=True)
    column.scale_y = 0.75
    for line in wrapped(text, max(width - margin * scale, 80 * scale), _POINTS * scale):
        column.label(text=line, translate=False)


def wrapped(text: str, width: float, points: float) -> list[str]:
    """Break the text into lines no wider than ``width`` pixels; a single word may be."""
    blf.size(_FONT, points)
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and blf.dimensions(_FONT, longer)[0] <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


class Sidebar:
    """Mixin: where all panels are."""

    layout: bpy.types.UILayout
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Wayfarer"


class Step(Sidebar):
    """Mixin: a step of the work; its header says whether it has been done."""

    def result_is_there(self, scene) -> bool:
        """Return True if this step has been done."""
        return False

    def result_is_stale(self, scene) -> bool:
        """Return True if what it was done with has changed since."""
        return False

    presets = ""
    """The group of settings that presets can be made of."""

    def draw_header_preset(self, context):
        scene = context.scene
        if self.presets:
            draw_presets(self.presets, self.layout)
        if self.result_is_stale(scene):
            self.layout.label(text="Changed", icon="ERROR")
        elif self.result_is_there(scene):
            self.layout.label(text="", icon="CHECKMARK")


def split_properties(layout):
    """Let settings be drawn in two columns, without the dots for keyframes."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def draw_numbers(layout, rows) -> None:
    """Draw names and values in two columns."""
    grid = layout.column(align=True)
    for name, value in rows:
        split = grid.split(factor=0.55, align=True)
        left = split.row()
        left.alignment = "RIGHT"
        left.active = False
        left.label(text=name)
        split.label(text=value, translate=False)


def draw_table(layout, rows, factor: float = 0.72, heading: tuple[str, str] | None = None) -> None:
    """Draw text on the left, a value at the right end of each row; rows are (text, value, icon number).

    ``heading`` names the two columns.
    """
    column = layout.column(align=True)
    for number, (text, value, icon) in enumerate([(*heading, 0), *rows] if heading else rows):
        split = column.split(factor=factor, align=True)
        split.active = number > 0 or heading is None
        split.label(text=text, translate=False, icon_value=icon)
        right = split.row()
        right.alignment = "RIGHT"
        right.label(text=value, translate=False)


def draw_sentences(context, layout, sentences, icon: str = "ERROR") -> None:
    """Draw sentences below each other, each with an icon."""
    for sentence in sentences:
        row = layout.row(align=True)
        row.label(text="", icon=icon)
        draw_wrapped(context, row, sentence, margin=86)


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
