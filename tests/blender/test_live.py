"""Live evaluation: the map follows the scene, without a step of undo and without reading what did not change."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.read_scene import ShapeMemory, read_triangles
from bl_ext.user_default.wayfarer.addon.bridge.write_colors import ATTRIBUTE
from bl_ext.user_default.wayfarer.addon.live import live
from bl_ext.user_default.wayfarer.addon.live.evaluation import LiveEvaluation
from bl_ext.user_default.wayfarer.addon.render.floor import find_floor, floor_legend
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.addon.scene import changes as scene_changes
from bl_ext.user_default.wayfarer.addon.scene.inputs import make_environment, read_shapes
from bl_ext.user_default.wayfarer.addon.session import SESSION, Listener
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.evaluation.variability import floor_variability

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    for step in ("build_motion_graph", "embed", "paint_map"):
        assert getattr(operators, step)() == {"FINISHED"}
    return sample_settings


def results():
    return store.results(bpy.context.scene)


def painted() -> np.ndarray:
    floor = find_floor(bpy.context.scene)
    colors = np.empty(4 * len(floor.data.vertices), dtype=np.float32)
    floor.data.color_attributes[ATTRIBUTE].data.foreach_get("color", colors)
    return colors


def run(evaluation: LiveEvaluation, budget=10.0, **options) -> int:
    """Step until the map is there; returns how many steps it took."""
    for n_steps in range(1, 10_000):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if evaluation.step(bpy.context.scene, depsgraph, budget, **options):
            return n_steps
    raise AssertionError("It never ends.")


def move(name="Table", x=0.6):
    bpy.data.objects[name].location.x += x
    bpy.context.view_layer.update()


def anew():
    """What the operators make of the scene as it is: nodes and colours of the floor."""
    found = results()
    embedding = embed(found.graph, found.embedding.environment, found.embedding.settings)
    operators.paint_map()
    return embedding.planes, painted()


# ---------------------------------------------------------------------------------------------- following


@pytest.mark.parametrize("budget", [10.0, 0.0])
def test_the_map_follows_an_obstacle(settings, budget):
    before, colors, evaluation = results().embedding, painted(), LiveEvaluation()
    run(evaluation)
    assert results().embedding is before and not evaluation.seconds, "nothing has changed"
    move()
    assert staleness.map_is_stale(bpy.context.scene)
    evaluation.change()
    n_steps = run(evaluation, budget)
    assert (n_steps > 10) == (budget == 0.0)
    found = results()
    assert found.embedding is not before and not staleness.map_is_stale(bpy.context.scene)
    assert not np.array_equal(painted(), colors)
    assert set(evaluation.seconds) == {"read", "environment", "embed", "map", "paint", "count"}
    assert found.summary.nodes == found.embedding.n_nodes and found.summary.links == found.embedding.n_links
    assert found.painted.numbers["map_highest"] == floor_variability(found.embedding).max()
    followed = painted()
    planes, expected = anew()
    assert found.embedding.planes == planes
    np.testing.assert_array_equal(followed, expected)
    # The obstacle goes back to where it was, and so does the map.
    move(x=-0.6)
    evaluation.change()
    run(evaluation)
    assert results().embedding.planes == before.planes
    np.testing.assert_array_equal(painted(), colors)


def test_the_map_follows_settings(settings):
    evaluation = LiveEvaluation()
    run(evaluation)
    scene = bpy.context.scene
    assert not evaluation.notice_settings(scene)
    settings.environment.radius += 0.05
    assert evaluation.notice_settings(scene) and not evaluation.notice_settings(scene)
    nodes = results().embedding.n_nodes
    evaluation.change()
    run(evaluation)
    assert results().embedding.n_nodes < nodes
    embedding = results().embedding
    settings.map.quantity = "WHY_NOT"
    assert evaluation.notice_settings(scene)
    evaluation.change()
    run(evaluation)
    assert results().embedding is embedding and floor_legend(find_floor(scene)).title == "Why Not"
    assert "embed" not in evaluation.seconds and not staleness.map_is_stale(scene)
    settings.embedding.position_rate *= 0.5
    evaluation.change()
    run(evaluation)
    assert results().embedding.settings == settings.embedding.to_core()


def test_without_live_only_the_map_follows_its_settings(settings):
    embedding, evaluation = results().embedding, LiveEvaluation()
    move()
    settings.map.use_heading = True
    evaluation.change()
    run(evaluation, map_only=True)
    assert results().embedding is embedding and staleness.embedding_is_stale(bpy.context.scene)
    assert "Heading" in floor_legend(find_floor(bpy.context.scene)).title
    evaluation.change()
    run(evaluation)
    assert results().embedding is not embedding


def test_changes_during_the_work_start_it_again(settings):
    evaluation, scene = LiveEvaluation(), bpy.context.scene
    move()
    while not (evaluation.working and "embed" in evaluation._spent):
        assert not evaluation.step(scene, bpy.context.evaluated_depsgraph_get(), 0.0)
    before = results().embedding
    move()
    evaluation.change()
    assert not evaluation.working and results().embedding is before
    run(evaluation)
    followed = painted()
    planes, expected = anew()
    assert results().embedding.planes == planes
    np.testing.assert_array_equal(followed, expected)
    assert not staleness.embedding_is_stale(scene)


def test_a_round_may_come_to_its_end_before_the_next(settings):
    evaluation, scene = LiveEvaluation(), bpy.context.scene
    move()
    while not evaluation.working:
        evaluation.step(scene, bpy.context.evaluated_depsgraph_get(), 0.0)
    move(x=-0.3)
    evaluation.change(restart=False)
    shown = []
    while not evaluation.step(scene, bpy.context.evaluated_depsgraph_get(), 0.0):
        if not shown or results().embedding is not shown[-1]:
            shown.append(results().embedding)
    assert len(shown) >= 2, "both the first place and the second were shown"
    assert not staleness.embedding_is_stale(scene)


def test_settings_that_change_unnoticed_start_it_again(settings):
    evaluation, scene = LiveEvaluation(), bpy.context.scene
    move()
    while not evaluation.working:
        evaluation.step(scene, bpy.context.evaluated_depsgraph_get(), 0.0)
    settings.environment.radius += 0.05
    run(evaluation)
    assert not staleness.map_is_stale(scene)


# ----------------------------------------------------------------------------- before Blender draws


@pytest.fixture
def before_drawing():
    """Calls the live evaluation as Blender does in a window, and keeps what it answers: whether it painted."""
    answers = []

    def handler(scene, depsgraph):
        live.evaluation(scene).change()
        answers.append(live.follow(scene, depsgraph))

    bpy.app.handlers.depsgraph_update_post.append(handler)
    yield answers
    bpy.app.handlers.depsgraph_update_post.remove(handler)


def ready() -> LiveEvaluation:
    """The scene's live evaluation, which has worked before, and fast."""
    evaluation = live.evaluation(bpy.context.scene)
    move(x=0.01)
    evaluation.change()
    run(evaluation)
    evaluation._latencies.extend([0.01] * 3)
    return evaluation


