"""Whatever an artist does, in whatever order: no error but a reported sentence, nothing left behind, nothing stale
shown as fresh.

Random steps on the sample, the same every time. WAYFARER_FUZZ_STEPS=5000 makes it long, WAYFARER_FUZZ_SEED another.
"""

import os
import random
from collections import Counter

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon import state
from bl_ext.user_default.wayfarer.addon.inputs import make_environment, read_shapes
from bl_ext.user_default.wayfarer.addon.workflow import build_graph_steps
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.errors import MotionGraphError
from bl_ext.user_default.wayfarer.core.progress import finish

N_STEPS = int(os.environ.get("WAYFARER_FUZZ_STEPS", "150"))
SEED = int(os.environ.get("WAYFARER_FUZZ_SEED", "0"))
EPISODE = 50
"""Steps after which the sample is opened again: so much has been deleted by then."""

# They need a window, or add to the file because that is what they are for.
LEFT_OUT = {"pick_place", "add_sample_character", "add_sample_room", "import_bvh", "append_actions", "apply_remedy"}
# They are what the rest depends on.
LIKELY = ("build_motion_graph", "embed", "embed", "paint_map", "random_walk", "prune")
MARGIN = 150
"""Datablocks beyond those of the sample that results may take: floor, curves of walks, crowd, charts, materials."""

LEFT_AT_THE_END = 40
"""The same once the crowd and the walks from a place are removed."""


def known_operators() -> list[str]:
    return sorted(name for name in dir(bpy.ops.wayfarer) if name not in LEFT_OUT)


def n_datablocks() -> Counter:
    """Datablocks by their kind; what scenes and windows come with does not count."""
    kinds = ("objects", "meshes", "armatures", "actions", "curves", "materials", "collections", "images", "texts")
    return Counter({kind: len(getattr(bpy.data, kind)) for kind in kinds})


class Artist:
    """Does one random thing at a time; remembers what, for the message of a failure."""

    def __init__(self, seed: int, folder):
        self.random = random.Random(seed)
        self.folder, self.done = folder, []
        self.file = str(folder / "saved again.blend")

    @property
    def settings(self):
        return bpy.context.scene.wayfarer

    def step(self) -> None:
        kinds = {
            self.run: 10,
            self.move: 3,
            self.change_setting: 3,
            self.undo: 2,
            self.redo: 1,
            self.rename: 1,
            self.delete: 0.5,
            self.key: 0.5,
            self.save: 0.5,
            self.reopen: 0.5,
            self.tick: 1,
        }
        [kind] = self.random.choices(list(kinds), list(kinds.values()))
        self.done.append(kind.__name__)
        kind()

    def note(self, what: str) -> None:
        self.done[-1] += f" {what}"

    def run(self) -> None:
        likely = [name for name in LIKELY if name in dir(bpy.ops.wayfarer)]
        name = self.random.choice(likely if self.random.random() < 0.6 else known_operators())
        self.note(name)
        operator = getattr(bpy.ops.wayfarer, name)
        options = {}
        properties = operator.get_rna_type().properties
        if "filepath" in properties:
            options["filepath"] = str(self.folder / f"made by {name}")
        if "directory" in properties:
            options["directory"] = str(self.folder)
        try:
            operator("EXEC_DEFAULT", True, **options)
        except RuntimeError as error:
            text = str(error)
            assert "Traceback" not in text, text
            assert "context is incorrect" not in text, f"{name} does not say why it cannot be used"

    def move(self) -> None:
        objects = [obj for obj in bpy.context.scene.objects if obj.library is None]
        if objects:
            obj = self.random.choice(objects)
            self.note(obj.name)
            obj.location.x += self.random.choice([-0.5, 0.25, 2.0])
            bpy.ops.ed.undo_push(message="Move")

    def change_setting(self) -> None:
        groups = [self.settings.environment, self.settings.graph, self.settings.embedding, self.settings.map]
        group = self.random.choice(groups)
        candidates = [
            p for p in group.bl_rna.properties if p.type in ("FLOAT", "BOOLEAN", "ENUM") and not p.is_readonly
        ]
        candidates = [
            p for p in candidates if not getattr(p, "is_array", False) and not getattr(p, "is_enum_flag", False)
        ]
        wanted = self.random.choice(candidates)
        self.note(wanted.identifier)
        value = getattr(group, wanted.identifier)
        if wanted.type == "BOOLEAN":
            value = not value
        elif wanted.type == "FLOAT":
            # Finer cells than these take more time than there is.
            low = 0.2 if wanted.identifier == "cell_size" else -1e9
            value = max(low, value * self.random.choice([0.5, 0.9, 1.1, 2.0]))
        else:
            items = [item.identifier for item in wanted.enum_items]
            value = self.random.choice(items) if items else value
        setattr(group, wanted.identifier, value)
        bpy.ops.ed.undo_push(message="Setting")

    def undo(self) -> None:
        for _ in range(self.random.randint(1, 3)):
            if bpy.ops.ed.undo.poll():
                bpy.ops.ed.undo()

    def redo(self) -> None:
        if bpy.ops.ed.redo.poll():
            bpy.ops.ed.redo()

    def rename(self) -> None:
        blocks = [
            *bpy.data.objects,
            *(clip.action for clip in self.settings.clips if clip.action),
            *bpy.data.collections,
        ]
        if blocks:
            block = self.random.choice(blocks)
            self.note(block.name)
            block.name = self.random.choice(["Ünïcode 名", "x" * 60, "a.001", "Walk"])
            bpy.ops.ed.undo_push(message="Rename")

    def delete(self) -> None:
        blocks = [obj for obj in bpy.data.objects if obj.type != "ARMATURE" or self.random.random() < 0.1]
        blocks += [clip.action for clip in self.settings.clips if clip.action]
        if blocks:
            block = self.random.choice(blocks)
            self.note(block.name)
            bpy.data.batch_remove([block])
            bpy.ops.ed.undo_push(message="Delete")

    def key(self) -> None:
        """Move a key of a clip."""
        actions = [clip.action for clip in self.settings.clips if clip.action]
        if actions:
            action = self.random.choice(actions)
            self.note(action.name)
            curve = self.random.choice(list(action.layers[0].strips[0].channelbag(action.slots[0]).fcurves))
            curve.keyframe_points[0].co.y += 0.01
            bpy.ops.ed.undo_push(message="Key")

    def tick(self) -> None:
        if self.settings.clips:
            clip = self.random.choice(self.settings.clips[:6])
            clip.use = not clip.use
            bpy.ops.ed.undo_push(message="Tick")

    def save(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=self.file)

    def reopen(self) -> None:
        if os.path.exists(self.file):
            bpy.ops.wm.open_mainfile(filepath=self.file)


