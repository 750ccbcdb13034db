"""Findings as files: JSON with everything, tables as CSV, charts as SVG, the painted map as SVG and PNG."""

import json
from collections.abc import Sequence
from pathlib import Path

import bpy

from ...core.errors import EvaluationError
from ...core.files import write_files
from ...core.maps.colors import displayed
from ...core.maps.legend import ColorBar, MapLegend, Swatch
from ...core.report.chart import map_chart
from ...core.report.drawing import Drawing, svg
from ...core.report.floor_chart import picture_of
from ...core.report.png import png_bytes
from ..bridge.write_colors import painted_cell_size, painted_colors
from ..render.floor import floor_legend
from ..results.findings import TOPICS, Topic, chart_of, find_finding, finding_is_stale, numbers_of, table_of
from ..results.shown import find_painted
from ..results.store import results


def export_results(scene, folder: Path, as_json: bool, as_csv: bool, as_pictures: bool) -> list[Path]:
    """Write the scene's findings to a folder that exists; returns the files.

    Raises EvaluationError if nothing is to be written, StorageError if a file in the folder is not ours to
    replace, or the folder cannot be written to.
    """
    files: dict[str, bytes] = {}
    topics = [topic for topic in TOPICS if find_finding(scene, topic) is not None]
    if as_json:
        files["results.json"] = (json.dumps(_everything(scene, topics), indent=2) + "\n").encode()
    for topic in topics if as_csv else ():
        files[f"{topic.name.lower()}.csv"] = table_of(find_finding(scene, topic)).csv().encode()
    for topic in topics if as_pictures else ():
        chart = chart_of(scene, topic)
        if chart is not None:
            files[f"{topic.name.lower()}.svg"] = svg(chart).encode()
    floor = find_painted(scene)
    if as_pictures and floor is not None:
        drawing = _map_drawing(floor)
        files |= {"map.svg": svg(drawing).encode(), "map.png": png_bytes(picture_of(drawing))}
    if not files:
        raise EvaluationError("Nothing is to be written; choose JSON, CSV or Pictures.")
    write_files(folder, files)
    return [folder / name for name in files]


def _everything(scene, topics: Sequence[Topic]) -> dict:
    embedding, found = results(scene).embedding, {}
    for topic in topics:
        kept = find_finding(scene, topic)
        found[topic.name.lower()] = {
            "title": topic.title,
            "up_to_date": not finding_is_stale(scene, topic),
            "numbers": dict(numbers_of(kept)),
            "sentences": kept.sentences.splitlines(),
            "table": table_of(kept).records(),
        }
    size = {} if embedding is None else {"nodes": embedding.n_nodes, "links": embedding.n_links}
    return {"file": bpy.data.filepath, "scene": scene.name, "embedding": size, "findings": found}


def _map_drawing(floor) -> Drawing:
    """Draw the painted floor with its legend."""
    legend, colors = floor_legend(floor), painted_colors(floor)
    shown = legend if legend is not None else MapLegend("Map")
    entries: list[Swatch | ColorBar] = []
    if shown.bar is not None:
        ticks = tuple((at, f"{text} {shown.unit}") for at, text in shown.bar.ticks)
        entries.append(ColorBar(shown.bar.stops, ticks))
    entries += shown.swatches
    return map_chart(shown.title, displayed(colors[..., :3]), painted_cell_size(floor), entries, width=720)
