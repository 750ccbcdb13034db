"""The body that makes an armature visible."""

import os
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Quaternion, Vector

from bl_ext.user_default.wayfarer.addon.bridge.body import add_body, remove_body
from bl_ext.user_default.wayfarer.addon.bridge.create_armature import create_armature
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_skeleton


def coordinates(obj, evaluated=False) -> np.ndarray:
    """(V, 3) world positions of an object's vertices."""
    if evaluated:
        obj = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.empty(3 * len(obj.data.vertices), dtype=np.float32)
    obj.data.vertices.foreach_get("co", points)
    matrix = np.array(obj.matrix_world)
    return points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


def shares(body) -> dict[str, np.ndarray]:
    """(V,) weight of every vertex in each group."""
    found = {group.name: np.zeros(len(body.data.vertices)) for group in body.vertex_groups}
    for vertex in body.data.vertices:
        for group in vertex.groups:
            found[body.vertex_groups[group.group].name][vertex.index] = group.weight
    return found


def check_body(armature, body):
    weights = shares(body)
    np.testing.assert_allclose(sum(weights.values()), 1.0, atol=0.02)
    assert set(weights) <= {bone.name for bone in armature.data.bones}
    assert all(len(polygon.vertices) >= 3 for polygon in body.data.polygons)
    # Closed volumes: every edge has two faces.
    counts = {}
    for polygon in body.data.polygons:
        for edge in polygon.edge_keys:
            counts[edge] = counts.get(edge, 0) + 1
    assert set(counts.values()) == {2}
    return weights


def volume(body) -> float:
    """Positive if faces look outwards."""
    body.data.calc_loop_triangles()
    corners = np.array([t.vertices for t in body.data.loop_triangles])
    a, b, c = (coordinates(body)[corners[:, k]] for k in range(3))
    return float(np.sum(np.cross(a, b) * c) / 6)


def sample_armature():
    armature = create_armature(sample_skeleton(), {}, "Character", bpy.context.scene.collection)
    bpy.context.view_layer.update()
    return armature


def test_a_body_of_human_size():
    armature = sample_armature()
    body = add_body(armature)
    bpy.context.view_layer.update()
    weights = check_body(armature, body)
    points = coordinates(body)
    assert points[:, 2].min() == pytest.approx(0.0, abs=0.03)
    assert points[:, 2].max() == pytest.approx(1.75, abs=0.08)
    assert 0.04 < volume(body) < 0.1
    for bone in ("Hips", "Spine2", "Head", "LeftArm", "RightHand", "LeftLeg", "RightFoot", "LeftToeBase"):
        assert weights[bone].max() == 1.0
    trunk = points[weights["Spine1"] > 0.5]
    assert np.ptp(trunk[:, 0]) > np.ptp(trunk[:, 1])
    np.testing.assert_allclose(points[weights["LeftHand"] > 0].mean(axis=0)[0], 0.62, atol=0.1)


def test_the_body_follows_the_bones():
    armature = sample_armature()
    armature.location = (1.0, 2.0, 0.0)
    body = add_body(armature)
    bpy.context.view_layer.update()
    weights = shares(body)
    rest = coordinates(body)
    bone = armature.pose.bones["LeftArm"]
    bone.rotation_quaternion = Quaternion((1.0, 0.0, 0.0), 1.2)
    bpy.context.view_layer.update()
    moved = np.linalg.norm(coordinates(body, evaluated=True) - rest, axis=1)
    assert moved[weights["LeftHand"] > 0].min() > 0.2
    assert moved[weights["RightHand"] > 0].max() < 1e-5
    hand = coordinates(body, evaluated=True)[weights["LeftHand"] > 0].mean(axis=0)
    head = armature.matrix_world @ armature.pose.bones["LeftHand"].head
    assert (Vector(hand) - head).length < 0.15


def test_a_body_leaves_nothing_behind():
    armature = sample_armature()
    kept, removed = add_body(armature), add_body(armature)
    assert len(bpy.data.materials) == 2
    remove_body(removed)
    assert [obj.data for obj in armature.children] == list(bpy.data.meshes) == [kept.data]
    assert len(bpy.data.materials) == 2
    remove_body(kept)
    assert not list(bpy.data.meshes) and not list(bpy.data.materials) and list(bpy.data.objects) == [armature]


