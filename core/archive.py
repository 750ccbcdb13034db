"""Values in files: arrays and a header in a compressed .npz that is checked before anything of it is believed.

An archive is what ``numpy.savez_compressed`` writes, and never holds a pickle. Its ``header`` is UTF-8 JSON: the
format's name and version, what is no array, and type and shape of every array. Its ``checksum`` is the SHA-256 of the
header and of all arrays.

Whatever is damaged, foreign, of another version or made up is refused with a sentence. No more is unpacked than the
header announces, and no more may be announced than the file can hold.
"""

import hashlib
import io
import json
import math
import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .errors import MotionGraphError
from .files import LARGEST_RATIO, from_json, read_regular, replace_file, why

Value = TypeVar("Value")
Arrays = Mapping[str, np.ndarray]

#: Types that arrays may have in an archive, little endian.
_TYPES = ("|b1", "|u1", "<i4", "<i8", "<f8")

_MAX_HEADER_BYTES = 64_000_000
_MAX_BYTES = 4_000_000_000

_ALWAYS_BYTES, _LARGEST_RATIO = 64_000_000, 100
"""Bytes that the arrays of an archive may have, and how many times its own size if that is more: real ones are 2 to 40
times as large, so that no small file makes large ones."""

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
        Archives of other versions are refused.
    error : type
        What is raised for an archive that cannot be read.
    """

    name: str
    version: int
    error: type[MotionGraphError]


def archive_to_bytes(form: ArchiveFormat, content: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Return the archive in memory; ``content`` is anything that JSON can hold. The same value makes the same bytes.

    >>> form = ArchiveFormat("point", 1, MotionGraphError)
    >>> raw = archive_to_bytes(form, {"name": "a"}, {"xy": np.array([1.0, 2.0])})
    >>> archive_from_bytes(form, raw, "point.npz", lambda content, arrays: (content["name"], arrays["xy"].tolist()))
    ('a', [1.0, 2.0])
    """
    header = {
        "format": f"wayfarer {form.name}",
        "version": form.version,
        "arrays": {name: [_type_of(array), list(array.shape)] for name, array in arrays.items()},
        "content": content,
    }
    members = {"header": np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)}
    members |= {name: np.asarray(array, dtype=_type_of(array), order="C") for name, array in arrays.items()}
    checksum = np.frombuffer(_checksum(members.values()), dtype=np.uint8)
    raw = io.BytesIO()
    np.savez_compressed(raw, **members, checksum=checksum)
    return raw.getvalue()


def archive_from_bytes(
    form: ArchiveFormat, raw: bytes, source: str, build: Callable[[dict[str, Any], dict[str, np.ndarray]], Value]
) -> Value:
    """Return what ``build`` makes of the content and the arrays of an archive.

    Raises the format's error, with ``source`` as the archive's name, if it is damaged, of another format or version,
    and if ``build`` finds that its values do not fit together.
    """
    damaged = f"'{source}' is damaged or no {form.name} that Wayfarer saved, and cannot be read"
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            raw_header = _read_header(archive, len(raw))
            header = from_json(raw_header.tobytes())
            held, version = str(header["format"]), header["version"]
            if held != f"wayfarer {form.name}":
                raise form.error(f"'{source}' holds a {held.removeprefix('wayfarer ')} and no {form.name}.")
            if version > form.version:
                raise form.error(
                    f"'{source}' was saved by a later version of Wayfarer (format {version}, this one reads "
                    f"{form.version}); update the extension."
                )
            if version < form.version:
                raise form.error(
                    f"'{source}' was saved by an earlier version of Wayfarer (format {version}, this one reads "
                    f"{form.version}); make it anew."
                )
            kinds = {name: (str(kind), tuple(map(int, shape))) for name, (kind, shape) in header["arrays"].items()}
            if sum(_n_bytes(*kind) for kind in kinds.values()) > max(
                _ALWAYS_BYTES, min(_MAX_BYTES, _LARGEST_RATIO * len(raw))
            ):
                raise form.error(f"{damaged}: it announces more than a file of its size can hold.")
            arrays = {name: _read_member(archive, name, *kind) for name, kind in kinds.items()}
            checksum = _read_member(archive, "checksum", "|u1", (hashlib.sha256().digest_size,)).tobytes()
        if checksum != _checksum([raw_header, *arrays.values()]):
            raise form.error(f"{damaged}: its checksum does not match.")
        require(all(np.all(array.view(np.uint8) <= 1) for array in arrays.values() if array.dtype == bool))
        return build(header["content"], arrays)
    except form.error:
        raise
    except MemoryError as problem:
        raise form.error(f"'{source}' needs more memory than there is, and cannot be read.") from problem
    except DAMAGE as problem:
        raise form.error(f"{damaged}.") from problem


