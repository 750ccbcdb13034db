"""The engine format: an embedding as a JSON header and one .npz of plain arrays, for programs that know no Wayfarer.

``embedding.json`` holds what people read, ``embedding.npz`` (standard NumPy, no pickles) the arrays, and
``embedding.table`` the same nodes and links as a plain table (:mod:`.table`). All are described in
``docs/engine_format.md``; ``assets/engine/wayfarer_reader.py`` is a reader in under 200 lines that needs NumPy only.

Header
    ``format`` "wayfarer engine embedding", ``version`` 1, ``up`` "Z", ``units``; ``grid`` (``shape`` = cells in x,
    cells in y, headings; ``cell_size``, ``origin``, ``tiled``); ``frame_rate``; ``clips`` (``name``, ``animation``,
    ``seconds``, ``first_frame``); ``segments`` (``name``, ``clip``, ``first``, ``last``, ``start``, ``end``,
    ``frames``, ``duration``, ``tags``); ``nodes``, ``links`` (how many there are); ``sha256`` of the .npz; ``table``
    (``file``, ``bytes``, ``sha256``), null if there is none.
Arrays (S segments, H headings, K stencils, F frames of all segments together)
    ``nodes`` (S * H, B) uint8 and ``valid`` (K, B) uint8: bit-planes over the cells, bit x * ny + y, lowest bit first.
    ``free`` (B,) uint8: cells at whose centre the character may stand. ``follow`` (L, 2) int32: segment follow[i, 1]
    may be played after follow[i, 0]. ``stencil`` (K, 5) int32: segment, start heading, dx, dy, turn. ``error`` (K, 3)
    float64: what the edit adds to the segment's own end: x, y (m, world frame), heading (rad). ``path`` (F, 3)
    float64: x, y, heading of each frame relative to the segment's first. ``share`` (F,) float64: part of the error that
    is added up to each frame, 0 to 1. ``first`` (S + 1,) int32: where each segment's frames begin.

A node (x, y, heading, segment) stands where its bit in ``nodes[segment * H + heading]`` is set. A link leads from it by
stencil k if the stencil's segment may follow, its heading is the node's, the cell's bit in ``valid[k]`` is set, and its
end (x + dx, y + dy, heading + turn, segment k) is a node too. Every node has such a link: a walk never ends.
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
from ..progress import Progress, portion
from .table import engine_table_steps

FORMAT, VERSION = "wayfarer engine embedding", 1
HEADER_FILE, ARRAYS_FILE, TABLE_FILE = "embedding.json", "embedding.npz", "embedding.table"


def engine_files_steps(
    embedding: Embedding, with_table: bool = True
) -> Generator[Progress, None, dict[str, bytes | bytearray]]:
    """The files of an embedding, by their names; the same embedding always makes the same bytes.

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
        header["table"] = _told(TABLE_FILE, table)
    return {HEADER_FILE: (json.dumps(header, indent=1) + "\n").encode(), **files}


def _told(name: str, raw: bytes | bytearray) -> dict[str, Any]:
    return {"file": name, "bytes": len(raw), "sha256": hashlib.sha256(raw).hexdigest()}


def engine_header(embedding: Embedding) -> dict[str, Any]:
    """The header as JSON can tell it, but for what it says of the other files."""
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
    """The arrays by name."""
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
        "tags": {tag: _ranges(mask) for tag, mask in segment.tags.items()},
    }


def _ranges(mask: np.ndarray) -> list[list[int]]:
    """First and last frame of each stretch of frames that carry a tag."""
    steps = np.diff(np.concatenate([[0], np.asarray(mask, dtype=int), [0]]))
    return np.column_stack([np.flatnonzero(steps > 0), np.flatnonzero(steps < 0) - 1]).tolist()


def _bits(cells: np.ndarray) -> np.ndarray:
    """(B,) uint8: the (nx, ny) cells in order of x, then y, eight to a byte, lowest bit first."""
    return np.packbits(cells.ravel(), bitorder="little")


def _npz(arrays: dict[str, np.ndarray]) -> bytes:
    raw = io.BytesIO()
    np.savez_compressed(raw, **arrays)
    return raw.getvalue()
