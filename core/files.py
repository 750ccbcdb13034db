"""Files of people's own: what is read is a regular file of a known size, what is written is whole, and only what
Wayfarer wrote itself is ever replaced or removed.

A folder that Wayfarer writes to holds a list, ``.wayfarer.json``, of the files that it wrote there, with their SHA-256
checksums. A file that stands alone carries its checksum inside (:func:`sealed`). Names decide nothing, and no link
inside such a folder is followed.
"""

import errno
import hashlib
import io
import json
import math
import os
import stat
import struct
import uuid
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .errors import StorageError

LIST_FILE = ".wayfarer.json"
"""Names and checksums of the files that Wayfarer wrote into a folder."""

LARGEST_FILE = 4_000_000_000
LARGEST_TEXT = 16_000_000
"""Bytes of the largest files that are read: of any, and of those that people write by hand."""

LARGEST_RATIO = 1040
"""Deflate makes nothing smaller than this share of it."""

NO_FILE = "it is a folder or a device, and no file"
_NO_NAME = "no file can have such a name"

_REASONS = {
    errno.ENOENT: "there is no such file or folder",
    errno.ENOTDIR: "a part of its path is a file, and no folder",
    errno.EISDIR: "it is a folder",
    errno.EEXIST: "there is something of that name already",
    errno.ENOTEMPTY: "its folder is not empty",
    errno.EACCES: "you have no permission for that",
    errno.EPERM: "you have no permission for that",
    errno.EROFS: "its disk cannot be written to",
    errno.ENOSPC: "the disk is full",
    errno.EFBIG: "its disk does not hold files as large as that",
    errno.EIO: "its disk does not work as it should",
    errno.ENAMETOOLONG: "its name is too long",
    errno.EILSEQ: _NO_NAME,
    errno.EINVAL: _NO_NAME,
    errno.ELOOP: "links lead in a circle",
    errno.EBUSY: "another program uses it",
    errno.ETXTBSY: "another program uses it",
    errno.EMFILE: "too many files are open",
    errno.ENFILE: "too many files are open",
    errno.EPIPE: "the program that was to read it has ended",
    errno.EBADF: "it is closed",
    errno.ENOMEM: "there is not enough memory",
}
"""What the system may say about a file, by its number."""

_IN_USE = (32, 33)
"""Windows' numbers for files that another program holds; Python takes them for missing permissions."""


class FileError(OSError):
    """A file that is not read for a reason of ours, which is its ``strerror``."""


def why(error: OSError | ValueError) -> str:
    """Return why the system does not read or write a file, as a part of a sentence in our own words.

    >>> why(FileNotFoundError(errno.ENOENT, "No such file or directory"))
    'there is no such file or folder'
    """
    if isinstance(error, ValueError):
        return _NO_NAME  # what Python itself refuses before it asks the system
    if isinstance(error, FileError):
        return str(error.strerror)
    if getattr(error, "winerror", None) in _IN_USE:
        return _REASONS[errno.EBUSY]
    return _REASONS.get(error.errno or 0, "the system does not do it, for a reason that is not known here")


_SEAL = "sha256"

# ------------------------------------------------------------------------------------------------ reading


def full_path(path: str | os.PathLike) -> Path:
    """Return a path from the root, with links followed as far as they lead anywhere; those in a circle stay."""
    return Path(os.path.realpath(path))


def read_regular(path: str | os.PathLike, largest: int = LARGEST_FILE) -> bytes:
    """Return the bytes of a regular file; OSError, see :func:`why`, for anything else.

    Devices and pipes, and links to them, are refused before anything is read, as is a file of more than ``largest``
    bytes.
    """
    if "\0" in os.fspath(path):
        raise FileError(errno.EINVAL, _NO_NAME, os.fspath(path))
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise FileError(errno.EINVAL, NO_FILE, os.fspath(path))
    # Whatever has taken its place meanwhile: a pipe without a writer must not hold us up.
    with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise FileError(errno.EINVAL, NO_FILE, os.fspath(path))
        size = os.fstat(file.fileno()).st_size
        if size > largest:
            raise FileError(errno.EFBIG, f"it is larger than {largest // 1_000_000:,} MB", os.fspath(path))
        return file.read(size)


