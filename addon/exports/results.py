"""What was found out as files: JSON with everything, tables as CSV, charts and the painted map as PNG."""

import json
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import EvaluationError
from ...core.maps.colors import displayed
from ...core.maps.legend import MapLegend
from ...core.maps.scales import ColorScale
from ...core.report.chart import ColorBar, Swatch, map_chart
from ...core.report.drawing import Drawing
from ...core.report.png import png_bytes
from ..bridge.write_colors import painted_cell_size, painted_colors
from ..render.floor import floor_legend
from ..render.raster import rasterize
from ..results.findings.charts import chart_of
from ..results.findings.finding import TITLES, finding_is_stale, numbers_of, table_of
from ..results.state import find_painted, results
from .folder import write_files

_MAP = "map"


def export_results(scene, folder: Path, as_json: bool, as_csv: bool, as_png: bool) -> list[Path]:
    """Write the scene's findings to a folder that exists; returns the files.

    Raises EvaluationError if nothing is to be written, ExportError if a file in the folder is not ours to replace,
    StorageError if the folder cannot be written to.
    """
    files: dict[str, bytes] = {}
    kept = [scene.wayfarer.findings[kind] for kind in TITLES if kind in scene.wayfarer.findings]
    if as_json:
        files["results.json"] = (json.dumps(_everything(scene, kept), indent=2) + "\n").encode()
    for finding in kept if as_csv else ():
        files[f"{finding.name.lower()}.csv"] = table_of(finding).csv().encode()
    for finding in kept if as_png else ():
        chart = chart_of(finding)
        if chart is not None:
            files[f"{finding.name.lower()}.png"] = _png(chart)
    floor = find_painted(scene)
    if as_png and floor is not None:
        files[f"{_MAP}.png"] = _png(_map_drawing(floor))
    if not files:
        raise EvaluationError("Nothing is to be written; choose JSON, CSV or PNG.")
    write_files(folder, files)
    return [folder / name for name in files]


def _everything(scene, kept) -> dict:
    embedding = results(scene).embedding
    found = {
        finding.name.lower(): {
            "title": TITLES[finding.name],
            "up_to_date": not finding_is_stale(scene, finding.name),
            "numbers": dict(numbers_of(finding)),
            "sentences": finding.sentences.splitlines(),
            "table": table_of(finding).records(),
        }
        for finding in kept
    }
    size = {} if embedding is None else {"nodes": embedding.n_nodes, "links": embedding.n_links}
    return {"file": bpy.data.filepath, "scene": scene.name, "embedding": size, "findings": found}


def _map_drawing(floor) -> Drawing:
    """The painted floor, with its legend."""
    legend, colors = floor_legend(floor), painted_colors(floor)
    shown = legend if legend is not None else MapLegend("Map")
    entries: list[Swatch | ColorBar] = []
    if shown.bar is not None:
        ticks = shown.bar.ticks
        scale = ColorScale(shown.title, shown.bar.stops)
        entries.append(ColorBar(scale, f"{ticks[0][1]} {shown.unit}", f"{ticks[-1][1]} {shown.unit}"))
    entries += [Swatch(swatch.color, f"{swatch.text} {swatch.value}".strip()) for swatch in shown.swatches]
    return map_chart(shown.title, displayed(colors[..., :3]), painted_cell_size(floor), entries, width=720)


def _png(drawing: Drawing) -> bytes:
    pixels = np.round(255 * np.clip(rasterize(drawing)[::-1], 0.0, 1.0)).astype(np.uint8)
    return png_bytes(np.ascontiguousarray(pixels))
