"""Undo, where the floor was made by the live evaluation: Blender is to know of it, and live is not to bring it back."""

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon.live.evaluation import LiveEvaluation
from bl_ext.user_default.wayfarer.addon.render.floor import find_floor
from bl_ext.user_default.wayfarer.addon.results import shown

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(sample_settings):
    for step in ("build_motion_graph", "embed"):
        assert getattr(operators, step)() == {"FINISHED"}
    return sample_settings


def follow(evaluation: LiveEvaluation) -> None:
    """Let the map follow the scene; nobody is an operator here."""
    evaluation.change()
    while not evaluation.step(bpy.context.scene, bpy.context.evaluated_depsgraph_get(), 10.0):
        pass


def move(x: float) -> None:
    """A change, and its step of undo."""
    bpy.data.objects["Table"].location.x += x
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="Move")


def place() -> float:
    return bpy.data.objects["Table"].location.x


def floor():
    """The floor, after everything that the file holds has been looked at: whatever is no more would end Blender."""
    for collection in bpy.data.collections:
        assert all(obj.name and (obj.data is None or obj.data.name) for obj in collection.objects)
    bpy.context.view_layer.update()
    return find_floor(bpy.context.scene)


def test_a_floor_that_live_makes_is_a_step_of_undo(settings):
    """Without one, Blender would go back past it, and leave it in a collection that it believes unchanged."""
    operators.paint_map()
    bpy.ops.ed.undo_push(message="Paint")
    bpy.data.batch_remove([find_floor(bpy.context.scene)])
    bpy.ops.ed.undo_push(message="Delete")
    evaluation = LiveEvaluation()
    follow(evaluation)
    assert floor() is not None and shown.find_painted(bpy.context.scene) is not None
    bpy.ops.ed.undo()
    assert floor() is None
    bpy.ops.ed.redo()
    assert floor() is not None and shown.find_painted(bpy.context.scene) == floor()
    # What an existing floor shows is none: one step back is the place before.
    before = place()
    move(0.3)
    evaluation.forget()
    follow(evaluation)
    bpy.ops.ed.undo()
    assert place() == pytest.approx(before) and floor() is not None


def test_nothing_dangles_where_nothing_was_painted_before(settings):
    bpy.ops.ed.undo_push(message="Start")
    start = place()
    move(0.2)
    move(0.2)
    follow(LiveEvaluation())
    assert floor() is not None
    bpy.ops.ed.undo()
    assert floor() is None and place() == pytest.approx(start + 0.4)
    bpy.ops.ed.undo()
    assert floor() is None and place() == pytest.approx(start + 0.2)
    for _ in range(2):
        bpy.ops.ed.redo()
    assert floor() is not None and place() == pytest.approx(start + 0.4)


def test_a_floor_that_was_undone_does_not_come_back_by_itself(settings):
    """Or nobody could ever undo what was before it, nor redo."""
    bpy.ops.ed.undo_push(message="Start")
    start, evaluation = place(), LiveEvaluation()
    move(0.2)
    follow(evaluation)
    bpy.ops.ed.undo()
    evaluation.forget()
    follow(evaluation)
    assert floor() is None and "was undone; redo, or paint the map again" in evaluation.error
    bpy.ops.ed.undo()
    evaluation.forget()
    follow(evaluation)
    assert floor() is None and place() == pytest.approx(start)
    for _ in range(2):
        bpy.ops.ed.redo()
        evaluation.forget()
        follow(evaluation)
    assert floor() is not None and not evaluation.error and place() == pytest.approx(start + 0.2)
    bpy.ops.ed.undo()
    assert floor() is None
    # Whoever asks for it has it again.
    assert operators.paint_map() == {"FINISHED"}
    follow(evaluation)
    assert floor() is not None and not evaluation.error
