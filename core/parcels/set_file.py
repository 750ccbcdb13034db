"""Sets of nodes in files, written whole or not at all, and checked when read."""

import contextlib
import struct
import zlib
from pathlib import Path

from ..embedding.node_set import NodeSet
from ..errors import EmbeddingError
from ..files import inflate, read_regular, why, write_whole

_MAGIC = b"WFSET1\n\0"
_HEAD = struct.Struct("<III")
"""Planes, bytes in each, checksum of what follows."""

_SPARSE = 0.1
"""Sets with fewer bits than this share are packed as they are written: packing full ones takes longer than the work."""


def write_set(path: Path, nodes: NodeSet, plane_bytes: int, lasting: bool = False) -> None:
    """Write a set of nodes, whose planes are of up to ``plane_bytes`` bytes each; ``lasting`` ones as small as can be.

    Raises StorageError, naming the file, if the disk is full or cannot be written.
    """
    raw = b"".join(plane.to_bytes(plane_bytes, "little") for plane in nodes.planes)
    is_sparse = len(nodes) < _SPARSE * 8 * len(raw)
    packed = zlib.compress(raw, 6 if lasting else int(is_sparse))
    write_whole(path, _MAGIC + _HEAD.pack(len(nodes.planes), plane_bytes, zlib.crc32(packed)) + packed)


def read_set(path: Path, n_planes: int, plane_bytes: int) -> NodeSet:
    """Read the set of :func:`write_set`; EmbeddingError, naming the file, if it is damaged, missing or too large."""
    try:
        raw = read_regular(path)
    except OSError as error:
        raise EmbeddingError(f"'{path}' cannot be read ({why(error)}); run the embedding again.") from None
    head = len(_MAGIC) + _HEAD.size
    if len(raw) >= head and raw.startswith(_MAGIC):
        *size, checksum = _HEAD.unpack_from(raw, len(_MAGIC))
        packed = memoryview(raw)[head:]
        if size == [n_planes, plane_bytes] and zlib.crc32(packed) == checksum:
            with contextlib.suppress(ValueError):
                data = memoryview(inflate(packed, n_planes * plane_bytes))
                starts = range(0, n_planes * plane_bytes, plane_bytes)
                return NodeSet(tuple(int.from_bytes(data[i : i + plane_bytes], "little") for i in starts))
    raise EmbeddingError(f"'{path}' is damaged; delete it and run the embedding again.")


def remove_sets(folder: Path) -> None:
    """Remove the sets in a folder, and the folder if nothing else is in it; links are not followed."""
    if folder.is_symlink() or not folder.is_dir():
        return
    for path in folder.glob("*.set"):
        with contextlib.suppress(OSError):
            if not path.is_symlink() and _begins(path):
                path.unlink()
    with contextlib.suppress(OSError):
        folder.rmdir()


def _begins(path: Path) -> bool:
    with open(path, "rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC
