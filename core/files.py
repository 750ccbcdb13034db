"""Files that are written as a whole or not at all: who looks finds the old one or the new one, never a part."""

import os
import uuid
from pathlib import Path

from .errors import StorageError


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
    """Write a file, and its folder if there is none; StorageError, naming the file, if that cannot be done."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, raw)
    except OSError as error:
        raise StorageError(
            f"'{path}' cannot be written ({error.strerror}); free some space or choose another folder, and go on with "
            "the same command."
        ) from None
