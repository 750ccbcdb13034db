"""What artists bring by mistake, through the operators: one clear sentence, and a scene that is as it was."""

import contextlib
import os
import random

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.cli.scene import apply_override
from bl_ext.user_default.wayfarer.addon.results import clips, staleness, store
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion.graph_settings import HIGHEST_RATE
from bl_ext.user_default.wayfarer.core.progress import Progress, finish

from .test_bridge_import_bvh import DAMAGED, bvh, datablocks, found_unit
from .test_operators import Event, Job, build, contents, fails_and_changes_nothing, started

operators = bpy.ops.wayfarer
EFFORT = int(os.environ.get("WAYFARER_FUZZ", "1"))


@pytest.fixture
def settings(sample_settings):
    return sample_settings


@pytest.fixture
def embedded(settings):
    build("build_motion_graph")
    return settings


def curves_of(action):
    return action.layers[0].strips[0].channelbag(action.slots[0]).fcurves


def used_actions(settings):
    return [clip.action for clip in settings.clips if clip.use]


def keep_only(settings, *actions):
    for clip in settings.clips:
        clip.use = clip.action in actions


def new_mesh_object(name, points=(), faces=()):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    return bpy.data.objects.new(name, mesh)


# ----------------------------------------------------------------------------------------------- characters


def test_no_character(settings):
    settings.character = None
    assert "Choose a character" in fails_and_changes_nothing(operators.build_motion_graph)


def test_a_character_that_was_deleted(settings):
    bpy.data.objects.remove(settings.character)
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    assert "haracter" in sentence and "Traceback" not in sentence


def test_no_actions(settings):
    bpy.data.batch_remove(list(bpy.data.actions))
    with pytest.raises(RuntimeError, match="tick at least one"):
        operators.build_motion_graph()
    operators.refresh_clips()
    assert "tick at least one" in fails_and_changes_nothing(operators.build_motion_graph)


def test_an_action_of_one_frame(settings):
    action = used_actions(settings)[0]
    for curve in curves_of(action):
        while len(curve.keyframe_points) > 1:
            curve.keyframe_points.remove(curve.keyframe_points[-1], fast=True)
    keep_only(settings, action)
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    assert f"'{action.name}'" in sentence and "two frames" in sentence


def test_not_a_number_in_a_curve(settings):
    action = used_actions(settings)[0]
    curves_of(action)[0].keyframe_points[5].co.y = float("nan")
    curves_of(action)[0].update()
    keep_only(settings, action)
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    assert f"'{action.name}'" in sentence and "not a number" in sentence


def test_one_bad_clip_does_not_spoil_the_others(settings):
    bad = used_actions(settings)[0]
    curves_of(bad)[0].keyframe_points[5].co.y = float("nan")
    build("build_motion_graph")
    graph = store.results(bpy.context.scene).graph
    assert bad.name not in {clip.name for clip in graph.clips} and len(graph.clips) > 1


def test_missing_bones(settings):
    """The action moves bones that this rig does not have."""
    action = used_actions(settings)[0]
    armature = bpy.data.armatures.new("Other")
    other = bpy.data.objects.new("Other", armature)
    bpy.context.scene.collection.objects.link(other)
    bpy.context.view_layer.objects.active = other
    bpy.ops.object.mode_set(mode="EDIT")
    armature.edit_bones.new("Tentacle").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    settings.character = other
    settings.clips.clear()
    clip = settings.clips.add()
    clip.action = action
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    assert f"'{action.name}'" in sentence and "'Other'" in sentence


@pytest.mark.parametrize("frame", [200_000, 1_000_000])
def test_a_stray_key_far_away(settings, frame):
    action = used_actions(settings)[0]
    curves_of(action)[0].keyframe_points.insert(frame, 0.0)
    keep_only(settings, action)
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    assert f"'{action.name}' goes from frame" in sentence and f"{frame:,}" in sentence
    assert "manual frame range" in sentence
    operators.examine_clips()
    assert f"{frame:,}" in clips.health_of(bpy.context.scene, action).problem
    action.use_frame_range, action.frame_start, action.frame_end = True, *action.frame_range[:1], 90
    build("build_motion_graph")


def test_a_frame_rate_beyond_all_sense(settings):
    assert "from 5 to 1000" in apply_override(bpy.context.scene.wayfarer, "graph.frame_rate=1e9")
    settings.graph.frame_rate = 1e9
    assert settings.graph.frame_rate == settings.graph.to_core().frame_rate == HIGHEST_RATE


