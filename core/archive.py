"""Values in files: arrays and a header in an .npz that is checked before anything of it is believed.

An archive is a zip of .npy files, as NumPy writes them, and never holds a pickle. Its ``header`` is UTF-8 JSON: the
format's name and version, what is no array, type and shape of every array, and a checksum of them all. Bools are
stored eight to a byte, all other numbers byte by byte (first the lowest bytes of all numbers, and so on), because
alike bytes compress well.

Whatever is damaged, foreign, newer or made up is refused with a sentence. No more is unpacked than the header
announces, and no more may be announced than the file can hold.
"""

import hashlib
import io
import json
import os
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .errors import MotionGraphError

Value = TypeVar("Value")
Arrays = Mapping[str, np.ndarray]

#: Types that arrays may have in an archive, little endian.
_TYPES = ("|b1", "|u1", "<i4", "<i8", "<f8")

#: Deflate makes nothing smaller than this.
_SMALLEST_SHARE = 1 / 1040

_MAX_HEADER_BYTES = 64_000_000
_MAX_BYTES = 4_000_000_000

#: What reading damaged or made up bytes can end in, besides the sentences of this module.
DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MotionGraphError,
    OSError,
    RuntimeError,
    struct.error,
    TypeError,
    ValueError,
)


@dataclass(frozen=True)
class ArchiveFormat:
    """A kind of archive.

    Attributes
    ----------
    name : str
        What an archive holds, for the header and for people: "motion graph".
    version : int
        Archives of later versions are refused.
    error : type
        What is raised for an archive that cannot be read.
    """

    name: str
    version: int
    error: type[MotionGraphError]


def archive_to_bytes(form: ArchiveFormat, content: Mapping[str, Any], arrays: Arrays) -> bytes:
    """The archive in memory; ``content`` is anything that JSON can tell. The same value always makes the same bytes."""
    encoded = {name: _encoded(array) for name, array in arrays.items()}
    header = {
        "format": f"wayfarer {form.name}",
        "version": form.version,
        "arrays": {name: [_type_of(array), list(array.shape)] for name, array in arrays.items()},
        "content": content,
        "sha256": _checksum(content, encoded),
    }
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in {"header": json.dumps(header).encode(), **encoded}.items():
            archive.writestr(_member(name), _npy_start(len(data)) + data)
    return raw.getvalue()


def archive_from_bytes(
    form: ArchiveFormat, raw: bytes, source: str, build: Callable[[dict[str, Any], dict[str, np.ndarray]], Value]
) -> Value:
    """What ``build`` makes of the content and the arrays of an archive.

    Raises the format's error, with ``source`` as the archive's name, if it is damaged, of another format or of a later
    version, and if ``build`` finds that its values do not fit together.
    """
    damaged = f"'{source}' is damaged or no {form.name} that Wayfarer saved, and cannot be read"
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            largest = min(_MAX_HEADER_BYTES, len(raw) / _SMALLEST_SHARE)
            size = archive.getinfo("header.npy").file_size - len(_npy_start(0))
            if not 0 <= size <= largest:
                raise form.error(f"{damaged}: its header is too large.")
            header = json.loads(_read_member(archive, "header", size))
            held, version = str(header["format"]), header["version"]
            if held != f"wayfarer {form.name}":
                raise form.error(f"'{source}' holds a {held.removeprefix('wayfarer ')} and no {form.name}.")
            if version > form.version:
                raise form.error(
                    f"'{source}' was saved by a later version of Wayfarer (format {version}, this one reads up to "
                    f"{form.version}); update the extension."
                )
            kinds = {name: (str(kind), tuple(map(int, shape))) for name, (kind, shape) in header["arrays"].items()}
            sizes = {name: _encoded_bytes(kind, shape) for name, (kind, shape) in kinds.items()}
            if sum(sizes.values()) > min(_MAX_BYTES, len(raw) / _SMALLEST_SHARE):
                raise form.error(f"{damaged}: it announces more than a file of its size can hold.")
            encoded = {name: _read_member(archive, name, size) for name, size in sizes.items()}
        if _checksum(header["content"], encoded) != header["sha256"]:
            raise form.error(f"{damaged}: its checksum does not match.")
        return build(header["content"], {name: _decoded(encoded[name], *kinds[name]) for name in kinds})
    except form.error:
        raise
    except MemoryError as problem:
        raise form.error(f"'{source}' needs more memory than there is, and cannot be read.") from problem
    except DAMAGE as problem:
        raise form.error(f"{damaged} ({problem}).") from problem


