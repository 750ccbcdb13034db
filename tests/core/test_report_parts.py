"""Pictures, charts, tables and pages: read back by others' readers."""

import csv
import io
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import image

from core.maps.legend import ColorBar, Swatch
from core.maps.scales import CIVIDIS, GREYS
from core.report.chart import Series, bar_chart, line_chart, map_chart
from core.report.contact_chart import LEFT, RIGHT, ClipContacts, contact_chart
from core.report.drawing import Label, Line, Picture, Rectangle, svg
from core.report.page import Bullets, Figure, FigureRow, Paragraph, Section, html_page
from core.report.png import png_bytes
from core.report.table import table
from core.report.ticks import ticks

SVG = "{http://www.w3.org/2000/svg}"


@given(st.integers(0, 10**6), st.integers(1, 30), st.integers(1, 30), st.sampled_from([3, 4]))
def test_png_is_read_back_to_the_last_pixel(seed, rows, columns, channels):
    pixels = np.random.default_rng(seed).integers(0, 256, (rows, columns, channels), dtype=np.uint8)
    read = image.imread(io.BytesIO(png_bytes(pixels)), format="png")
    assert np.array_equal(np.round(read * 255).astype(np.uint8), pixels)


@pytest.mark.parametrize("bad", [np.zeros((3, 3)), np.zeros((3, 3, 2), np.uint8), np.zeros((0, 3, 3), np.uint8)])
def test_png_refuses_what_is_no_picture(bad):
    with pytest.raises(ValueError, match="no picture"):
        png_bytes(bad)


@given(st.floats(-1e3, 1e3), st.floats(1e-2, 1e6), st.integers(2, 9))
def test_ticks_are_even_and_hold_the_range(low, width, n):
    found = ticks(low, low + width, n)
    step = np.diff(found)
    assert found[0] <= low + 1e-6 * step[0] and found[-1] >= low + width - 1e-6 * step[0]
    assert np.allclose(step, step[0]) and 2 <= len(found) <= n + 2
    digits = step[0] / 10.0 ** np.floor(np.log10(step[0]) + 1e-9)
    assert min(abs(digits - round_step) for round_step in (1, 2, 2.5, 5)) < 1e-6


def test_ticks_of_a_single_value():
    assert ticks(3.0, 3.0)[0] < 3.0 < ticks(3.0, 3.0)[-1]
    assert ticks(0.0, 0.0)[0] == 0.0


def test_line_chart_has_each_point_at_its_place():
    x, y = np.array([0.0, 5.0, 10.0]), np.array([0.0, 50.0, 100.0])
    drawing = line_chart("Nodes", "k", "nodes", [Series("a", x, y), Series("b", x, y / 2)])
    curves = [mark for mark in drawing.marks if isinstance(mark, Line) and len(mark.points) == 3]
    a, b = (curve.points for curve in curves)
    # Straight lines in, straight lines out; half the value is half as high.
    assert np.allclose(a[1], (a[0] + a[2]) / 2)
    assert np.isclose(a[0, 1] - b[2, 1], (a[0, 1] - a[2, 1]) / 2)
    texts = [mark.text for mark in drawing.marks if isinstance(mark, Label)]
    assert {"Nodes", "k", "nodes", "a", "b", "100", "10"} <= set(texts)
    root = ElementTree.fromstring(svg(drawing))
    assert len(root.findall(f"{SVG}polyline")) == sum(isinstance(mark, Line) for mark in drawing.marks)


@pytest.mark.parametrize("y", [[np.nan, 1.0], [1.0, np.inf]])
def test_charts_refuse_numbers_that_are_none(y):
    with pytest.raises(ValueError, match="finite"):
        line_chart("Nodes", "k", "n", [Series("a", np.arange(2), np.array(y))])
    with pytest.raises(ValueError, match="finite"):
        line_chart("Nodes", "k", "n", [])


def test_bar_chart_escapes_names_and_scales_bars():
    root = ElementTree.fromstring(svg(bar_chart("Clips", "m2", ["<walk> & run", "b", "c"], [4.0, 2.0, 0.0])))
    widths = [float(rect.get("width")) for rect in root.findall(f"{SVG}rect")[1:]]
    assert np.isclose(widths[0], 2 * widths[1], atol=0.2) and widths[2] == 0.0
    assert "<walk> & run" in [text.text for text in root.findall(f"{SVG}text")]
    with pytest.raises(ValueError, match="negative"):
        bar_chart("Clips", "m2", ["a"], [-1.0])


def test_map_chart_shows_cells_with_y_upwards():
    colors = np.zeros((3, 2, 3))
    colors[2, 1] = (1.0, 0.0, 0.0)  # the cell farthest to the right and on top
    bar = ColorBar(GREYS.stops, ((0.0, "0"), (1.0, "9")))
    drawing = map_chart("Map", colors, 0.5, [Swatch((1, 0, 0), "there"), bar])
    floor = next(mark for mark in drawing.marks if isinstance(mark, Picture))
    assert floor.pixels.shape == (2, 3, 3)
    assert np.argwhere(floor.pixels[:, :, 0] == 255).tolist() == [[0, 2]]