def test_the_map_is_in_the_same_evaluation_as_the_change(settings, before_drawing, monkeypatch):
    monkeypatch.setattr(live, "FOLLOWS", 60.0)
    evaluation, scene = ready(), bpy.context.scene
    before_drawing.clear()
    colors = painted()
    for x in (0.6, -0.3):
        move(x=x)
        # Once: what was painted was evaluated without another call.
        assert before_drawing == [True]
        before_drawing.clear()
        assert evaluation.painted and not staleness.map_is_stale(scene) and not np.array_equal(painted(), colors)
        colors = painted()
        shown = find_floor(scene).evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        evaluated = np.empty_like(colors)
        shown.color_attributes[ATTRIBUTE].data.foreach_get("color", evaluated)
        np.testing.assert_array_equal(evaluated, colors)
        assert before_drawing == []
    # What the panel tells comes later.
    assert not evaluation.done and scene is not None
    nodes = results().summary.nodes
    run(evaluation)
    assert results().summary.nodes == results().embedding.n_nodes != nodes
    planes, expected = anew()
    assert results().embedding.planes == planes
    np.testing.assert_array_equal(colors, expected)


def test_what_does_not_come_in_time_is_left_to_the_timer(settings, before_drawing, monkeypatch):
    monkeypatch.setattr(live, "FOLLOWS", 60.0)
    evaluation = ready()
    evaluation._latencies.extend([0.1] * 3)
    before_drawing.clear()
    colors = painted()
    move()
    assert before_drawing == [False] and not evaluation.painted
    # It may have time, but stops when that is over.
    monkeypatch.setattr(live, "FOLLOWS", 0.0)
    evaluation._latencies.extend([0.0] * 3)
    move()
    assert before_drawing == [False, False] and evaluation.working
    np.testing.assert_array_equal(painted(), colors)
    run(evaluation)
    assert not staleness.map_is_stale(bpy.context.scene)