class Greedy(Job):
    """Asks for more memory than any computer has, at work or when it keeps what came of it."""

    def __init__(self, where):
        super().__init__()
        self.where = where

    def steps(self, context):
        yield Progress(0.0, "Working")
        return self.ask("steps")

    def apply(self, context, result):
        self.ask("apply")

    def ask(self, where):
        return np.ones(1 << 50) if where == self.where else 42


@pytest.mark.parametrize("where", ["steps", "apply"])
def test_a_job_that_needs_more_memory_than_there_is(where, monkeypatch):
    at_once, modal = Greedy(where), Greedy(where)
    assert at_once.execute(bpy.context) == {"CANCELLED"}
    context = started(modal, monkeypatch)
    assert modal.modal(context, Event("TIMER")) == {"CANCELLED"}
    assert context.window_manager.calls[-2:] == ["event_timer_remove", "progress_end"]
    for job in (at_once, modal):
        ((kind, sentence),) = job.reports
        assert kind == "ERROR" and sentence.startswith("Job needs more memory than there is. ")


@pytest.mark.parametrize("scale", [(1, 1, 2), (-1, 1, 1), (0, 0, 0)])
def test_scales_that_are_refused(settings, scale):
    settings.character.scale = scale
    bpy.context.view_layer.update()
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    assert "cale" in sentence and f"'{settings.character.name}'" in sentence


def test_a_turned_and_evenly_scaled_character_is_fine(settings):
    settings.character.rotation_euler = (0, 0, 1.3)
    settings.character.location = (3, -2, 0)
    settings.character.scale = (1.1, 1.1, 1.1)
    bpy.context.view_layer.update()
    build("build_motion_graph", "embed")
    assert store.results(bpy.context.scene).embedding.n_nodes > 0


def test_clips_without_root_motion_are_told(settings):
    action = used_actions(settings)[0]
    for curve in [curve for curve in curves_of(action) if curve.data_path.endswith('"Hips"].location')]:
        curves_of(action).remove(curve)
    keep_only(settings, action)
    before = contents()
    assert operators.examine_clips() == {"FINISHED"}
    assert contents() == before
    health = clips.health_of(bpy.context.scene, action)
    assert health is not None and health.findings