def test_color_scales_begin_and_end_where_they_should_and_get_lighter():
    for scale in (GREYS, CIVIDIS):
        colors = scale.colors(np.linspace(0, 1, 50))
        assert np.allclose(colors[0], scale.stops[0]) and np.allclose(colors[-1], scale.stops[-1])
        assert np.all(np.diff(colors @ [0.2126, 0.7152, 0.0722]) > 0)


def test_tables_say_numbers_in_the_words_of_their_columns_or_rows():
    by_column = table(["n", "share of it", "cost (rad2)", "wait (s)"], [[12345, 0.5, 0.12345678, 12.345]])
    shown = re.findall(r"<td[^>]*>(.*?)</td>", by_column.html())
    assert shown == ["12,345", "50.0%", "0.1235", "12.3"]
    by_row = table(["what", "amount", "unit"], [["floor", 12.345, "m2"], ["part", 0.5, "share"], ["links", 2, "links"]])
    shown = re.findall(r"<td[^>]*>(.*?)</td>", by_row.html())
    assert shown == ["floor", "12.3 m²", "part", "50.0%", "links", "2 links"] and "<th>unit</th>" not in by_row.html()
    assert "12.345,m2" in by_row.csv()


def test_table_as_csv_records_and_html():
    found = table(["name", "area (m2)"], [["a, b", np.float64(1.5)], ["c", None], ["d", np.nan]])
    assert list(csv.reader(io.StringIO(found.csv()))) == [["name", "area (m2)"], ["a, b", "1.5"], ["c", ""], ["d", ""]]
    assert found.records()[0] == {"name": "a, b", "area (m2)": 1.5} and found.records()[2]["area (m2)"] is None
    assert '<td class="number">1.50</td>' in found.html() and "<th>area (m²)</th>" in found.html()
    with pytest.raises(ValueError, match="2 columns"):
        table(["name", "area"], [["a"]])


def test_contacts_are_bars_where_feet_are_planted():
    planted = np.zeros((100, 2), dtype=bool)
    planted[:50, 0] = planted[75:, 1] = True
    clips = [ClipContacts("half and quarter", 25.0, planted), ClipContacts("none", 25.0, planted[50:75])]
    boxes = [mark for mark in contact_chart(clips).marks if isinstance(mark, Rectangle)]
    left, right = ([box for box in boxes if box.color == color] for color in (LEFT, RIGHT))
    assert len(left) == len(right) == 1 and left[0].width == pytest.approx(2 * right[0].width)
    # Left above right; time goes to the right; both clips on the same scale.
    assert left[0].y < right[0].y and left[0].x + left[0].width < right[0].x
    whole = [box.width for box in boxes if box.color not in (LEFT, RIGHT)]
    assert whole[0] == whole[1] == pytest.approx(4 * whole[2]) and left[0].width == pytest.approx(whole[0] / 2)
    shares = clips[0].shares
    assert (shares.left, shares.right, shares.both, shares.none) == (0.5, 0.25, 0.0, 0.25)


class _Outline(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.titles, self.sources = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "rect", "polyline", "image", "text"):
            self.open.append(tag)
        self.sources += [value for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag):
        if tag not in ("text", "rect", "polyline", "image"):
            assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.titles.append(data)


def test_page_is_well_formed_and_needs_nothing_from_elsewhere():
    chart = line_chart("Nodes", "k", "n", [Series("a", np.arange(3), np.arange(3))])
    picture = png_bytes(np.zeros((2, 2, 3), np.uint8))
    sections = [
        Section("Reach & <co>", (Paragraph("a < b"), Bullets(("one", "two")), Figure(chart, "Nodes"))),
        Section("Tables", (table(["a"], [[1]]), FigureRow((Figure(picture), Figure(chart))))),
    ]
    page = html_page("Scene <1>", "What can it reach?", sections)
    outline = _Outline()
    outline.feed(page)
    assert outline.open == [] and outline.titles == ["Reach & <co>", "Tables"]
    assert outline.sources and all(source.startswith("data:image/png;base64,") for source in outline.sources)
    assert "<script" not in page and "a &lt; b" in page


def test_texts_that_spreadsheets_would_run_are_inert():
    """Whatever a name begins with, columns and cells alike; numbers stay numbers."""
    names = ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", " =1", "\n=1"]
    written = list(csv.reader(io.StringIO(table(names, [names]).csv(), newline="")))
    for row in written:
        assert [cell.startswith("'") for cell in row] == [True] * len(names)
    assert table(("a", "b"), [(-1, -0.5)]).csv() == "a,b\n-1,-0.5\n"
