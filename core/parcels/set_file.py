"""Sets of nodes in files, written whole or not at all, and checked when read."""

import struct
import zlib
from pathlib import Path

from ..embedding.node_set import NodeSet
from ..errors import EmbeddingError
from ..files import write_whole

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


def read_set(path: Path) -> NodeSet:
    """Read the set of :func:`write_set`; EmbeddingError, naming the file, if it is damaged or missing."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise EmbeddingError(f"'{path}' cannot be read ({error.strerror}); run the embedding again.") from None
    head = len(_MAGIC) + _HEAD.size
    if len(raw) >= head and raw.startswith(_MAGIC):
        n_planes, plane_bytes, checksum = _HEAD.unpack_from(raw, len(_MAGIC))
        packed = memoryview(raw)[head:]
        if zlib.crc32(packed) == checksum:
            data = memoryview(zlib.decompress(packed))
            return NodeSet(
                tuple(
                    int.from_bytes(data[i : i + plane_bytes], "little")
                    for i in range(0, n_planes * plane_bytes, plane_bytes)
                )
            )
    raise EmbeddingError(f"'{path}' is damaged; delete it and run the embedding again.")
