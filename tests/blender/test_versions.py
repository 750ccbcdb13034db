"""The differences between the versions of Blender: gathered in one module, and gone for everybody else."""

import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

import dev
from bl_ext.user_default.wayfarer.addon.bridge import versions
from bl_ext.user_default.wayfarer.addon.results import shown, staleness, store
from bl_ext.user_default.wayfarer.core.maps.colors import linear
from bl_ext.user_default.wayfarer.tools.pictures.picture_scene import picture_scene

SIZE = 16
# Looked at from .venv; made by `dev.py test --blender VERSION`.
OTHERS = dev.other_pythons() if Path(sys.prefix).name == ".venv" else []
# Runs the sample and saves it to the file named last; prints its numbers.
RUN_SAMPLE = """
import json, os, sys
import bpy
import addon_utils
sys.path.insert(0, sys.argv[1])
import install_extension
addon_utils.enable(install_extension.EXTENSION, default_set=True)
numbers = install_extension.run_sample()
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[2])
print(json.dumps(numbers), flush=True)
os._exit(0)
"""


def numbers_of(summary) -> dict:
    """As install_extension has them."""
    return {"nodes": summary.nodes, "links": summary.links, "walk_segments": summary.walk.segments}


def test_one_module_alone_asks_for_the_version():
    asking = set()
    for path in (dev.ROOT / "addon").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr in ("version", "version_string", "__version__"):
                owner = ast.unparse(node.value)
                if owner.endswith("app") or node.attr == "__version__":
                    asking.add(path.relative_to(dev.ROOT / "addon").as_posix())
    assert asking == {"bridge/versions.py"}


def test_the_oldest_version_is_the_one_that_the_manifest_names():
    oldest = re.search(r'^blender_version_min = "(.+)"', dev.MANIFEST.read_text("utf-8"), re.MULTILINE).group(1)
    tested = [tuple(map(int, version.split("."))) for version in dev.blenders()]
    assert min(tested) == tuple(map(int, oldest.split(".")))[:2]
    assert bpy.app.version[:2] in tested


def test_new_materials_and_worlds_have_nodes():
    material, world = bpy.data.materials.new("New"), bpy.data.worlds.new("New")
    shader = versions.node_tree(material).nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = 0.25
    assert versions.node_tree(material) == material.node_tree
    assert material.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value == 0.25
    assert {node.type for node in versions.node_tree(world).nodes} >= {"OUTPUT_WORLD"}


def plane(name, srgb=None, x=0.0):
    """A square of 2 x 2 m, with a material of this colour."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(x - 1, -1, 0), (x + 1, -1, 0), (x + 1, 1, 0), (x - 1, 1, 0)], [], [(0, 1, 2, 3)])
    if srgb is not None:
        material = bpy.data.materials.new(name)
        material.diffuse_color = (*linear(srgb), 1.0)
        mesh.materials.append(material)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def test_solid_mode_keeps_material_colours_beside_painted_ones(tmp_path):
    plain, painted = plane("Plain", (0.8, 0.2, 0.1), -1.0), plane("Painted", (0.1, 0.1, 0.9), 1.0)
    layer = painted.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.tile([*linear((0.1, 0.7, 0.2)), 1.0], 4).astype(np.float32))
    with picture_scene("Picture") as picture:
        picture.scene.render.engine = "BLENDER_WORKBENCH"
        picture.scene.display.shading.light = "FLAT"
        picture.scene.display.shading.color_type = "VERTEX"
        picture.show([plain, painted])
        camera = picture.camera()
        camera.location, camera.data.type, camera.data.ortho_scale = (0, 0, 5), "ORTHO", 4.0
        picture.render(tmp_path / "both.png", 2 * SIZE, SIZE)
    image = bpy.data.images.load(str(tmp_path / "both.png"))
    pixels = np.array(image.pixels[:]).reshape(SIZE, 2 * SIZE, 4)[:, :, :3]
    np.testing.assert_allclose(pixels[SIZE // 2, SIZE // 2], (0.8, 0.2, 0.1), atol=0.02)
    np.testing.assert_allclose(pixels[SIZE // 2, SIZE + SIZE // 2], (0.1, 0.7, 0.2), atol=0.02)


def test_colours_that_somebody_chose_stay(tmp_path):
    chosen, bare = plane("Chosen", (0.8, 0.2, 0.1)), plane("Bare")
    chosen.color = (0.2, 0.4, 0.6, 1.0)
    versions.keep_material_colors([chosen, bare])
    assert tuple(chosen.color) == pytest.approx((0.2, 0.4, 0.6, 1.0))
    assert tuple(bare.color) == (1.0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize("python", OTHERS, ids=lambda python: python.parent.parent.name)
def test_results_of_another_version_are_the_same_and_stay_fresh(python, tmp_path):
    made, user = tmp_path / "made.blend", tmp_path / "user"
    dev.link_extension(user)
    result = subprocess.run(
        [python, "-c", RUN_SAMPLE, str(Path(__file__).parent), str(made)],
        env={**os.environ, "BLENDER_USER_RESOURCES": str(user)},
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    numbers = json.loads(result.stdout.strip().splitlines()[-1])
    bpy.ops.wm.open_mainfile(filepath=str(made))
    scene = bpy.context.scene
    assert bpy.data.version[:2] != bpy.app.version[:2]
    found = store.results(scene)
    assert found.problem == "" and numbers_of(store.results(scene).summary) == numbers
    assert not any(
        (staleness.graph_is_stale(scene), staleness.embedding_is_stale(scene), staleness.map_is_stale(scene))
    )
    assert not staleness.walk_is_stale(scene) and shown.find_walk(scene) is not None
    # Done again here, it comes out the same.
    for step in ("build_motion_graph", "embed", "paint_map", "random_walk"):
        assert getattr(bpy.ops.wayfarer, step)() == {"FINISHED"}, step
    assert numbers_of(store.results(scene).summary) == numbers
