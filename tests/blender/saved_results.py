"""The results in a file, taken apart and put together again, sound by their checksums."""

from dataclasses import replace

from bl_ext.user_default.wayfarer.addon.results import file as storage
from bl_ext.user_default.wayfarer.core.archive import archive_from_bytes, archive_to_bytes


def content_of(parts: dict) -> tuple[dict, dict]:
    """Content and arrays of the main archive."""
    return archive_from_bytes(storage.FORMAT, parts[storage.MAIN], "results", lambda *read: read)


def sealed(parts: dict, main: dict, version: int = storage.FORMAT.version, **values) -> dict:
    """The parts with a main archive that has the content and arrays of that in ``main``, but for some values."""
    content, arrays = content_of(main)
    content = {**content, "parts": storage.digests(parts), **values}
    form = replace(storage.FORMAT, version=version)
    return {**parts, storage.MAIN: archive_to_bytes(form, content, arrays)}