def save_archive(path: str | os.PathLike, raw: bytes, form: ArchiveFormat) -> None:
    """Write a file as a whole or not at all: what was there before stays until the new one is complete."""
    path = Path(path)
    temporary = None
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
            temporary = file.name
            file.write(raw)
            file.flush()
            os.fsync(file.fileno())
        # Temporary files are for their owner's eyes only; saved ones are as open as any other new file.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except OSError as problem:
        raise form.error(f"The {form.name} cannot be saved as '{path}': {problem.strerror or problem}.") from problem
    finally:
        if temporary is not None and os.path.exists(temporary):
            os.unlink(temporary)


def load_archive(path: str | os.PathLike, form: ArchiveFormat) -> bytes:
    """The bytes of a file; the format's error if it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as problem:
        raise form.error(f"'{path}' cannot be read: {problem.strerror or problem}.") from problem


def require(fits: object) -> None:
    """ValueError unless something that every sound archive fulfils is so: for those who ``build``."""
    if not fits:
        raise ValueError("its values do not fit together")


def _member(name: str) -> zipfile.ZipInfo:
    info = zipfile.ZipInfo(f"{name}.npy")
    info.compress_type = zipfile.ZIP_DEFLATED
    return info


def _npy_start(n_bytes: int) -> bytes:
    """What a .npy file of ``n_bytes`` bytes starts with."""
    start = io.BytesIO()
    np.lib.format.write_array_header_1_0(start, {"descr": "|u1", "fortran_order": False, "shape": (n_bytes,)})
    return start.getvalue()


def _read_member(archive: zipfile.ZipFile, name: str, n_bytes: int) -> bytes:
    start = _npy_start(n_bytes)
    info = archive.getinfo(f"{name}.npy")
    require(info.compress_type == zipfile.ZIP_DEFLATED)
    with archive.open(info) as file:
        # One byte more, so that what is longer than announced is told from what ends there; CRC is checked at the end.
        data = file.read(len(start) + n_bytes + 1)
    require(len(data) == len(start) + n_bytes and data.startswith(start))
    return data[len(start) :]


def _type_of(array: np.ndarray) -> str:
    kind = array.dtype.newbyteorder("<").str
    if kind not in _TYPES:
        raise TypeError(f"Archives hold no arrays of type {array.dtype}.")
    return kind


def _encoded_bytes(kind: str, shape: tuple[int, ...]) -> int:
    require(kind in _TYPES and all(n >= 0 for n in shape))
    n = 1
    for length in shape:
        n *= length
    return (n + 7) // 8 if kind == "|b1" else n * np.dtype(kind).itemsize


def _encoded(array: np.ndarray) -> bytes:
    kind = _type_of(array)
    if kind == "|b1":
        return np.packbits(array.ravel()).tobytes()
    flat = np.ascontiguousarray(array, dtype=kind).reshape(-1)
    return flat.view(np.uint8).reshape(len(flat), -1).T.tobytes() if len(flat) else b""


def _decoded(data: bytes, kind: str, shape: tuple[int, ...]) -> np.ndarray:
    raw = np.frombuffer(data, dtype=np.uint8)
    if kind == "|b1":
        return np.unpackbits(raw, count=int(np.prod(shape))).astype(bool).reshape(shape)
    by_number = raw.reshape(np.dtype(kind).itemsize, -1).T
    return np.ascontiguousarray(by_number).reshape(-1).view(kind).reshape(shape)


def _checksum(content: Mapping[str, Any], encoded: Mapping[str, bytes]) -> str:
    checksum = hashlib.sha256(json.dumps(content).encode())
    for name, data in encoded.items():
        checksum.update(f"{name} {len(data)} ".encode())
        checksum.update(data)
    return checksum.hexdigest()
