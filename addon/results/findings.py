"""Findings kept with a scene: saved in its file, undone with everything else."""

import hashlib
import json
import weakref
from functools import lru_cache
from typing import Any

from ...core.embedding.embedding import Embedding
from ...core.files import from_json
from ...core.report.drawing import Drawing
from ...core.report.finding import Finding, Questions, Topic
from ...core.report.table import Table, table
from ...core.report.topics import DELETION, METRICS, PRUNING, PRUNING_CURVE, REACH, TOPICS
from .staleness import embedding_is_stale
from .store import results

__all__ = ["DELETION", "METRICS", "PRUNING", "PRUNING_CURVE", "REACH", "TOPICS", "Finding", "Questions", "Topic"]

#: Blender's icons for the signs of rows.
_ICONS = {
    "essential": "CANCEL",
    "important": "ERROR",
    "useful": "CHECKMARK",
    "spare": "REMOVE",
    "redundant": "TRASH",
    "unreached": "CANCEL",
    "few_ways": "ERROR",
    "clip": "ACTION",
    "segment": "ANIM_DATA",
    "new": "ADD",
}


def keep_finding(scene, finding: Finding) -> None:
    """Keep a finding, and those that came with it, in place of earlier ones on the same topics."""
    for other in finding.also:
        keep_finding(scene, other)
    forget_finding(scene, finding.topic)
    kept = scene.wayfarer.findings.add()
    kept.name, kept.made_from = finding.topic.name, mark_of(finding.embedding)
    records = [list(record.values()) for record in finding.table.records()]
    kept.table = json.dumps([finding.table.columns, records])
    kept.numbers = json.dumps(finding.numbers)
    kept.sentences = "\n".join(finding.sentences)
    kept.height = results(scene).ground_height
    for row in finding.rows:
        line = kept.rows.add()
        line.name, line.value, line.note, line.sentence = row.name, row.value, row.note, row.sentence
        line.icon, line.size, line.has_place = _ICONS.get(row.sign, "NONE"), row.size, row.place is not None
        if row.place is not None:
            line.place = row.place


def forget_finding(scene, topic: Topic) -> None:
    """Drop the finding on a topic, if there is one."""
    findings = scene.wayfarer.findings
    place = findings.find(topic.name)
    if place >= 0:
        findings.remove(place)


def find_finding(scene, topic: Topic) -> Any:
    """Return the finding on a topic, as it is kept in the scene; None if there is none, or it is damaged."""
    kept = scene.wayfarer.findings.get(topic.name)
    return None if kept is None or _read(kept.table, kept.numbers) is None else kept


def finding_is_stale(scene, topic: Topic) -> bool:
    """Test whether the finding on a topic is about another embedding than the scene has now."""
    kept, found = find_finding(scene, topic), results(scene)
    if kept is None:
        return False
    embedding = found.whole if topic.of_whole else found.embedding
    return embedding is None or kept.made_from != mark_of(embedding) or embedding_is_stale(scene)


def table_of(kept) -> Table:
    """Return the table of a finding that is kept in a scene."""
    return _contents(kept)[0]


def numbers_of(kept) -> list[tuple[str, str]]:
    """Return the numbers, as (name, text), of a finding that is kept in a scene."""
    return list(_contents(kept)[1])


def _contents(kept) -> tuple[Table, tuple[tuple[str, str], ...]]:
    contents = _read(kept.table, kept.numbers)
    assert contents is not None, "find_finding gives none that cannot be read"
    return contents


@lru_cache(maxsize=32)
def _read(table_text: str, numbers_text: str) -> tuple[Table, tuple[tuple[str, str], ...]] | None:
    """Read what a .blend file keeps of a finding; None if it is damaged, or was never ours."""
    try:
        columns, rows = from_json(table_text)
        if not all(isinstance(value, str | int | float | None) for row in rows for value in row):
            return None
        numbers = tuple((str(name), str(text)) for name, text in from_json(numbers_text))
        return table([str(column) for column in columns], rows), numbers
    except (ValueError, TypeError, LookupError):
        return None


def chart_of(scene, topic: Topic) -> Drawing | None:
    """Draw the finding on a topic; None if there is none, or nothing to draw."""
    kept = find_finding(scene, topic)
    found = None if kept is None else table_of(kept)
    return topic.chart(found) if topic.chart is not None and found is not None and found.rows else None


def mark_of(embedding: Embedding) -> str:
    """Return a digest: the same for the same nodes and links, also after the file was reopened."""
    for known, mark in _marks:
        if known() is embedding:
            return mark
    digest = hashlib.blake2b(digest_size=16)
    grid = embedding.environment.grid
    digest.update(repr((grid.shape, grid.cell_size, tuple(grid.origin), grid.tiled)).encode())
    digest.update(repr(embedding.graph.links.tolist()).encode())
    for segment in embedding.graph.segments:
        digest.update(repr((segment.name, segment.duration, sorted(segment.tags))).encode())
        digest.update(segment.path.tobytes())
    for plane in embedding.planes:
        digest.update(plane.to_bytes((plane.bit_length() + 15) // 8, "little"))
    mark = digest.hexdigest()
    _marks.append((weakref.ref(embedding), mark))
    del _marks[:-_REMEMBERED]
    return mark


_REMEMBERED = 6
_marks: list[tuple[weakref.ref[Embedding], str]] = []
"""Those of late: panels ask at every redraw."""