@pytest.mark.parametrize(("seconds", "in_time"), [(0.02, True), (0.05, True), (0.1, False)])
def test_what_is_moved_waits_for_the_map_if_that_takes_hardly_longer_than_drawing(settings, seconds, in_time):
    ready()._latencies.extend([seconds] * 3)
    assert live.may_work_before_drawing(bpy.context.scene, bpy.context.view_layer) == in_time


def test_nothing_is_painted_while_others_are_at_work(settings, before_drawing, monkeypatch):
    monkeypatch.setattr(live, "FOLLOWS", 60.0)
    evaluation, scene = ready(), bpy.context.scene
    layer = bpy.context.view_layer

    def may() -> bool:
        return live.may_work_before_drawing(scene, layer)

    assert may()
    # Another view than that of the window.
    assert not live.may_work_before_drawing(scene, scene.view_layers.new("Other"))
    # Someone paints on the floor.
    floor = find_floor(scene)
    layer.objects.active = floor
    bpy.ops.object.mode_set(mode="VERTEX_PAINT")
    assert not may()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert may()
    # Until it is painted again after undo, nobody knows what the floor shows.
    bpy.ops.ed.undo_push(message="one")
    move()
    bpy.ops.ed.undo_push(message="two")
    before_drawing.clear()
    asked = []
    seen = Listener(
        exchanging=lambda: asked.append(evaluation.painted),
        exchanged=lambda: asked.append(evaluation.painted),
    )
    SESSION.listeners.append(seen)
    bpy.ops.ed.undo()
    SESSION.listeners.remove(seen)
    scene, layer = bpy.context.scene, bpy.context.view_layer
    assert asked == [False, False] and not any(before_drawing) and not may()
    run(evaluation)
    evaluation._latencies.extend([0.01] * 3)
    assert may()
    bpy.data.objects.remove(find_floor(scene))
    assert not may()


def test_a_walk_that_plays_moves_nothing_but_an_obstacle_does(settings):
    """Every frame of playback is looked at, but only what moves the environment is work."""
    assert operators.random_walk() == {"FINISHED"}
    scene, moved = bpy.context.scene, []

    def handler(scene, depsgraph):
        assert len(depsgraph.updates) > 0
        moved.append(scene_changes.has_moved(scene, depsgraph))

    bpy.app.handlers.frame_change_post.append(handler)
    for frame in (2, 3, 30):
        scene.frame_set(frame)
    assert moved == [False] * 3
    table = bpy.data.objects["Table"]
    for frame in (30, 40):
        table.location.x += 0.5
        table.keyframe_insert("location", frame=frame)
    scene.frame_set(35)
    bpy.app.handlers.frame_change_post.remove(handler)
    assert moved == [False] * 3 + [True]


