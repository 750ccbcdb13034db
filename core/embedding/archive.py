"""Embeddings in files and in memory: an .npz without pickles, equal to the last bit when it is read."""

import os

from ..archive import archive_from_bytes, archive_to_bytes, load_archive
from .arrays import EMBEDDING_FORMAT, fields_from_arrays, fields_to_arrays
from .embedding import Embedding


def embedding_to_bytes(embedding: Embedding) -> bytes:
    """Return what :meth:`.Embedding.save` writes: the embedding with its graph and environment, as an .npz."""
    return archive_to_bytes(EMBEDDING_FORMAT, *fields_to_arrays(*embedding.fields))


def embedding_from_bytes(raw: bytes, source: str = "embedding") -> Embedding:
    """Return the embedding of :func:`embedding_to_bytes`.

    EmbeddingError, with the name ``source``, for what is damaged, foreign or saved by a later version.
    """
    return Embedding(*archive_from_bytes(EMBEDDING_FORMAT, raw, source, fields_from_arrays))


def load_embedding(path: str | os.PathLike) -> Embedding:
    """Read the embedding that :meth:`.Embedding.save` wrote; EmbeddingError names the file if it cannot be read.

    Nothing in a file is ever executed.
    """
    return embedding_from_bytes(load_archive(path, EMBEDDING_FORMAT), os.fspath(path))
