"""The one rule of the layout, proved on the source: addon -> core, never back, and core in layers."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy
import pytest

ROOT = Path(__file__).resolve().parents[2]
# Each folder of core may import itself and those before it.
CORE_LAYERS = (
    "motion",
    "environment",
    "embedding",
    "evaluation",
    "tuning",
    "playback",
    "maps",
    "report",
    "parcels",
    "study",
    "export",
)
# What the core may import from outside; NumPy and SciPy are all that the extension brings or finds.
CORE_PACKAGES = {"numpy", "scipy", *sys.stdlib_module_names}
# (importer, imported) within the extension, by the first folders of their names. ui draws what core.maps describes.
FORBIDDEN = (
    *(("addon.ui", f"core.{layer}") for layer in CORE_LAYERS if layer != "maps"),
    ("core", "addon"),
    ("core", "tools"),
    ("addon", "tools"),
)
# Each room of addon may import itself and those before it.
ADDON_ROOMS = (
    "bridge",
    "session",
    "jobs",
    "properties",
    "render",
    "sample",
    "scene",
    "results",
    "live",
    "walks",
    "exports",
    "operators",
    "ui",
    "cli",
)
SHAPELESS_NAMES = ("utils.py", "helpers.py", "util.py", "helper.py")


@dataclass(frozen=True)
class Import:
    """One module that a file imports, by its name from the root of the checkout."""

    target: str
    line: int
    relative: bool


def read_sources(*folders: str) -> dict[str, str]:
    """Path from the root (with slashes) -> source of every Python file in the folders."""
    files = sorted(file for folder in folders for file in (ROOT / folder).rglob("*.py"))
    return {file.relative_to(ROOT).as_posix(): file.read_text("utf-8") for file in files}


def module_name(path: str) -> str:
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def inside(module: str, package: str) -> bool:
    return module == package or module.startswith(package + ".")


def imports_of(path: str, source: str, modules: set[str]) -> Iterator[Import]:
    """Every import of a file, wherever it stands; ``modules`` tells ``from x import module`` from a name."""
    package = module_name(path).split(".")
    if not path.endswith("/__init__.py"):
        package = package[:-1]
    for node in ast.walk(ast.parse(source, path)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(alias.name, node.lineno, relative=False)
        elif isinstance(node, ast.ImportFrom):
            kept = package[: max(len(package) - node.level + 1, 0)] if node.level else []
            base = ".".join([*kept, *(node.module.split(".") if node.module else [])])
            for alias in node.names:
                whole = f"{base}.{alias.name}".lstrip(".")
                # In the root package, `from .. import core` names a module and nothing else.
                yield Import(whole if whole in modules or not base else base, node.lineno, node.level > 0)


def violations(sources: Mapping[str, str]) -> list[str]:
    """A sentence for every breach of the layout in the files of core and addon."""
    found = []
    modules = {module_name(path) for path in sources}
    graph: dict[str, set[str]] = {module: set() for module in modules}
    for path, source in sources.items():
        module = module_name(path)
        if path.rpartition("/")[2] in SHAPELESS_NAMES:
            found.append(f"{path}: name the file after the concept that it holds")
        for imported in imports_of(path, source, modules):
            place = f"{path}:{imported.line}: imports {imported.target}"
            found += [f"{place}, {reason}" for reason in import_breaches(module, imported)]
            if imported.target in modules - {module}:
                graph[module].add(imported.target)
        if inside(module, "core"):
            found += [f"{path}:{line}: calls {name}" for name, line in forbidden_calls(source)]
    found += [f"import cycle: {' -> '.join(cycle)}" for cycle in find_cycles(graph)]
    return found


def import_breaches(module: str, imported: Import) -> Iterator[str]:
    """Why ``module`` may not import this, if so."""
    target, ours = imported.target, imported.target.partition(".")[0] in ("core", "addon")
    if ours and not imported.relative:
        yield "not relatively: inside Blender the package has another name"
    for importer, forbidden in FORBIDDEN:
        if inside(module, importer) and inside(target, forbidden):
            yield f"but {importer} must not know {forbidden}"
    if inside(module, "addon") and inside(target, "addon"):
        own, other = (name.split(".")[1] if "." in name else "" for name in (module, target))
        known = own in ADDON_ROOMS and other in ADDON_ROOMS
        if known and ADDON_ROOMS.index(other) > ADDON_ROOMS.index(own):
            yield f"but {own} lies below {other}"
    if not inside(module, "core"):
        return
    if not ours:
        if imported.relative or target.partition(".")[0] not in CORE_PACKAGES:
            yield "but core knows the standard library, NumPy and SciPy only"
        return
    own, other = (name.split(".")[1] if "." in name else "" for name in (module, target))
    if other not in CORE_LAYERS:
        return
    if own not in CORE_LAYERS:
        yield f"but core.{own} lies below all folders of core"
    elif CORE_LAYERS.index(other) > CORE_LAYERS.index(own):
        yield f"but {own} lies below {other}"


def forbidden_calls(source: str) -> Iterator[tuple[str, int]]:
    """Calls that core leaves to others: printing, and importing by a name that this test cannot see."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call):
            called = node.func
            name = called.id if isinstance(called, ast.Name) else getattr(called, "attr", "")
            if name in ("__import__", "import_module") or (name == "print" and isinstance(called, ast.Name)):
                yield name, node.lineno