# ------------------------------------------------------------------------------------------ disturbances


def test_it_is_no_step_of_undo(settings):
    evaluation = LiveEvaluation()
    bpy.ops.ed.undo_push(message="before")
    colors = painted()
    move()
    bpy.ops.ed.undo_push(message="moved")
    evaluation.change()
    run(evaluation)
    followed = painted()
    assert not np.array_equal(followed, colors)
    # One step back is the place before, not the map before.
    bpy.ops.ed.undo()
    assert bpy.data.objects["Table"].location.x == pytest.approx(-2.2)
    evaluation.forget()
    run(evaluation)
    np.testing.assert_array_equal(painted(), colors)
    assert not staleness.map_is_stale(bpy.context.scene)
    bpy.ops.ed.redo()
    evaluation.forget()
    run(evaluation)
    np.testing.assert_array_equal(painted(), followed)


def test_the_floor_is_painted_again_after_undo_although_nothing_moved(settings):
    evaluation = LiveEvaluation()
    move()
    evaluation.change()
    run(evaluation)
    expected = painted()
    find_floor(bpy.context.scene).data.color_attributes[ATTRIBUTE].data.foreach_set("color", np.zeros_like(expected))
    evaluation.change()
    run(evaluation)
    assert not painted().any(), "it does not look at the floor"
    evaluation.forget()
    run(evaluation)
    np.testing.assert_array_equal(painted(), expected)


def test_deleted_objects(settings):
    evaluation, scene = LiveEvaluation(), bpy.context.scene
    nodes = results().embedding.n_nodes
    bpy.data.objects.remove(bpy.data.objects["Table"])
    bpy.data.objects.remove(find_floor(scene))
    bpy.context.view_layer.update()
    evaluation.change()
    run(evaluation)
    assert results().embedding.n_nodes > nodes and find_floor(scene) is not None
    # What cannot be evaluated is said, and what is shown stays.
    embedding = results().embedding
    for obj in list(settings.environment.obstacles.all_objects):
        bpy.data.objects.remove(obj)
    bpy.data.objects.remove(settings.environment.ground)
    bpy.context.view_layer.update()
    evaluation.change()
    run(evaluation)
    assert "There is no ground" in evaluation.error and results().embedding is embedding
    settings.environment.ground_source = "TYPED"
    evaluation.change()
    run(evaluation)
    assert not evaluation.error and results().embedding is not embedding


def test_another_file_in_the_middle_of_the_work(settings, sample_file):
    evaluation, scene = live.evaluation(bpy.context.scene), bpy.context.scene
    move()
    evaluation.change()
    while not evaluation.working:
        evaluation.step(scene, bpy.context.evaluated_depsgraph_get(), 0.0)
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    assert not evaluation.working
    assert live.evaluation(bpy.context.scene) is not evaluation
    run(live.evaluation(bpy.context.scene))
    assert live.status(bpy.context.scene) == ("Embed the motion graph first", "INFO")


def test_what_the_panel_says(settings):
    scene = bpy.context.scene
    evaluation = live.evaluation(scene)
    move()
    evaluation.change()
    run(evaluation)
    assert evaluation.latency == pytest.approx(sum(evaluation.seconds.values()) - evaluation.seconds["count"])
    evaluation._latencies.extend((0.1, 5.0, 0.1))
    evaluation.written = 0.123
    assert live.status(scene)[0] == "Painted after 0.12 s"
    evaluation.drawn = 0.456
    assert live.status(scene)[0] == "Painted after 0.12 s, drawn after 0.46 s"
    evaluation._latencies.extend((5.0, 5.0))
    assert live.status(scene)[0] == "Painted after 0.12 s, drawn after 0.46 s, when you let go"
    evaluation.change()
    assert live.status(scene) == ("Updates when you let go", "TIME")
    evaluation.error = "The ground is gone"
    assert live.status(scene) == ("The ground is gone", "ERROR")


