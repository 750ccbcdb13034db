"""Operators leave the scene as it was when they fail or are undone, and results tell when they no longer fit."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.jobs import LongOperator
from bl_ext.user_default.wayfarer.addon.operators.mixins import Browses
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion.airborne import clearance_mask, jump_mask
from bl_ext.user_default.wayfarer.core.motion.clip import MotionClip
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_repertoire, sample_skeleton
from bl_ext.user_default.wayfarer.core.progress import Progress

from .test_bridge_import_bvh import bvh

operators = bpy.ops.wayfarer
COLLECTIONS = ("objects", "meshes", "armatures", "actions", "collections", "curves", "materials", "scenes", "worlds")
WALKS = ("walk", "turn_left", "turn_right_90", "arc")  # those that are ticked in the sample


def contents() -> dict:
    """Everything in the file that an operator could leave behind, and the settings that it could change."""
    scene = bpy.context.scene
    found = {name: sorted(block.name for block in getattr(bpy.data, name)) for name in COLLECTIONS}
    found["timeline"] = (scene.frame_start, scene.frame_end, len(scene.timeline_markers))
    settings = scene.wayfarer
    found["settings"] = (
        settings.character and settings.character.name,
        [(clip.action.name, clip.use) for clip in settings.clips],
        settings.environment.ground and settings.environment.ground.name,
        len(settings.environment.regions),
    )
    character = settings.character
    animation = character.animation_data if character else None
    found["action"] = animation.action.name if animation and animation.action else None
    return found


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def build(*steps):
    for step in steps:
        assert getattr(operators, step)() == {"FINISHED"}


def fails_and_changes_nothing(operator, **options) -> str:
    before = contents()
    with pytest.raises(RuntimeError) as error:
        operator(**options)
    assert contents() == before
    return str(error.value)


# ------------------------------------------------------------------------------------------------ errors


def test_import_of_nothing_useful(tmp_path):
    assert "no folder" in fails_and_changes_nothing(operators.import_bvh, directory=str(tmp_path / "absent"))
    assert "no BVH files" in fails_and_changes_nothing(operators.import_bvh, directory=str(tmp_path))
    (tmp_path / "broken.bvh").write_text("HIERARCHY\nROOT Hips\n{\n")
    assert "broken.bvh" in fails_and_changes_nothing(operators.import_bvh, directory=str(tmp_path))


def test_nothing_connects(settings):
    settings.graph.max_cost = 0.001
    assert "Raise Max Cost" in fails_and_changes_nothing(operators.build_motion_graph)
    assert store.results(bpy.context.scene).graph is None


def test_an_action_that_moves_nothing_is_not_listed(settings):
    bpy.data.actions.new("Empty")
    operators.refresh_clips()
    assert "Empty" not in [clip.action.name for clip in settings.clips]
    assert [clip.use for clip in settings.clips] == [c.action.name.startswith(WALKS) for c in settings.clips]


def test_a_character_without_clips():
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.scene.wayfarer.character = armature
    assert len(bpy.context.scene.wayfarer.clips) == 0
    assert "tick at least one" in fails_and_changes_nothing(operators.build_motion_graph)


def test_a_scene_that_cannot_be_used(settings):
    build("build_motion_graph")
    environment = settings.environment
    environment.regions[0].tag = " "
    assert "'Step' has no tag" in fails_and_changes_nothing(operators.embed)
    environment.regions[0].tag = "step"
    environment.regions[0].object.location.y = 50
    assert "'Step' covers no part of the ground" in fails_and_changes_nothing(operators.embed)
    environment.regions[0].object.location.y = 0
    environment.cell_size = 20.0
    assert "smaller than one cell" in fails_and_changes_nothing(operators.embed)
    assert store.results(bpy.context.scene).embedding is None


def test_a_walk_from_no_object(settings):
    build("build_motion_graph", "embed")
    settings.walk.start = "ACTIVE_OBJECT"
    bpy.context.view_layer.objects.active = None
    assert "no active object" in fails_and_changes_nothing(operators.random_walk)


def test_a_walk_for_another_rig(settings):
    build("build_motion_graph", "embed")
    armature = bpy.data.armatures.new("Rig")
    other = bpy.data.objects.new("Rig", armature)
    bpy.context.scene.collection.objects.link(other)
    bpy.context.view_layer.objects.active = other
    bpy.ops.object.mode_set(mode="EDIT")
    armature.edit_bones.new("Bone").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    settings.character = other
    assert "no bone called 'Hips'" in fails_and_changes_nothing(operators.random_walk)


# -------------------------------------------------------------------------------------------------- undo


@pytest.mark.parametrize("step", ["add_sample_character", "add_sample_room", "paint_map", "random_walk"])
def test_undone_in_one_step(step, request):
    if step in ("paint_map", "random_walk"):
        request.getfixturevalue("settings")
        build("build_motion_graph", "embed")
    bpy.ops.ed.undo_push(message="before")
    before = contents()
    assert getattr(operators, step)("EXEC_DEFAULT", True) == {"FINISHED"}
    assert contents() != before
    bpy.ops.ed.undo()
    assert contents() == before


def test_results_outlive_undo(settings):
    build("build_motion_graph", "embed")
    bpy.ops.ed.undo_push(message="before")
    operators.paint_map("EXEC_DEFAULT", True)
    embedding = store.results(bpy.context.scene).embedding
    bpy.ops.ed.undo()
    assert store.results(bpy.context.scene).embedding is embedding
    assert not staleness.embedding_is_stale(bpy.context.scene)
    build("paint_map", "random_walk")


# ------------------------------------------------------------------------------------------------- stale


def stale() -> tuple[bool, bool, bool, bool]:
    """Of graph, embedding, map and walk."""
    scene = bpy.context.scene
    return (
        staleness.graph_is_stale(scene),
        staleness.embedding_is_stale(scene),
        staleness.map_is_stale(scene),
        staleness.walk_is_stale(scene),
    )


def first_curve(action):
    return action.layers[0].strips[0].channelbag(action.slots[0]).fcurves[0]


def test_what_a_change_makes_stale(settings):
    assert stale() == (False, False, False, False)
    build("build_motion_graph", "embed", "paint_map", "random_walk")
    fresh, all_stale, from_embedding = (False,) * 4, (True,) * 4, (False, True, True, True)
    assert stale() == fresh

    def check(change, restore, expected):
        change()
        assert stale() == expected
        restore()
        assert stale() == fresh

    graph, environment = settings.graph, settings.environment
    cost = graph.max_cost
    check(lambda: setattr(graph, "max_cost", 0.2), lambda: setattr(graph, "max_cost", cost), all_stale)
    used = next(clip for clip in settings.clips if clip.use)
    check(lambda: setattr(used, "use", False), lambda: setattr(used, "use", True), all_stale)
    key = first_curve(used.action).keyframe_points[3]
    value = key.co.y
    check(lambda: setattr(key.co, "y", value + 0.1), lambda: setattr(key.co, "y", value), all_stale)
    unused = next(clip for clip in settings.clips if not clip.use)
    key_of_unused = first_curve(unused.action).keyframe_points[3]
    key_of_unused.co.y += 0.1
    assert stale() == fresh

    table = bpy.data.objects["Table"]
    x = table.location.x
    check(lambda: setattr(table.location, "x", 0.0), lambda: setattr(table.location, "x", x), from_embedding)
    vertex = table.data.vertices[0]
    place = vertex.co.copy()

    def move_vertex(to):
        vertex.co = to
        table.data.update()

    check(lambda: move_vertex((0, 0, 0)), lambda: move_vertex(place), from_embedding)
    check(lambda: setattr(environment, "radius", 0.3), lambda: setattr(environment, "radius", 0.25), from_embedding)
    region = environment.regions[0]
    check(lambda: setattr(region, "margin", 0.1), lambda: setattr(region, "margin", 0.3), from_embedding)
    ground = environment.ground
    check(lambda: setattr(environment, "ground", None), lambda: setattr(environment, "ground", ground), from_embedding)
    # What the character plays, and where it stands on the timeline, has nothing to do with it.
    bpy.context.scene.frame_set(7)
    assert stale() == fresh
    settings.map.quantity = "COVERAGE"
    assert stale() == (False, False, True, False)
    build("embed")
    assert stale() == (False, False, True, True)
    build("build_motion_graph")
    assert stale() == (False, True, True, True)


def test_scenes_have_results_of_their_own(settings):
    build("build_motion_graph")
    first = bpy.context.scene
    second = bpy.data.scenes.new("Second")
    assert store.results(first).graph is not None
    assert store.results(second).graph is None


# -------------------------------------------------------------------------------------------------- jobs


class Window:
    """Stands for what a modal operator is given: nothing here has a window."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda *arguments, **options: self.calls.append(name)


