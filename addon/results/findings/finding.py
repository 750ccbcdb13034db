"""What was found out: a table of numbers, and what panels and lists show of it."""

import hashlib
import json
import weakref
from dataclasses import dataclass

from ....core.embedding.embedding import Embedding
from ....core.report.table import Table, table
from ..state import embedding_is_stale, results

#: Kinds of findings, in the order in which they are exported.
METRICS, ACTIONS, LINKS = "METRICS", "ACTIONS", "LINKS"
WEAK_SPOTS, ABLATION, DELETION, CAPTURE, OCCUPANCY = "WEAK_SPOTS", "ABLATION", "DELETION", "CAPTURE", "OCCUPANCY"
PRUNING, PRUNING_CURVE, REACH = "PRUNING", "PRUNING_CURVE", "REACH"

TITLES = {
    METRICS: "Metrics",
    ACTIONS: "Actions",
    LINKS: "Links",
    WEAK_SPOTS: "Weak Spots",
    ABLATION: "What Matters",
    DELETION: "Deletable Clips",
    CAPTURE: "What Is Missing",
    OCCUPANCY: "Occupancy",
    PRUNING: "Pruning",
    PRUNING_CURVE: "Pruning Curve",
    REACH: "Time to Reach",
}

_OF_WHOLE = frozenset({CAPTURE, PRUNING, PRUNING_CURVE})
"""Kinds that speak of the embedding before it was pruned."""


@dataclass(frozen=True)
class Row:
    """A line of a list.

    Attributes
    ----------
    name, value, note : str
        Its three columns.
    sentence : str
        What is said when it is chosen.
    icon : str
    place : (x, y) in metres, or None
        Where it is.
    size : float
        Metres across of what is there.
    """

    name: str
    value: str = ""
    note: str = ""
    sentence: str = ""
    icon: str = "NONE"
    place: tuple[float, float] | None = None
    size: float = 0.0


@dataclass(frozen=True)
class Finding:
    """What was found out about an embedding.

    Attributes
    ----------
    kind : str
    embedding : Embedding
    table : Table
        All of it, as the core says it.
    numbers : tuple of (name, text)
        For the panel, with units.
    rows : tuple of Row
        For the list.
    sentences : tuple of str
    """

    kind: str
    embedding: Embedding
    table: Table
    numbers: tuple[tuple[str, str], ...] = ()
    rows: tuple[Row, ...] = ()
    sentences: tuple[str, ...] = ()


def keep_finding(scene, finding: Finding) -> None:
    """Keep a finding in the scene, in place of an earlier one of its kind."""
    forget_finding(scene, finding.kind)
    kept = scene.wayfarer.findings.add()
    kept.name, kept.made_from = finding.kind, mark_of(finding.embedding)
    records = [list(record.values()) for record in finding.table.records()]
    kept.table = json.dumps([finding.table.columns, records])
    kept.numbers = json.dumps(finding.numbers)
    kept.sentences = "\n".join(finding.sentences)
    kept.height = results(scene).ground_height
    for row in finding.rows:
        line = kept.rows.add()
        line.name, line.value, line.note, line.sentence = row.name, row.value, row.note, row.sentence
        line.icon, line.size, line.has_place = row.icon, row.size, row.place is not None
        if row.place is not None:
            line.place = row.place


def forget_finding(scene, kind: str) -> None:
    """Drop the finding of this kind, if there is one."""
    findings = scene.wayfarer.findings
    place = findings.find(kind)
    if place >= 0:
        findings.remove(place)


def find_finding(scene, kind: str):
    """The finding of this kind, as it is kept in the scene; None if there is none."""
    return scene.wayfarer.findings.get(kind)


def finding_is_stale(scene, kind: str) -> bool:
    """Whether the scene's finding of this kind was made in another embedding than the scene has now."""
    kept, found = find_finding(scene, kind), results(scene)
    if kept is None:
        return False
    embedding = found.whole if kind in _OF_WHOLE else found.embedding
    return embedding is None or kept.made_from != mark_of(embedding) or embedding_is_stale(scene)


def table_of(kept) -> Table:
    """The table of a finding that is kept in a scene."""
    columns, rows = json.loads(kept.table)
    return table(columns, rows)


def numbers_of(kept) -> list[tuple[str, str]]:
    """The numbers, as (name, text), of a finding that is kept in a scene."""
    return [(name, text) for name, text in json.loads(kept.numbers)]


def mark_of(embedding: Embedding) -> str:
    """What tells an embedding from others: the same for the same nodes and links, also after the file was reopened."""
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