@pytest.mark.parametrize("scale", [1.0, 0.05])
def test_any_rig_gets_a_body(scale):
    data = bpy.data.armatures.new("Crane")
    armature = bpy.data.objects.new("Crane", data)
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for name, head, tail in (
        ("tower", (0, 0, 0), (0, 0, 3)),
        ("jib", (0, 0, 3), (2, 0, 3)),
        ("pin", (2, 0, 3), (2, 0, 2.9999)),
        ("hook", (2, 0, 3), (2, 0, 2)),
    ):
        bone = data.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = Vector(head) * scale, Vector(tail) * scale, parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    body = add_body(armature)
    bpy.context.view_layer.update()
    weights = check_body(armature, body)
    assert set(weights) == {"tower", "jib", "hook"}
    assert np.ptp(coordinates(body)[:, 0]) == pytest.approx(2 * scale, rel=0.15)


def test_a_chain_of_bones_too_short_to_be_seen(tmp_path, capfd):
    """It is imported, and used, without a body."""
    n_joints = 120
    joints = "JOINT J{}\n{{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    (tmp_path / "snake.bvh").write_text(
        "HIERARCHY\nROOT R\n{\nOFFSET 0 0 0\n"
        "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
        + "".join(joints.format(joint) for joint in range(n_joints))
        + "End Site\n{\nOFFSET 0 1 0\n}\n"
        + "}\n" * (n_joints + 1)
        + "MOTION\nFrames: 3\nFrame Time: 0.03\n"
        + (" ".join(["0"] * (6 + 3 * n_joints)) + "\n") * 3
    )
    assert bpy.ops.wayfarer.import_bvh(directory=str(tmp_path)) == {"FINISHED"}
    assert "No body was added" in capfd.readouterr().out
    settings = bpy.context.scene.wayfarer
    assert settings.character.name == "snake" and list(bpy.data.objects) == [settings.character]
    assert [clip.action.name for clip in settings.clips] == ["snake"]
    assert not list(bpy.data.meshes) and not list(bpy.data.materials)
    assert add_body(settings.character) is None


def test_a_body_for_motion_capture():
    default = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    path = Path(os.environ.get("WAYFARER_DATA", default)) / "cmu16" / "16_09.bvh"
    if not path.is_file():
        pytest.skip(f"the CMU clips are not at {path.parent}; set WAYFARER_DATA to the folder that holds cmu16")
    from bl_ext.user_default.wayfarer.addon.bridge.import_bvh import import_bvh_files

    armature, _, _ = import_bvh_files([path])
    armature.data.pose_position = "REST"
    body = add_body(armature)
    bpy.context.view_layer.update()
    weights = check_body(armature, body)
    points = coordinates(body)
    assert 1.5 < np.ptp(points[:, 2]) < 1.95
    for bone in ("Hips", "Spine", "LeftArm", "RightForeArm", "LeftUpLeg", "RightLeg", "LeftFoot", "Head"):
        assert weights[bone].max() > 0.9
    assert volume(body) > 0.03


@pytest.mark.parametrize("lying", [False, True])
@pytest.mark.parametrize("along", ["+x", "-x", "+y", "-y", "+z", "-z", "nowhere"])
def test_a_body_of_folded_bones_is_finite(along, lying):
    """Every bone along one axis, as programs write that keep the axes of joints; or all at one place."""
    skeleton = sample_skeleton()
    lengths = np.linalg.norm(skeleton.rest_translations, axis=1)
    direction = np.zeros(3)
    if along != "nowhere":
        direction["xyz".index(along[1])] = float(f"{along[0]}1")
    rest = np.tile([1.0, 0, 0, 0], (skeleton.n_joints, 1))
    folded = replace(skeleton, rest_rotations=rest, rest_translations=lengths[:, None] * direction)
    armature = create_armature(folded, {}, "Folded", bpy.context.scene.collection)
    del armature["wayfarer_forward"]
    armature.rotation_euler.x = np.pi / 2 * lying
    bpy.context.view_layer.update()
    body = add_body(armature)
    assert body is None or np.isfinite(coordinates(body)).all()