def archive_kind(raw: bytes) -> str:
    """Return what an archive says that it holds; one of ``DAMAGE`` if it is none. The rest may be damaged."""
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        return str(from_json(_read_header(archive, len(raw)).tobytes())["format"]).removeprefix("wayfarer ")


def save_archive(path: str | os.PathLike, raw: bytes, form: ArchiveFormat) -> None:
    """Write a file as a whole or not at all: what was there before stays until the new one is complete."""
    try:
        replace_file(Path(path), raw, lasting=True)
    except OSError as problem:
        raise form.error(f"The {form.name} cannot be saved as '{path}': {why(problem)}.") from problem


def load_archive(path: str | os.PathLike, form: ArchiveFormat) -> bytes:
    """Return the bytes of a file; the format's error if it cannot be read."""
    try:
        return read_regular(path)
    except OSError as problem:
        raise form.error(f"'{path}' cannot be read: {why(problem)}.") from problem


def require(fits: object) -> None:
    """Raise ValueError unless something that every sound archive fulfils is so: for those who ``build``."""
    if not fits:
        raise ValueError("its values do not fit together")


def _npy_start(kind: str, shape: tuple[int, ...]) -> bytes:
    """Return what a .npy file of an array starts with."""
    start = io.BytesIO()
    np.lib.format.write_array_header_1_0(start, {"descr": kind, "fortran_order": False, "shape": shape})
    return start.getvalue()


def _read_header(archive: zipfile.ZipFile, n_bytes: int) -> np.ndarray:
    """Return the header of an archive of ``n_bytes`` bytes, as bytes; ValueError if it is too large."""
    size = archive.getinfo("header.npy").file_size - len(_npy_start("|u1", (0,)))
    if not 0 <= size <= min(_MAX_HEADER_BYTES, LARGEST_RATIO * n_bytes):
        raise ValueError("its header is too large")
    return _read_member(archive, "header", "|u1", (size,))


def _read_member(archive: zipfile.ZipFile, name: str, kind: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return an array that is just as announced."""
    start, n_bytes = _npy_start(kind, shape), _n_bytes(kind, shape)
    info = archive.getinfo(f"{name}.npy")
    require(info.compress_type == zipfile.ZIP_DEFLATED)
    with archive.open(info) as file:
        # One byte more, so that what is longer than announced can be seen.
        data = bytearray(file.read(len(start) + n_bytes + 1))
    require(len(data) == len(start) + n_bytes and data.startswith(start))
    return np.frombuffer(data, dtype=kind, offset=len(start)).reshape(shape)


def _type_of(array: np.ndarray) -> str:
    kind = array.dtype.newbyteorder("<").str
    if kind not in _TYPES:
        raise TypeError(f"Archives hold no arrays of type {array.dtype}.")
    return kind


def _n_bytes(kind: str, shape: tuple[int, ...]) -> int:
    require(kind in _TYPES and all(n >= 0 for n in shape))
    return math.prod(shape) * np.dtype(kind).itemsize


def _checksum(members: Iterable[np.ndarray]) -> bytes:
    """Return the SHA-256 of the header and of all arrays in its order; it tells where each ends."""
    checksum = hashlib.sha256()
    for array in members:
        checksum.update(array.tobytes())
    return checksum.digest()