class Event:
    def __init__(self, kind, value="PRESS"):
        self.type, self.value = kind, value


class Job(LongOperator):
    bl_label = "Job"

    def __init__(self, error=None):
        self.reports, self.applied, self.error, self.closed = [], [], error, False

    def steps(self, context):
        try:
            for k in range(3):
                yield Progress(k / 3, "Working")
            if self.error:
                raise self.error
            return 42
        finally:
            self.closed = True

    def apply(self, context, result):
        self.applied.append(result)

    def report(self, kind, text):
        self.reports.append((*kind, text))


class Context:
    def __init__(self):
        self.window_manager, self.workspace, self.window = Window(), Window(), object()
        self.screen = type("Screen", (), {"areas": ()})()


def started(job, monkeypatch):
    # The only way to the modal half without a window.
    monkeypatch.setattr("bl_ext.user_default.wayfarer.addon.jobs.bpy.app", type("App", (), {"background": False}))
    context = Context()
    assert job.invoke(context, None) == {"RUNNING_MODAL"}
    return context


def test_a_modal_job_runs_to_its_end(monkeypatch):
    job = Job()
    context = started(job, monkeypatch)
    assert job.modal(context, Event("MOUSEMOVE")) == {"RUNNING_MODAL"}
    assert job.applied == []
    assert job.modal(context, Event("TIMER")) == {"FINISHED"}
    assert job.applied == [42]
    assert context.window_manager.calls[-2:] == ["event_timer_remove", "progress_end"]