@pytest.mark.parametrize("what", ["ground", "region"])
def test_a_ground_or_region_that_goes_with_the_character(embedded, what):
    """It would be elsewhere after every walk, and all that was made from it out of date."""
    body = next(obj for obj in embedded.character.children if obj.type == "MESH")
    badge = new_mesh_object("Badge", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    bpy.context.scene.collection.objects.link(badge)
    badge.parent = body
    bpy.context.view_layer.update()
    environment = embedded.environment
    for obj in (body, badge, embedded.character):
        if what == "ground":
            environment.ground_source, environment.ground = "OBJECT", obj
        else:
            environment.regions[0].object = obj
        said = fails_and_changes_nothing(operators.embed)
        assert f"The {what} '{obj.name}' is part of the character" in said and "choose another object" in said
    badge.parent = None
    if what == "ground":
        environment.ground_source = "TYPED"
    else:
        environment.regions[0].object = badge
    build("embed")
    # A ground that is not asked for may be anything.
    assert not staleness.embedding_is_stale(bpy.context.scene)


def test_what_we_draw_is_neither_obstacle_nor_ground_nor_region(embedded):
    build("embed", "paint_map", "walks_from")
    scene, environment = bpy.context.scene, embedded.environment
    nodes, floor = store.results(scene).embedding.n_nodes, bpy.data.objects["Wayfarer Floor"]
    # With the obstacles, our own things are in one collection.
    for obj in list(environment.obstacles.all_objects):
        floor.users_collection[0].objects.link(obj)
    environment.obstacles = floor.users_collection[0]
    build("embed", "paint_map")
    assert store.results(scene).embedding.n_nodes == nodes and not staleness.map_is_stale(scene)
    environment.regions[0].object = floor
    assert "The region 'Wayfarer Floor' is what Wayfarer draws" in fails_and_changes_nothing(operators.embed)
    environment.regions.clear()
    environment.ground_source, environment.ground = "OBJECT", floor
    assert "The ground 'Wayfarer Floor' is what Wayfarer draws" in fails_and_changes_nothing(operators.embed)


def test_bones_of_no_length():
    """Blender removes such bones when it leaves edit mode; as short as can be, they are read like any other."""
    armature = bpy.data.armatures.new("Short")
    rig = bpy.data.objects.new("Short", armature)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    root = armature.edit_bones.new("Hips")
    root.head, root.tail = (0, 0, 1), (0, 0, 1.1)
    child = armature.edit_bones.new("Dot")
    child.parent, child.head, child.tail = root, (0, 0, 1.1), (0, 0, 1.1 + 1e-5)
    gone = armature.edit_bones.new("Gone")
    gone.head = gone.tail = (0, 0, 2)
    bpy.ops.object.mode_set(mode="OBJECT")
    action = bpy.data.actions.new("Hop")
    rig.animation_data_create().action = action
    for bone in ("Hips", "Dot"):
        curve = action.fcurve_ensure_for_datablock(rig, f'pose.bones["{bone}"].location', index=2)
        for frame in range(1, 90):
            curve.keyframe_points.insert(frame, np.sin(frame / 5.0))
    bpy.context.scene.wayfarer.character = rig
    sentence = fails_and_changes_nothing(operators.build_motion_graph)
    # A character of two bones has no feet: that is what is wrong with it.
    assert "foot" in sentence or "feet" in sentence


def test_names_that_differ_in_their_number_only(settings):
    action = used_actions(settings)[0]
    copy = action.copy()
    copy.name = action.name
    operators.refresh_clips()
    assert copy.name != action.name
    build("build_motion_graph")
    names = [clip.name for clip in store.results(bpy.context.scene).graph.clips]
    assert len(set(names)) == len(names)


# ---------------------------------------------------------------------------------------------------- scenes


def test_an_empty_mesh_as_ground(embedded):
    nothing = new_mesh_object("Nothing")
    bpy.context.scene.collection.objects.link(nothing)
    embedded.environment.ground = nothing
    assert "round" in fails_and_changes_nothing(operators.embed)


def test_a_camera_as_ground(embedded):
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    embedded.environment.ground = camera
    if embedded.environment.ground is not None:
        assert "round" in fails_and_changes_nothing(operators.embed)


def test_an_empty_mesh_among_the_obstacles_is_none(embedded):
    build("embed")
    before = store.results(bpy.context.scene).embedding.n_nodes
    embedded.environment.obstacles.objects.link(new_mesh_object("Nothing"))
    embedded.environment.obstacles.objects.link(new_mesh_object("Line", [(0, 0, 1), (0, 0, 1), (0, 0, 1)], [(0, 1, 2)]))
    build("embed")
    assert store.results(bpy.context.scene).embedding.n_nodes <= before


def test_a_ground_that_needs_too_much_memory(embedded):
    environment = embedded.environment
    environment.ground_source = "TYPED"
    environment.ground_low, environment.ground_high = (-3000, -3000), (3000, 3000)
    environment.cell_size = 0.05
    sentence = fails_and_changes_nothing(operators.embed)
    assert "GB" in sentence and ("larger Cell Size" in sentence or "smaller ground" in sentence)
    environment.ground_low, environment.ground_high = (-50, -50), (50, 50)
    environment.cell_size, environment.n_headings = 0.1, 360
    sentence = fails_and_changes_nothing(operators.embed)
    assert "GB" in sentence and "limit" in sentence


def test_an_obstacle_that_is_not_a_number(embedded):
    table = bpy.data.objects["Table"]
    table.data.vertices[0].co.x = float("nan")
    assert "'Table'" in fails_and_changes_nothing(operators.embed)


def test_an_obstacle_at_the_end_of_the_world(embedded):
    bpy.data.objects["Table"].scale.x = 1e9
    bpy.context.view_layer.update()
    assert "km" in fails_and_changes_nothing(operators.embed)


@pytest.mark.parametrize("name", ["Table", "Ground", "Step"])
def test_objects_deleted_while_referenced(embedded, name):
    build("embed")
    obj = bpy.data.objects.get(name) or embedded.environment.ground
    bpy.data.objects.remove(obj)
    assert staleness.embedding_is_stale(bpy.context.scene)
    # What is left is a scene like any other.
    with contextlib.suppress(RuntimeError):
        operators.embed()
    staleness.embedding_changes(bpy.context.scene)


def test_obstacles_linked_from_a_library(embedded, tmp_path):
    build("embed")
    own = store.results(bpy.context.scene).embedding
    library = str(tmp_path / "Bücherei mit Leerzeichen.blend")
    obstacles = embedded.environment.obstacles
    bpy.data.libraries.write(library, {obstacles}, fake_user=True)
    name = obstacles.name
    for obj in list(obstacles.all_objects):
        bpy.data.objects.remove(obj)
    bpy.data.collections.remove(obstacles)
    with bpy.data.libraries.load(library, link=True) as (_, linked):
        linked.collections = [name]
    bpy.context.scene.collection.children.link(linked.collections[0])
    embedded.environment.obstacles = linked.collections[0]
    build("embed")
    assert store.results(bpy.context.scene).embedding.planes == own.planes
    build("paint_map", "random_walk")


def test_two_million_triangles(embedded):
    """A dense terrain that is low enough to walk on, and its peak, which is not."""
    side = 1001
    x, y = np.meshgrid(np.linspace(-3.5, 3.5, side), np.linspace(-4, 4, side), indexing="ij")
    z = 0.01 * np.sin(5 * x) + 1.5 * (np.hypot(x - 2, y + 2) < 0.4)
    mesh = bpy.data.meshes.new("Terrain")
    corners = np.arange(side * side).reshape(side, side)
    quads = np.stack([corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=-1).reshape(-1, 4)
    mesh.vertices.add(side * side)
    mesh.vertices.foreach_set("co", np.stack([x, y, z], axis=-1).astype(np.float32).ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.astype(np.int32).ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    terrain = bpy.data.objects.new("Terrain", mesh)
    embedded.environment.obstacles.objects.link(terrain)
    assert 2 * len(quads) == 2_000_000
    build("embed")
    embedding = store.results(bpy.context.scene).embedding
    grid, free = embedding.environment.grid, embedding.environment.free_cells()
    peak = tuple(grid.cells(np.array([2.0, -2.0])))
    assert not free[peak] and free.mean() > 0.3


# ------------------------------------------------------------------------------------------------ BVH files


def damaged(text: str, chance: random.Random) -> str:
    """A BVH file with something done to it that disks, editors and other programs do."""
    lines = text.splitlines(keepends=True)
    for _ in range(chance.randint(1, 3)):
        place = chance.randrange(len(lines))
        words = lines[place].split(" ")
        word = chance.randrange(len(words))
        strange = [
            "nan",
            "inf",
            "-1e39",
            "1e400",
            "{",
            "}",
            "",
            "\x00",
            "ROOT",
            "JOINT",
            "MOTION",
            "CHANNELS",
            "-5",
            "999999",
        ]
        kind = chance.randrange(6)
        if kind == 0:
            words[word] = chance.choice(strange)
            lines[place] = " ".join(words)
        elif kind == 1:
            del lines[place]
        elif kind == 2:
            lines.insert(place, lines[chance.randrange(len(lines))])
        elif kind == 3:
            lines = lines[: max(place, 1)]
        elif kind == 4:
            lines[place] = lines[place].upper() if chance.random() < 0.5 else lines[place].strip()
        else:
            other = chance.randrange(len(lines))
            lines[place], lines[other] = lines[other], lines[place]
        if not lines:
            break
    return "".join(lines)


def test_damaged_bvh_files_are_imported_or_refused(tmp_path, capfd):
    chance, whole, n_refused = random.Random(1), bvh(6), 0
    path = tmp_path / "dämaged.bvh"
    for attempt in range(80 * EFFORT):
        path.write_text(damaged(whole, chance), "utf-8")
        with contextlib.suppress(ClipError):
            assert found_unit(path) > 0, f"attempt {attempt}"
        before = datablocks()
        sentence = ""
        try:
            operators.import_bvh(directory=str(tmp_path), use_body=False)
        except RuntimeError as error:
            sentence = str(error)
        if sentence:
            n_refused += 1
            assert "Traceback" not in sentence and path.name in sentence, f"attempt {attempt}: {sentence}"
            assert datablocks() == before, f"attempt {attempt}"
        else:
            bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert 10 < n_refused < 80 * EFFORT
    assert "Traceback" not in "".join(capfd.readouterr())


def selected_cube():
    """Selected and active, beside one that is neither."""
    other, cube = new_mesh_object("Other"), new_mesh_object("Cube")
    for obj in (other, cube):
        bpy.context.scene.collection.objects.link(obj)
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    return cube


@pytest.mark.parametrize("jump_tag", ["step", ""])
@pytest.mark.parametrize("frame_time", [33.3333, 1000, 1e-9])
def test_one_frame_time_that_cannot_be_leaves_out_its_file_only(tmp_path, capfd, frame_time, jump_tag):
    for name, time in (("a", 0.0333333), ("b", frame_time), ("c", 0.0333333)):
        (tmp_path / f"{name}.bvh").write_text(bvh(frame_time=time))
    assert operators.import_bvh(directory=str(tmp_path), jump_tag=jump_tag) == {"FINISHED"}
    assert "Left out 'b.bvh': The frames in 'b.bvh' last" in capfd.readouterr().out
    assert [clip.action.name for clip in bpy.context.scene.wayfarer.clips] == ["a", "c"]
    assert [action["wayfarer_frame_rate"] for action in bpy.data.actions] == [30, 30]


def test_what_was_selected_is_so_after_an_import_that_fails(tmp_path):
    cube = selected_cube()
    (tmp_path / "b.bvh").write_text(bvh(frame_time=33.3333))
    sentence = fails_and_changes_nothing(operators.import_bvh, directory=str(tmp_path))
    assert "The frames in 'b.bvh' last 33.3333 seconds each" in sentence
    assert bpy.context.view_layer.objects.active == cube and list(bpy.context.selected_objects) == [cube]
    # One that Blender imports, and selects.
    (tmp_path / "b.bvh").write_text(DAMAGED["beyond single precision"])
    assert "not a number" in fails_and_changes_nothing(operators.import_bvh, directory=str(tmp_path))
    assert bpy.context.view_layer.objects.active == cube and list(bpy.context.selected_objects) == [cube]


@pytest.mark.parametrize("late", [False, True], ids=["cancelled", "character deleted"])
def test_an_import_that_stops_after_its_files(tmp_path, late):
    """While it looks at the motion, or when the scene is changed: nothing stays, and the selection comes back."""
    cube, operator = selected_cube(), bpy.types.WAYFARER_OT_import_bvh

    class Import:
        directory, files, scale, up_axis = str(tmp_path), (), 0.0, "AUTO"
        jump_tag, jump_height, use_body = "step", 0.25, True
        steps, apply, _look_steps, _add = operator.steps, operator.apply, operator._look_steps, operator._add
        suffixes, all_of, character, _settle = operator.suffixes, operator.all_of, operator.character, operator._settle

    for name in ("a", "b"):
        (tmp_path / f"{name}.bvh").write_text(bvh())
    before, job = contents(), Import()
    work = job.steps(bpy.context)
    if late:
        result = finish(work)
        bpy.data.objects.remove(next(obj for obj in bpy.data.objects if obj.type == "ARMATURE"))
        with pytest.raises(StopIteration):
            job.apply(bpy.context, result)
    else:
        while next(work).message != "Looking at the motion":
            pass
        assert len(bpy.data.actions) == 2
        work.close()
    assert contents() == before and datablocks() == {"objects": 2, "armatures": 0, "actions": 0, "meshes": 2}
    assert bpy.context.view_layer.objects.active == cube and list(bpy.context.selected_objects) == [cube]


def test_a_chosen_bvh_file_that_is_not_there(tmp_path):
    cube = selected_cube()
    for name in ("a", "b"):
        (tmp_path / f"{name}.bvh").write_text(bvh())
    (tmp_path / "folder.bvh").mkdir()
    for names in (["typo.bvh"], ["a.bvh", "typo.bvh"], ["folder.bvh"]):
        sentence = fails_and_changes_nothing(
            operators.import_bvh, directory=str(tmp_path), files=[{"name": name} for name in names]
        )
        assert f"There is no file '{names[-1]}'" in sentence
    assert bpy.context.view_layer.objects.active == cube and list(bpy.context.selected_objects) == [cube]
    # What the file browser gives where nothing is selected: an empty name, or that of the .blend file.
    (tmp_path / "folder.bvh").rmdir()
    for name in ("", "scene.blend"):
        assert operators.import_bvh(directory=str(tmp_path), files=[{"name": name}]) == {"FINISHED"}
        assert len(bpy.data.actions) == 2
        bpy.data.batch_remove(list(bpy.data.actions))