def test_no_timer_in_background(settings):
    settings.live = True
    move()
    assert not bpy.app.timers.is_registered(live._tick)


# --------------------------------------------------------------------------------------------- reading


def test_only_what_changed_is_read_again(monkeypatch):
    reads = []
    module = __import__(read_triangles.__module__, fromlist=["_local_triangles"])
    read = module._local_triangles
    monkeypatch.setattr(module, "_local_triangles", lambda shown: reads.append(shown.name) or read(shown))
    for number in range(3):
        bpy.ops.mesh.primitive_cube_add(location=(3 * number, 0, 0))
        bpy.context.object.name = f"Box {number}"
    boxes = [bpy.data.objects[f"Box {number}"] for number in range(3)]
    instancer = bpy.data.objects.new("Instances", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", bpy.data.collections.new("Shared")
    instancer.instance_collection.objects.link(boxes[2])
    bpy.context.scene.collection.objects.link(instancer)
    everything, memory = [*boxes, instancer], ShapeMemory()

    def seen():
        reads.clear()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        remembered = read_triangles(everything, depsgraph, memory)
        names = sorted(reads)
        np.testing.assert_array_equal(remembered, read_triangles(everything, depsgraph))
        return names

    assert seen() == ["Box 0", "Box 1", "Box 2", "Box 2"]
    assert seen() == []
    boxes[0].location.x += 1
    boxes[2].scale.z = 2
    assert seen() == [], "a place is no shape"
    boxes[2].data.vertices[0].co.x += 1
    boxes[2].data.update_tag()
    bpy.context.view_layer.update()
    memory.forget([boxes[2].session_uid])
    assert seen() == ["Box 2", "Box 2"]
    boxes[1].modifiers.new("Array", "ARRAY")
    bpy.context.view_layer.update()
    memory.forget([boxes[1].session_uid])
    assert seen() == ["Box 1"]


def test_what_is_remembered_is_what_is_there(settings):
    """Of a scene that others change in every way, the live evaluation knows no more and no less than a first look."""
    scene, rng = bpy.context.scene, np.random.default_rng(4)
    evaluation = live.evaluation(scene)
    obstacles = settings.environment.obstacles
    table = bpy.data.objects["Table"]

    def edit():
        table.data.vertices[0].co.x += 0.4
        table.data.update_tag()

    def add():
        copy = table.copy()
        copy.location.y += 1.0
        obstacles.objects.link(copy)

    def turn():
        for obj in obstacles.all_objects:
            obj.rotation_euler.z += rng.uniform(0, 1)

    def widen():
        table.modifiers.new("Array", "ARRAY").count = 2

    def hide():
        bpy.data.objects["Pillar A"].hide_viewport = True

    def remove():
        bpy.data.objects.remove(bpy.data.objects["Pillar B"])

    def undo():
        bpy.ops.ed.undo_push(message="before")
        turn()
        bpy.ops.ed.undo_push(message="after")
        bpy.ops.ed.undo()

    blocked = []
    for change in (edit, add, turn, widen, hide, remove, undo):
        change()
        bpy.context.view_layer.update()
        scene = bpy.context.scene
        evaluation.change()
        run(evaluation)
        shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get())
        environment = results().embedding.environment
        np.testing.assert_array_equal(environment.blocked, make_environment(scene, shapes).blocked)
        assert not staleness.embedding_is_stale(scene)
        blocked.append(environment.blocked.sum())
    assert len(set(blocked[:6])) == 6, "one of the changes made no difference"


def test_our_own_long_work_is_known_by_its_name():
    assert live.is_long_work("WAYFARER_OT_embed") and live.is_long_work("WAYFARER_OT_paint_map")
    assert not live.is_long_work("WAYFARER_OT_pick_place")
    assert not live.is_long_work("TRANSFORM_OT_translate") and not live.is_long_work("NO_OT_such")