def assert_fresh_is_fresh() -> None:
    """What is not called stale is what comes out when everything is computed anew, from scratch."""
    scene = bpy.context.scene
    found = state.results(scene)
    if found.graph is None or state.graph_is_stale(scene):
        return
    graph = finish(build_graph_steps(scene)).graph
    assert graph.links.tolist() == found.graph.links.tolist(), "a stale motion graph is shown as fresh"
    for new, old in zip(graph.segments, found.graph.segments, strict=True):
        # Not to the last bit: where the character stands makes no difference but in rounding.
        np.testing.assert_allclose(new.path, old.path, 1e-6, 1e-6, err_msg="a stale motion graph is shown as fresh")
    if found.embedding is None or state.embedding_is_stale(scene):
        return
    environment = make_environment(scene, read_shapes(scene, bpy.context.evaluated_depsgraph_get()))
    embedding = embed(found.graph, environment, scene.wayfarer.embedding.to_core())
    whole = getattr(found, "whole", found.embedding)
    assert (embedding.n_nodes, embedding.planes) == (whole.n_nodes, whole.planes), "a stale embedding is shown as fresh"


def test_random_steps(sample_settings, sample_file, tmp_path, capfd):
    folder = tmp_path / "Müller & Söhne"
    folder.mkdir()
    reached = Counter()
    for episode in range(max(1, N_STEPS // EPISODE)):
        bpy.ops.wm.open_mainfile(filepath=sample_file)
        settings = bpy.context.scene.wayfarer
        settings.environment.cell_size, settings.environment.n_headings, settings.walk.duration = 0.25, 12, 4.0
        for clip in settings.clips:
            clip.use = clip.action.name.startswith(("walk", "turn_left_90", "turn_right_90"))
        bpy.ops.ed.undo_push(message="Start")
        at_first = n_datablocks()
        artist = Artist(1000 * SEED + episode, folder)
        if episode % 3 != 1:
            for name in ("build_motion_graph", "embed", "paint_map", "random_walk")[: 4 - episode % 3]:
                assert getattr(bpy.ops.wayfarer, name)("EXEC_DEFAULT", True) == {"FINISHED"}
        try:
            for _ in range(EPISODE):
                artist.step()
                more = n_datablocks() - at_first
                assert more.total() <= MARGIN, f"datablocks pile up: {more}"
                if artist.done[-1].split()[0] not in ("run", "save") and artist.random.random() < 0.5:
                    assert_fresh_is_fresh()
                found = state.results(bpy.context.scene)
                reached.update(kind for kind in ("graph", "embedding", "painted", "walk") if getattr(found, kind))
            for name in ("remove_crowd", "clear_walks_from"):
                if getattr(bpy.ops.wayfarer, name).poll():
                    getattr(bpy.ops.wayfarer, name)()
            more = n_datablocks() - at_first
            assert more.total() <= LEFT_AT_THE_END, f"datablocks are left over: {more}"
            printed = "".join(capfd.readouterr())
            assert "Traceback" not in printed, printed[printed.index("Traceback") :]
        except (Exception, MotionGraphError) as error:
            raise AssertionError(f"episode {episode} after {artist.done}: {type(error).__name__}: {error}") from error
    # Or all of this would have tested nothing.
    assert all(reached[kind] >= EPISODE // 5 for kind in ("graph", "embedding", "painted", "walk")), reached


def test_a_stale_embedding_would_be_seen(sample_settings):
    for step in ("build_motion_graph", "embed"):
        getattr(bpy.ops.wayfarer, step)()
    assert_fresh_is_fresh()
    scene = bpy.context.scene
    bpy.data.objects["Table"].location.x += 1
    bpy.context.view_layer.update()
    found = state.results(scene)
    # As if nobody had told of the change.
    found.made_from["embedding"] = (
        found.made_from["embedding"][0],
        read_shapes(scene, bpy.context.evaluated_depsgraph_get()).fingerprint,
    )
    with pytest.raises(AssertionError, match="stale embedding"):
        assert_fresh_is_fresh()