def from_json(raw: str | bytes) -> Any:
    """Return what JSON says; ValueError, and nothing else, for what is none or is nested too deeply.

    >>> from_json('{"a": [1, 2]}')
    {'a': [1, 2]}
    """
    try:
        return json.loads(raw)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def inflate(packed: bytes | memoryview, size: int) -> bytes:
    """Return the ``size`` bytes that zlib packed; ValueError, before more is unpacked, if there are not so many.

    >>> inflate(zlib.compress(b"walk"), 4)
    b'walk'
    """
    try:
        unpacking = zlib.decompressobj()
        raw = unpacking.decompress(packed, size + 1)
    except zlib.error as error:
        raise ValueError("it is damaged") from error
    if len(raw) != size or not unpacking.eof:
        raise ValueError("it does not hold what it announces")
    return raw


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of an .npz that NumPy wrote; OSError or ValueError if it is damaged or none.

    Nothing in it is executed, and no array is made that is larger than what the file holds for it.
    """
    raw, found = read_regular(path), {}
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > min(LARGEST_FILE, len(raw) * LARGEST_RATIO):
                raise ValueError("it announces more than a file of its size can hold")
            for member in members:
                with archive.open(member) as file:
                    found[member.filename.removesuffix(".npy")] = _array(file.read(member.file_size))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, struct.error) as error:
        raise ValueError("it is damaged") from error
    return found


def map_array(path: Path) -> np.ndarray:
    """Return the array of a .npy, which stays on the disk; OSError or ValueError if it is damaged or none."""
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise FileError(errno.EINVAL, NO_FILE, os.fspath(path))
    return np.load(path, mmap_mode="r", allow_pickle=False)


def _array(raw: bytes) -> np.ndarray:
    file = io.BytesIO(raw)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("it holds an array of an unknown version")
    shape, fortran_order, kind = np.lib.format.read_array_header_1_0(file)
    if kind.hasobject or math.prod(shape) * kind.itemsize != len(raw) - file.tell():
        raise ValueError("it holds an array that is not as large as it announces")
    return np.frombuffer(raw, kind, offset=file.tell()).reshape(shape, order="F" if fortran_order else "C")


# ------------------------------------------------------------------------------------------------ writing


def replace_file(path: Path, raw: bytes | bytearray, lasting: bool = False) -> None:
    """Write a file in place of what was there before, which stays until the new one is complete.

    A ``lasting`` one is on the disk when this returns, whatever happens to the machine. Raises OSError.
    """
    # Not tempfile's, which are for their owner's eyes only: workers may be other users.
    temporary = path.with_name(f".writing-{uuid.uuid4().hex}")
    try:
        with open(temporary, "xb") as file:
            file.write(raw)
            if lasting:
                file.flush()
                os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_whole(path: Path, raw: bytes | bytearray) -> None:
    """Write a file so that whoever looks finds all of it or none; StorageError if that cannot be done.

    A link of that name is replaced, not followed.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, raw)
    except (OSError, ValueError) as error:
        raise StorageError(
            f"'{path}' cannot be written ({why(error)}); free some space or choose another folder, and go on with the "
            "same command."
        ) from None


def check_folder(folder: Path, names: Iterable[str]) -> None:
    """Raise StorageError if one of these files is there, but not as Wayfarer wrote it, or lies behind a link.

    Names may lead into folders below ``folder``: "read/scenes/room.npz".
    """
    known = _known(folder)
    for name in names:
        _check_links(folder, name)
        path = folder / name
        if _is_there(path) and not _is_ours(path, known.get(name, ())):
            raise StorageError(
                f"'{folder}' holds a '{name}' that Wayfarer did not write, or that was changed since; choose another "
                "folder, or move it away. Nothing was written."
            )


def write_files(folder: Path, files: Mapping[str, bytes | bytearray]) -> None:
    """Write files by their names, each whole or not at all.

    Raises StorageError if one of them is not ours to replace, before any is written, or if writing fails.
    """
    check_folder(folder, files)
    known = _known(folder)
    # First the list, so that whatever stops us leaves nothing that we do not know again.
    known |= {name: tuple(dict.fromkeys((_checksum(raw), *known.get(name, ())[:2]))) for name, raw in files.items()}
    _write_list(folder, known)
    for name, raw in files.items():
        write_whole(folder / name, raw)


def remove_files(folder: Path, names: Iterable[str]) -> None:
    """Remove these files, as far as they are there as Wayfarer wrote them; StorageError if that cannot be."""
    known, names = _known(folder), list(names)
    for name in names:
        path = folder / name
        if name not in known or not _is_there(path):
            continue
        _check_links(folder, name)
        try:
            if _is_ours(path, known[name]):
                path.unlink()
        except OSError as error:
            raise StorageError(f"'{path}' cannot be removed ({why(error)}); remove it yourself.") from None
    if known.keys() & set(names):
        _write_list(folder, {name: sums for name, sums in known.items() if name not in names})


