"""The engine format: an embedding as a JSON header and one .npz of plain arrays, for programs that know no Wayfarer.

``docs/engine_format.md`` describes the files; ``assets/engine/wayfarer_reader.py`` is a reader in under 200 lines that
needs NumPy only. A node (x, y, heading, segment) stands where its bit in ``nodes[segment * n_headings + heading]`` is
set; a link leads from it by each stencil that may follow, whose bit in ``valid`` is set, and that ends at a node too.
"""

import hashlib
import io
import json
from collections.abc import Generator
from typing import Any

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.footprint import edit_profile
from ..errors import NOTHING_FITS, ExportError
from ..motion.graph import MotionGraph, MotionSegment
from ..motion.runs import runs
from ..progress import Progress, portion
from .table import engine_table_steps

FORMAT, VERSION = "wayfarer engine embedding", 1
HEADER_FILE, ARRAYS_FILE, TABLE_FILE = "embedding.json", "embedding.npz", "embedding.table"


def engine_files_steps(
    embedding: Embedding, with_table: bool = True
) -> Generator[Progress, None, dict[str, bytes | bytearray]]:
    """Make the files of an embedding, by their names; the same embedding always makes the same bytes.

    Raises ExportError if there is nothing to walk, or the table would be too large.
    """
    if not embedding.n_nodes:
        raise ExportError(f"There is nothing to export: {NOTHING_FITS}")
    table = None
    if with_table:
        # First, because it can be too large.
        table = yield from portion(engine_table_steps(embedding), 0.0, 0.9)
    yield Progress(0.9, "Packing planes")
    files: dict[str, bytes | bytearray] = {ARRAYS_FILE: _npz(engine_arrays(embedding))}
    header = engine_header(embedding)
    header["sha256"] = hashlib.sha256(files[ARRAYS_FILE]).hexdigest()
    header["table"] = None
    if table is not None:
        files[TABLE_FILE] = table
        header["table"] = _described(TABLE_FILE, table)
    return {HEADER_FILE: (json.dumps(header, indent=1) + "\n").encode(), **files}


def _described(name: str, raw: bytes | bytearray) -> dict[str, Any]:
    return {"file": name, "bytes": len(raw), "sha256": hashlib.sha256(raw).hexdigest()}


def engine_header(embedding: Embedding) -> dict[str, Any]:
    """Return the header as JSON has it, but for what it says of the other files."""
    graph, grid = embedding.graph, embedding.environment.grid
    return {
        "format": FORMAT,
        "version": VERSION,
        "up": "Z",
        "units": {"length": "m", "time": "s", "angle": "rad"},
        "grid": {
            "shape": [int(n) for n in grid.shape],
            "cell_size": float(grid.cell_size),
            "origin": [float(x) for x in grid.origin],
            "tiled": bool(grid.tiled),
        },
        "frame_rate": float(graph.frame_rate),
        "clips": [
            {
                "name": clip.name,
                "animation": clip.name,
                "seconds": (clip.n_frames - 1) / clip.frame_rate,
                "first_frame": float(clip.first_frame),
            }
            for clip in graph.clips
        ],
        "segments": [_segment(graph, segment) for segment in graph.segments],
        "nodes": embedding.n_nodes,
        "links": embedding.n_links,
    }


def engine_arrays(embedding: Embedding) -> dict[str, np.ndarray]:
    """Return the arrays by name."""
    layout, stencils = embedding.unrolling.layout, embedding.unrolling.stencils
    segments = embedding.graph.segments
    turned = np.column_stack([stencils.segment, stencils.heading, stencils.dx, stencils.dy, stencils.turn])
    n_frames = [len(segment.path) for segment in segments]
    return {
        "nodes": np.stack([_bits(layout.unpack(plane)) for plane in embedding.planes]),
        "valid": np.stack([_bits(layout.unpack(plane)) for plane in embedding.unrolling.valid]),
        "free": _bits(embedding.environment.free_cells()),
        "follow": np.asarray(embedding.graph.links, dtype="<i4"),
        "stencil": turned.astype("<i4"),
        "error": np.column_stack([stencils.position_error, stencils.heading_error]).astype("<f8"),
        "path": np.concatenate([segment.path for segment in segments]).astype("<f8"),
        "share": np.concatenate([edit_profile(segment) for segment in segments]).astype("<f8"),
        "first": np.concatenate([[0], np.cumsum(n_frames)]).astype("<i4"),
    }


def _segment(graph: MotionGraph, segment: MotionSegment) -> dict[str, Any]:
    # Made-up graphs may have no clips.
    clip = graph.clips[segment.clip].name if graph.clips else ""
    return {
        "name": segment.name,
        "clip": clip,
        "first": int(segment.first),
        "last": int(segment.last),
        "start": segment.first / graph.frame_rate,
        "end": segment.last / graph.frame_rate,
        "frames": segment.n_frames,
        "duration": float(segment.duration),
        "tags": {tag: [list(run) for run in runs(mask)] for tag, mask in segment.tags.items()},
    }


def _bits(cells: np.ndarray) -> np.ndarray:
    """Pack (nx, ny) cells in order of x, then y, eight to a byte, lowest bit first: (B,) uint8."""
    return np.packbits(cells.ravel(), bitorder="little")


def _npz(arrays: dict[str, np.ndarray]) -> bytes:
    raw = io.BytesIO()
    np.savez_compressed(raw, **arrays)
    return raw.getvalue()
