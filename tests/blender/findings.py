"""The sample, embedded, and what tests of evaluation, tuning and queries ask of it."""

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon.results import findings, store

operators = bpy.ops.wayfarer
BLOCKS = ("objects", "meshes", "actions", "collections", "curves", "materials", "images")


def run(*steps):
    for step in steps:
        assert getattr(operators, step)() == {"FINISHED"}


def found() -> store.SceneResults:
    return store.results(bpy.context.scene)


def embedding():
    return found().embedding


def kept(kind):
    return findings.find_finding(bpy.context.scene, kind)


def rows(kind) -> list[tuple]:
    """The table of a finding, row by row."""
    return list(findings.table_of(kept(kind)).rows)


def is_stale(kind) -> bool:
    return findings.finding_is_stale(bpy.context.scene, kind)


def lines(kind) -> list[str]:
    return [row.name for row in kept(kind).rows]


def contents() -> dict:
    """Everything that these operators could leave behind, and what they could change."""
    scene = bpy.context.scene
    there = {name: sorted(block.name for block in getattr(bpy.data, name)) for name in BLOCKS}
    there["findings"] = [(f.name, f.made_from, f.table, len(f.rows)) for f in scene.wayfarer.findings]
    there["clips"] = [(clip.action.name, clip.use) for clip in scene.wayfarer.clips]
    there["pruned"] = scene.wayfarer.tuning.pruned
    there["map"] = scene.wayfarer.map.quantity
    there["cursor"] = tuple(scene.cursor.location)
    there["selected"] = sorted(obj.name for obj in scene.objects if obj.select_get())
    return there


def refused(operator, **options) -> str:
    """What an operator says that does not run, or fails: the scene, and the embedding, are what they were."""
    before, had = contents(), embedding()
    with pytest.raises(RuntimeError) as error:
        operator(**options)
    assert contents() == before and embedding() is had
    return str(error.value)


def undone(name, **options) -> None:
    """An operator changes something, and one undo takes all of it back."""
    bpy.ops.ed.undo_push(message="before")
    before, had = contents(), embedding()
    assert getattr(operators, name)("EXEC_DEFAULT", True, **options) == {"FINISHED"}
    assert contents() != before
    bpy.ops.ed.undo()
    assert contents() == before and embedding() is had