def find_cycles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """One cycle for every module that lies on one and comes first in it by name."""
    cycles = []
    for start in sorted(graph):
        trails = [[start]]
        seen = set()
        while trails:
            trail = trails.pop()
            for following in sorted(graph[trail[-1]]):
                if following == start:
                    cycles.append([*trail, start])
                    trails = []
                    break
                if following > start and following not in seen:
                    seen.add(following)
                    trails.append([*trail, following])
    return cycles


def test_the_source_keeps_to_its_layers():
    sources = read_sources("core", "addon")
    assert len(sources) > len(CORE_LAYERS)
    assert violations(sources) == []


def test_every_folder_has_its_place_in_the_order():
    folders = {path.split("/")[1] for path in read_sources("core") if path.count("/") > 1}
    assert folders <= set(CORE_LAYERS)
    rooms = {path.split("/")[1].removesuffix(".py") for path in read_sources("addon")} - {"__init__"}
    assert rooms == set(ADDON_ROOMS)


def test_all_of_core_loads_where_there_is_nothing_but_numpy_and_scipy(tmp_path):
    packages = Path(numpy.__file__).parents[1]
    for found in [*packages.glob("numpy*"), *packages.glob("scipy*")]:
        (tmp_path / found.name).symlink_to(found)
    modules = sorted(module_name(path) for path in read_sources("core"))
    # -S: without the folder of all installed packages.
    command = [sys.executable, "-S", "-c", "import " + ", ".join(modules)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    result = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr


def test_blender_stays_in_addon():
    """The root package is imported by tools without Blender; its imports stand inside its functions."""
    top_level = ast.parse((ROOT / "__init__.py").read_text("utf-8")).body
    assert not [node for node in top_level if isinstance(node, ast.Import | ast.ImportFrom)]


@pytest.mark.parametrize(
    ("path", "source", "expected"),
    [
        ("core/motion/clip.py", "import bpy", "core knows the standard library"),
        ("core/motion/clip.py", "def f():\n    import bpy.types as t", "core knows the standard library"),
        ("core/motion/clip.py", "from mathutils import Vector", "core knows the standard library"),
        ("core/motion/clip.py", "import bl_math", "core knows the standard library"),
        ("core/motion/clip.py", "import networkx", "core knows the standard library"),
        ("core/motion/clip.py", "from ...addon import bridge", "core must not know addon"),
        ("core/errors.py", "from .. import addon", "core must not know addon"),
        ("core/motion/clip.py", "from ..playback import walk", "motion lies below playback"),
        ("core/motion/clip.py", "from .. import playback", "motion lies below playback"),
        ("core/motion/__init__.py", "from ..tuning.pruning import prune", "motion lies below tuning"),
        ("core/evaluation/reach.py", "from core.tuning import pruning", "evaluation lies below tuning"),
        ("core/playback/walk.py", "import core.motion", "not relatively"),
        ("core/errors.py", "from .motion import clip", "core.errors lies below all folders"),
        ("core/motion/clip.py", "if True:\n    print('x')", "calls print"),
        ("core/motion/clip.py", "import importlib\nimportlib.import_module('bpy')", "calls import_module"),
        ("core/motion/clip.py", "__import__('bpy')", "calls __import__"),
        ("core/motion/utils.py", "", "name the file after the concept"),
        ("addon/bridge/helpers.py", "", "name the file after the concept"),
        (
            "addon/bridge/read_scene.py",
            "from ..operators import embed",
            "bridge lies below operators",
        ),
        ("addon/bridge/read_scene.py", "from .. import ui", "bridge lies below ui"),
        ("addon/ui/panels.py", "from ...core.embedding import embed", "addon.ui must not know core.embedding"),
        ("addon/scene/inputs.py", "def f():\n    from ..results.store import results", "scene lies below results"),
        ("addon/scene/inputs.py", "from ...tools import demo", "addon must not know tools"),
        ("addon/results/store.py", "from core import errors", "not relatively"),
    ],
)
def test_checker_finds(path, source, expected):
    layers = {f"core/{layer}/__init__.py": "" for layer in CORE_LAYERS}
    surroundings = {"core/__init__.py": "", "addon/__init__.py": "", "addon/ui/__init__.py": "", **layers}
    found = violations({**surroundings, path: source})
    assert len([sentence for sentence in found if expected in sentence]) == 1, found


def test_checker_finds_cycles():
    cycle = {
        "core/motion/__init__.py": "",
        "core/motion/a.py": "from .b import f",
        "core/motion/b.py": "def f():\n    from . import c",
        "core/motion/c.py": "from ..motion.a import g",
    }
    assert violations(cycle) == ["import cycle: core.motion.a -> core.motion.b -> core.motion.c -> core.motion.a"]
    through_package = {"core/motion/__init__.py": "from .a import f", "core/motion/a.py": "from . import f"}
    assert violations(through_package) == ["import cycle: core.motion -> core.motion.a -> core.motion"]


def test_checker_accepts_what_is_right():
    sources = {
        "core/__init__.py": "",
        "core/errors.py": "",
        "core/motion/__init__.py": "from .clip import MotionClip",
        "core/motion/clip.py": "import math, numpy as np\nfrom scipy import spatial\nfrom ..errors import E",
        "core/playback/walk.py": "from ..motion.clip import A\nfrom ..motion import B\nfrom .. import errors",
        "addon/__init__.py": "import bpy\nfrom . import ui, bridge",
        "addon/ui/__init__.py": "import bpy\nfrom ..results.store import current\nfrom ...core.maps.legend import L",
        "addon/bridge/__init__.py": "from ...core.motion import MotionClip",
        "addon/results/store.py": "from ..core.motion.clip import MotionClip",
    }
    assert violations(sources) == []
