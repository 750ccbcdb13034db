"""The panel Queries: times to and from everything that can be asked for, painted and told; and walks from a place."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.owned import OUTPUT, find_collection, walk_fan
from bl_ext.user_default.wayfarer.addon.bridge.write_colors import painted_colors
from bl_ext.user_default.wayfarer.addon.render.floor import find_floor, floor_legend
from bl_ext.user_default.wayfarer.addon.render.walk_fan import COLORS, NAME
from bl_ext.user_default.wayfarer.addon.results import findings, staleness
from bl_ext.user_default.wayfarer.core.evaluation import goals
from bl_ext.user_default.wayfarer.core.evaluation.reach import time_from_steps, time_to_reach_steps
from bl_ext.user_default.wayfarer.core.evaluation.segment_groups import segments_of_clip
from bl_ext.user_default.wayfarer.core.maps.colors import displayed
from bl_ext.user_default.wayfarer.core.progress import finish
from bl_ext.user_default.wayfarer.core.report import topics
from bl_ext.user_default.wayfarer.core.wording import area as area_words

from .findings import contents, embedding, found, is_stale, kept, operators, refused, rows, run, undone

WALK_AND_STEP = ("walk", "turn_left", "turn_right", "arc", "step")


@pytest.fixture
def settings(sample_settings):
    run("build_motion_graph", "embed")
    return sample_settings


@pytest.fixture
def stepping(sample_settings):
    """With the clips that step over, so that there is a tag, and the region can be crossed."""
    for clip in sample_settings.clips:
        clip.use = clip.action.name.startswith(WALK_AND_STEP)
    run("build_motion_graph", "embed")
    return sample_settings


def scene():
    return bpy.context.scene


def check(field) -> None:
    """What is kept, painted and told is this field."""
    areas = {time: area for time, area, _ in rows(topics.REACH)}
    assert list(areas.values()) == field.areas(list(areas))
    shown = dict(findings.numbers_of(kept(topics.REACH)))
    for time, area in areas.items():
        assert shown[f"Within {time:g} s"].startswith(f"{area_words(area)} (")
    floor = find_floor(scene())
    legend = floor_legend(floor)
    colors = displayed(painted_colors(floor)[..., :3])
    bands = np.searchsorted(list(areas), field.floor() - 1e-3)
    for band in range(len(areas)):
        cells = bands == band
        assert np.allclose(colors[cells], legend.swatches[band].color, atol=2e-3)
    # Cells that cannot be reached are not in any band's colour.
    lost = ~np.isfinite(field.floor())
    assert lost.any() and not np.any(np.all(np.abs(colors[lost][:, None] - colors[bands == 0][:1]) < 0.02, axis=-1))
    assert not staleness.map_is_stale(scene())


# ------------------------------------------------------------------------------------------------- times


def test_times_to_and_from_a_place(settings):
    queries, place = settings.queries, (-1.0, -2.0)
    scene().cursor.location = (*place, 0.0)
    run("find_reach")
    goal = goals.goal_at(embedding(), place, queries.radius)
    there = finish(time_to_reach_steps(embedding(), goal))
    check(there)
    assert [row[0] for row in rows(topics.REACH)] == [2.0, 3.0, 5.0, 7.0]
    assert settings.map.quantity == "QUERY" and floor_legend(find_floor(scene())).title == "Time to (-1.0, -2.0) m"
    queries.direction = "FROM"
    assert staleness.map_is_stale(scene())
    run("find_reach")
    back = finish(time_from_steps(embedding(), goal))
    check(back)
    assert there.areas() != back.areas()
    # The same by painting the map only.
    colors = painted_colors(find_floor(scene()))
    run("paint_map")
    np.testing.assert_array_equal(painted_colors(find_floor(scene())), colors)
    assert not staleness.map_is_stale(scene())
    scene().cursor.location.x += 1
    assert staleness.map_is_stale(scene())


def test_times_to_an_object_follow_it(settings):
    empty = bpy.data.objects.new("Door", None)
    scene().collection.objects.link(empty)
    empty.location = (1.0, -2.5, 0.4)
    bpy.context.view_layer.update()
    queries = settings.queries
    queries.goal, queries.radius, queries.times = "OBJECT", 0.6, (1.0, 4.0, 4.0, 2.5)
    assert "No object is chosen" in refused(operators.find_reach)
    queries.object = empty
    run("find_reach")
    check(finish(time_to_reach_steps(embedding(), goals.goal_at(embedding(), (1.0, -2.5), queries.radius))))
    assert [row[0] for row in rows(topics.REACH)] == [1.0, 2.5, 4.0]
    empty.location.x -= 1.5
    bpy.context.view_layer.update()
    assert staleness.map_is_stale(scene())


def test_times_to_what_a_character_does(stepping):
    here, queries = embedding(), stepping.queries
    clip = here.graph.clips[here.graph.segments[0].clip].name
    queries.goal = "CLIP"
    assert "No clip is chosen" in refused(operators.find_reach)
    queries.clip = clip
    run("find_reach")
    segments = segments_of_clip(here.graph, clip)
    check(finish(time_to_reach_steps(here, goals.goal_to_begin(here, segments))))
    queries.direction = "FROM"
    run("find_reach")
    check(finish(time_from_steps(here, goals.goal_after(here, segments))))
    queries.goal, queries.tag, queries.direction = "TAG", "step", "TO"
    run("find_reach")
    check(finish(time_to_reach_steps(here, goals.goal_with_tag(here, "step"))))


def test_times_to_a_region(settings):
    bpy.ops.mesh.primitive_plane_add(size=1.0, location=(-1.0, -2.0, 0.0))
    door = bpy.context.object
    door.name = "Door"
    region = settings.environment.regions.add()
    # Nobody flies here: the region only marks a place.
    region.object, region.rule, region.tag = door, "FORBID", "fly"
    run("embed")
    queries = settings.queries
    queries.goal, queries.region, queries.times = "REGION", "Door", (1.0, 2.0, 3.0, 4.0)
    run("find_reach")
    check(finish(time_to_reach_steps(embedding(), goals.goal_in_region(embedding(), "Door"))))
    # No segment of these clips ends where the character would have to step over.
    queries.region = "Step"
    assert "'Step' cannot be reached" in refused(operators.find_reach)


def test_what_cannot_be_reached_is_told(settings):
    queries = settings.queries
    scene().cursor.location = (50.0, 0.0, 0.0)
    assert "off the ground" in refused(operators.find_reach)
    queries.goal, queries.tag = "TAG", "fly"
    assert "carries the tag 'fly'" in refused(operators.find_reach)
    queries.goal, queries.region = "REGION", "Nowhere"
    assert "no region 'Nowhere'" in refused(operators.find_reach)


def test_a_floor_that_is_being_edited_is_left_alone(settings):
    run("paint_map")
    bpy.context.view_layer.objects.active = find_floor(scene())
    bpy.ops.object.mode_set(mode="EDIT")
    assert settings.map.quantity != "QUERY"
    assert "is being edited" in refused(operators.find_reach)
    bpy.ops.object.mode_set(mode="OBJECT")
    run("find_reach")
    assert settings.map.quantity == "QUERY"


def test_choices_are_offered(stepping):
    from bl_ext.user_default.wayfarer.addon.properties import graph_names, queries

    group = stepping.queries
    assert queries._region_names(group, bpy.context, "st") == ["Step"]
    assert graph_names.tag_names(group, bpy.context, "") == ["step"]
    clips = graph_names.clip_names(group, bpy.context, "turn_LEFT")
    graph = embedding().graph
    played = {graph.clips[segment.clip].name for segment in graph.segments}
    assert clips == [name for name in (clip.name for clip in graph.clips) if name in played and "turn_left" in name]


def test_undone_in_one_step(settings):
    undone("find_reach")
    undone("walks_from", location=(-1.0, -2.0))
    assert find_floor(scene()) is None


def test_nothing_to_ask_without_an_embedding(sample_settings):
    for name in ("find_reach", "walks_from", "pick_walks_from"):
        assert "Embed the motion graph first" in refused(getattr(operators, name))


# ------------------------------------------------------------------------------------------------- walks


def curves():
    return walk_fan(find_collection(scene(), OUTPUT))


def points(obj) -> np.ndarray:
    values = np.empty(4 * len(obj.data.splines[0].points), dtype=np.float32)
    obj.data.splines[0].points.foreach_get("co", values)
    return values.reshape(-1, 4)[:, :3]


def test_walks_from_a_place(settings):
    run("random_walk")
    queries, place = settings.queries, (-1.0, -2.0)
    queries.n_walks, queries.duration = 8, 3.0
    assert operators.walks_from(location=place) == {"FINISHED"}
    fan = curves()
    assert len(fan) == 8
    cells = np.argwhere(embedding().covered().any(axis=2))
    centres = embedding().environment.grid.positions(cells)
    nearest = centres[np.argmin(np.linalg.norm(centres - place, axis=1))]
    for number, obj in enumerate(fan):
        assert points(obj)[0] == pytest.approx((*nearest, found().ground_height + 0.03), abs=1e-5)
        material = obj.data.materials[0]
        assert displayed(material.diffuse_color[:3]) == pytest.approx(COLORS[number % len(COLORS)], abs=2e-3)
    assert len({points(obj).tobytes() for obj in fan}) >= 6  # two may meet by chance
    # Every point of them lies where the character may be: nothing leaves the free floor.
    assert all(np.all(np.abs(points(obj)[:, :2]) < 4.1) for obj in fan)
    # The same again with the same seed, in place of the first ones; others with another.
    first = [points(obj).tobytes() for obj in fan]
    n_objects, n_curves = len(bpy.data.objects), len(bpy.data.curves)
    operators.walks_from(location=place)
    assert [points(obj).tobytes() for obj in curves()] == first
    assert (len(bpy.data.objects), len(bpy.data.curves)) == (n_objects, n_curves)
    queries.seed, queries.style = 1, "RANDOM"
    operators.walks_from(location=place)
    # In three seconds there are few ways to go, and one may come again by chance.
    assert len({points(obj).tobytes() for obj in curves()} & set(first)) <= 2
    # What the artist hung on one of them hangs there still, and those that are too many are gone.
    lamp = bpy.data.objects.new("Lamp", None)
    scene().collection.objects.link(lamp)
    lamp.parent = curves()[0]
    queries.n_walks = 3
    assert operators.walks_from(location=place) == {"FINISHED"}
    assert len(curves()) == 3 and lamp.parent == curves()[0]
    # Without a mouse they start at the 3D cursor.
    scene().cursor.location = (*place, 0.0)
    assert operators.pick_walks_from() == {"FINISHED"}
    # The baked walk is left alone.
    assert operators.clear_walks_from() == {"FINISHED"} and curves() == []
    assert "Wayfarer Walk" in find_collection(scene(), OUTPUT).objects
    assert not operators.clear_walks_from.poll()


def test_fewer_walks_leave_no_materials_behind(settings):
    def materials():
        """Those of the fan, and who uses them."""
        return {m.name: m.users for m in bpy.data.materials if m.name.startswith(NAME)}

    queries = settings.queries
    queries.n_walks, queries.duration = 3, 2.0
    assert operators.walks_from() == {"FINISHED"}
    assert materials() == {f"{NAME} {number}": 1 for number in (1, 2, 3)}
    recolored, kept_color = bpy.data.materials[f"{NAME} 2"], (0.1, 0.2, 0.3, 1.0)
    recolored.diffuse_color = kept_color
    bpy.data.materials[f"{NAME} 3"].use_fake_user = True
    queries.n_walks = 2
    assert operators.walks_from() == {"FINISHED"}
    assert materials() == {f"{NAME} 1": 1, f"{NAME} 2": 1, f"{NAME} 3": 1}
    bpy.data.materials[f"{NAME} 3"].use_fake_user = False
    assert operators.walks_from() == {"FINISHED"}
    # One that another colour was given, too, is used again as long as there is a walk for it.
    assert materials() == {f"{NAME} 1": 1, f"{NAME} 2": 1}
    assert tuple(recolored.diffuse_color) == pytest.approx(kept_color)
    queries.n_walks = 1
    assert operators.walks_from() == {"FINISHED"}
    assert materials() == {f"{NAME} 1": 1}
    # One that someone has put on something else is not ours to remove.
    mesh = bpy.data.meshes.new("Own")
    mesh.materials.append(bpy.data.materials[f"{NAME} 1"])
    assert operators.clear_walks_from() == {"FINISHED"} and materials() == {f"{NAME} 1": 1}


def test_materials_of_another_file_are_not_ours(settings, tmp_path):
    settings.queries.n_walks, settings.queries.duration = 1, 2.0
    there = bpy.data.materials.new(f"{NAME} 1")
    path = str(tmp_path / "other.blend")
    bpy.data.libraries.write(path, {there})
    bpy.data.materials.remove(there)
    with bpy.data.libraries.load(path, link=True) as (_, here):
        here.materials = [f"{NAME} 1"]
    [linked] = here.materials
    assert linked.library is not None
    assert operators.walks_from() == {"FINISHED"}
    [own] = curves()[0].data.materials
    assert own.library is None and own != linked
    assert operators.clear_walks_from() == {"FINISHED"}
    assert bpy.data.materials[f"{NAME} 1"].library is not None


def test_nothing_changes_before_the_work_is_done(settings):
    before = contents()
    work = bpy.types.WAYFARER_OT_find_reach.steps(None, bpy.context)
    next(work)
    work.close()
    assert contents() == before


def test_the_answer_knows_what_it_is_about(settings):
    run("find_reach")
    assert not is_stale(topics.REACH)
    assert kept(topics.REACH).sentences == "Time to (0.0, 0.0) m"
    bpy.data.objects["Table"].location.x += 0.6
    bpy.context.view_layer.update()
    run("embed")
    assert is_stale(topics.REACH)