def test_what_a_file_browser_chose_begins_as_work_of_its_own(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.bvh").write_text(bvh())

    class WAYFARER_OT_import_bvh(Browses):
        directory, files = "", ()

        def as_keywords(self, ignore):
            return {"directory": self.directory, "jump_tag": "", "use_body": False}

    chosen = []
    window_manager = type("Manager", (), {"fileselect_add": staticmethod(chosen.append)})
    operator = WAYFARER_OT_import_bvh()
    assert operator.invoke(type("Asked", (), {"window_manager": window_manager}), None) == {"RUNNING_MODAL"}
    assert chosen == [operator] and not bpy.data.actions
    operator.directory, operator.files = str(tmp_path), [type("File", (), {"name": "b.bvh"})]
    assert operator.execute(bpy.context) == {"CANCELLED"}
    assert [action.name for action in bpy.data.actions] == ["b"]


def test_escape_cancels_without_applying(monkeypatch):
    job = Job()
    context = started(job, monkeypatch)
    assert not job._work.advance(0.0)
    assert job.modal(context, Event("ESC")) == {"CANCELLED"}
    assert job.applied == [] and job.closed
    assert context.window_manager.calls[-2:] == ["event_timer_remove", "progress_end"]


def test_blender_may_cancel_a_job_that_has_not_begun():
    """As it does when a file browser is closed."""
    job, context = Job(), Context()
    job.cancel(context)
    assert context.window_manager.calls == [] and job.applied == []


def test_a_modal_job_reports_errors(monkeypatch):
    job = Job(ClipError("Clip 'walk' is too short."))
    context = started(job, monkeypatch)
    assert job.modal(context, Event("TIMER")) == {"CANCELLED"}
    assert job.reports == [("ERROR", "Clip 'walk' is too short.")]
    assert context.window_manager.calls[-2:] == ["event_timer_remove", "progress_end"]


def test_a_bug_in_a_modal_job_does_not_leave_its_timer(monkeypatch):
    job = Job(ZeroDivisionError())
    context = started(job, monkeypatch)
    with pytest.raises(ZeroDivisionError):
        job.modal(context, Event("TIMER"))
    assert context.window_manager.calls[-2:] == ["event_timer_remove", "progress_end"]


# ------------------------------------------------------------------------------------------------- jumps


def lifted_clip(lift: np.ndarray) -> MotionClip:
    """The sample character in its rest pose, lifted by ``lift`` (F,) metres."""
    skeleton = sample_skeleton()
    n_frames = len(lift)
    translations = np.tile(skeleton.rest_translations, (n_frames, 1, 1))
    translations[:, 0, 2] += lift
    return MotionClip("jump", skeleton, 10.0, np.tile(skeleton.rest_rotations, (n_frames, 1, 1)), translations)


def test_jumps_are_found_from_take_off_to_landing():
    hop = [0, 0, 0, 0.05, 0.1, 0.05, 0, 0, 0]
    jump = [0, 0, 0.1, 0.3, 0.4, 0.3, 0.1, 0, 0, 0]
    mask = jump_mask(lifted_clip(np.array(hop + jump)), height=0.25, lift=0.03, lead=0.1)
    assert np.flatnonzero(mask).tolist() == [10, 11, 12, 13, 14, 15, 16]
    clip = lifted_clip(np.array(jump))
    feet = ((clip.skeleton.index("LeftFoot"),), (clip.skeleton.index("RightFoot"),))
    assert np.flatnonzero(clearance_mask(clip, feet, 0.35)).tolist() == [4]


def test_walking_is_no_jumping():
    for clip in sample_repertoire()[:3]:
        assert not jump_mask(clip, height=0.1).any()
