"""Pictures as PNG (ISO/IEC 15948): the one image format that can be written with the standard library alone."""

import struct
import zlib

import numpy as np


def png_bytes(pixels: np.ndarray) -> bytes:
    """Encode an image as the bytes of a PNG file.

    Parameters
    ----------
    pixels : (rows, columns, 3 or 4) uint8 array
        sRGB, with alpha if there are four components; the first row is on top.

    Raises
    ------
    ValueError
        The array has another shape or type.
    """
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or pixels.dtype != np.uint8 or pixels.size == 0:
        raise ValueError(f"an array of shape {pixels.shape} and type {pixels.dtype} is no picture")
    rows, columns, channels = pixels.shape
    # Each row is preceded by the filter that it was written with: none.
    raw = np.zeros((rows, 1 + columns * channels), dtype=np.uint8)
    raw[:, 1:] = pixels.reshape(rows, -1)
    header = struct.pack(">IIBBBBB", columns, rows, 8, 2 if channels == 3 else 6, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(raw.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
