"""One program at a time in a folder."""

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

from ..errors import StudyError
from ..files import why

STUDY_LOCK = ".lock"
"""A file in a study's folder that whoever works there has locked."""


@contextlib.contextmanager
def only_one(folder: Path, name: str = STUDY_LOCK) -> Iterator[None]:
    """StudyError while another study works in a folder: they would take away each other's files.

    The lock is the operating system's, and ends with the process, however that ends. ``name`` is that of its file.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = open(folder / name, "ab")  # noqa: SIM115 (closed by the with below)
    except OSError as error:
        raise StudyError(f"'{folder}' cannot be written to ({why(error)}); choose another with --out.") from None
    with file:
        try:
            if sys.platform == "win32":
                import msvcrt

                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            else:
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            raise StudyError(
                f"Another study works in '{folder}' right now; wait for it, stop it, or choose another with --out."
            ) from None
        except OSError:
            # Some shared folders know no locks.
            pass
        yield
