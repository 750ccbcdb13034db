"""Folders to write to: what Wayfarer wrote there before is replaced, and nothing else ever is."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from ...core.errors import ExportError, StorageError
from ...core.files import write_whole

_LIST = ".wayfarer.json"
"""Names and checksums of the files that Wayfarer wrote into a folder."""


def check_folder(folder: Path, names: Iterable[str]) -> None:
    """ExportError if one of these files is there, but not as Wayfarer wrote it."""
    known = _known(folder)
    for name in names:
        path = folder / name
        try:
            is_there = path.exists()
        except OSError as error:
            raise ExportError(f"'{path}' cannot be written ({error.strerror}); choose another folder.") from None
        if is_there and (path.is_dir() or known.get(name) != _checksum(path)):
            raise ExportError(
                f"'{folder}' holds a '{name}' that Wayfarer did not write, or that was changed since; choose another "
                "folder, or move it away. Nothing was written."
            )


def remember(folder: Path, names: Iterable[str]) -> None:
    """Note that these files, as far as they are there, are Wayfarer's to replace; StorageError if that cannot be."""
    known = _known(folder)
    known.update({name: _checksum(folder / name) for name in names if (folder / name).is_file()})
    write_whole(folder / _LIST, (json.dumps(known, indent=1) + "\n").encode())


def write_files(folder: Path, files: Mapping[str, bytes | bytearray]) -> None:
    """Write files, each whole or not at all; ExportError if one is not ours to replace, StorageError if that fails."""
    check_folder(folder, files)
    written = []
    try:
        for name, raw in files.items():
            write_whole(folder / name, raw)
            written.append(name)
    finally:
        if written:
            remember(folder, written)


def remove_earlier(folder: Path, names: Iterable[str]) -> None:
    """Remove these files, as far as they are there as Wayfarer wrote them; StorageError if that cannot be."""
    known = _known(folder)
    for name in names:
        path = folder / name
        if name in known and path.is_file() and known[name] == _checksum(path):
            try:
                path.unlink()
            except OSError as error:
                raise StorageError(f"'{path}' cannot be removed ({error.strerror}); remove it yourself.") from None


def _known(folder: Path) -> dict[str, str]:
    try:
        found = json.loads((folder / _LIST).read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _checksum(path: Path) -> str:
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while block := file.read(2**20):
                digest.update(block)
    except OSError as error:
        raise ExportError(f"'{path}' is in the way and cannot be read ({error.strerror}); move it away.") from None
    return digest.hexdigest()
