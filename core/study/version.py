"""Versions of Wayfarer: results of different versions are never taken for one another."""

import hashlib
from functools import cache
from pathlib import Path

_CORE = Path(__file__).resolve().parents[1]


def core_version() -> str:
    """Return a digest of the core's source: whatever may change a number changes it."""
    return source_digest(_CORE)


@cache
def source_digest(folder: Path) -> str:
    """Return a digest of all Python source in a folder."""
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*.py"), key=lambda path: path.relative_to(folder).as_posix()):
        # Line ends differ between machines that share a study.
        source = file.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{file.relative_to(folder).as_posix()} {len(source)} ".encode() + source)
    return digest.hexdigest()[:16]