def sealed(content: Mapping[str, Any]) -> bytes:
    """Return JSON that carries a checksum of itself; what JSON does not know has been made plain before.

    >>> is_sealed(sealed({"nodes": 12})), is_sealed(b'{"nodes": 12}')
    (True, False)
    """
    return (json.dumps({**content, _SEAL: _checksum(json.dumps(content).encode())}) + "\n").encode()


def is_sealed(raw: bytes) -> bool:
    """Return True if that is the JSON of :func:`sealed`, and nobody changed it."""
    try:
        content = from_json(raw)
        seal = content.pop(_SEAL)
        return seal == _checksum(json.dumps(content).encode())
    except (ValueError, KeyError, TypeError, AttributeError):
        return False


def check_alone(path: Path) -> None:
    """Raise StorageError if there is something in the place of a sealed file that does not carry our seal."""
    if not _is_there(path):
        return
    try:
        ours = not path.is_symlink() and is_sealed(read_regular(path))
    except OSError:
        ours = False
    if not ours:
        raise StorageError(
            f"'{path}' is there already, and Wayfarer did not write it, or it was changed since; choose another name, "
            "or move it away. Nothing was written."
        )


def check_marked(path: Path, mark: bytes) -> None:
    """Raise StorageError if there is something in the place of a file that does not begin with ``mark``.

    For files named after what they are made from, which may be damaged and are made again.
    """
    if not _is_there(path):
        return
    try:
        ours = not path.is_symlink() and read_regular(path).startswith(mark)
    except OSError:
        ours = False
    if not ours:
        raise StorageError(f"'{path}' is in the way; move it away, or choose another folder. Nothing was written.")


def write_alone(path: Path, content: Mapping[str, Any]) -> None:
    """Write a sealed file of its own, whole or not at all; StorageError if it is not ours to replace."""
    check_alone(path)
    write_whole(path, sealed(content))


def check_plain(folder: Path, names: Iterable[str]) -> None:
    """Raise StorageError if one of these folders inside ``folder`` is a link, or no folder."""
    for name in names:
        _check_links(folder, f"{name}/")
        path = folder / name
        if _is_there(path) and not path.is_dir():
            raise StorageError(f"'{path}' is in the way; move it away, or choose another folder. Nothing was written.")


def _check_links(folder: Path, name: str) -> None:
    path = folder
    for part in Path(name).parts[: None if name.endswith("/") else -1]:
        path = path / part
        if path.is_symlink() or getattr(os.path, "isjunction", os.path.islink)(path):
            raise StorageError(
                f"'{path}' is a link to somewhere else, which is not followed; choose another folder, or put a folder "
                "in its place. Nothing was written."
            )


def _is_there(path: Path) -> bool:
    try:
        return os.path.lexists(path)
    except (OSError, ValueError):
        raise StorageError(f"'{path}' cannot be written; choose another folder.") from None


def _is_ours(path: Path, checksums: Iterable[str]) -> bool:
    """Return True if that is a file, and no link, with one of these checksums."""
    if not checksums or path.is_symlink():
        return False
    try:
        return _checksum(read_regular(path)) in checksums
    except OSError:
        return False


def _known(folder: Path) -> dict[str, tuple[str, ...]]:
    """Return the checksums of each file of ours in a folder: of the present one, and of the one before it, as writing
    may have ended between the two."""
    path = folder / LIST_FILE
    if not _is_there(path):
        return {}
    try:
        found = from_json(read_regular(path, LARGEST_TEXT)) if not path.is_symlink() else None
    except (OSError, ValueError):
        found = None
    if not isinstance(found, dict):
        raise StorageError(
            f"'{path}' is no list of files that Wayfarer wrote; choose another folder, or move it away. Nothing was "
            "written."
        )
    # Earlier versions knew one checksum of each.
    return {
        name: (sums,) if isinstance(sums, str) else tuple(map(str, sums)) if isinstance(sums, list) else ()
        for name, sums in found.items()
    }


def _write_list(folder: Path, known: Mapping[str, tuple[str, ...]]) -> None:
    write_whole(folder / LIST_FILE, (json.dumps(known, indent=1) + "\n").encode())


def _checksum(raw: bytes | bytearray) -> str:
    return hashlib.sha256(raw).hexdigest()
