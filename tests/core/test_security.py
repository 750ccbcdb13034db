"""Nothing in a file, a setting or a name is ever executed, nothing leaves the machine: proved on the source."""

import ast
from pathlib import Path

import numpy as np
import pytest

from core.embedding.archive import load_embedding
from core.embedding.embedding import embed
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import MotionGraphError
from core.motion.graph_archive import load_motion_graph, save_motion_graph

from .motion_graphs import sample_graph

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ("core", "addon", "__init__.py")
# Modules that run programs, talk to the network, or turn bytes into code.
FORBIDDEN_MODULES = {
    *("pickle", "cPickle", "dill", "cloudpickle", "joblib", "shelve", "marshal", "code", "codeop", "runpy"),
    *("subprocess", "multiprocessing", "pty", "ctypes", "cffi"),
    *("socket", "socketserver", "ssl", "http", "urllib", "urllib3", "requests", "ftplib", "smtplib", "telnetlib"),
    *("xmlrpc", "webbrowser", "asyncio"),
}
FORBIDDEN_CALLS = {"eval", "exec", "compile", "__import__", "breakpoint", "input"}
FORBIDDEN_ATTRIBUTES = {
    *("os." + name for name in ("system", "popen", "startfile", "fork", "kill")),
    *("os." + start + end for start in ("exec", "spawn") for end in ("l", "le", "lp", "lpe", "v", "ve", "vp", "vpe")),
    *("bpy.ops.wm.url_open", "bpy.ops.script.python_file_run", "bpy.ops.text.run_script"),
    *("numpy.load", "np.load", "numpy.fromregex", "numpy.ctypeslib.load_library"),
}
# (file, what) -> why it is safe there.
EXCEPTIONS = {
    (
        "addon/cli/cluster.py",
        "multiprocessing",
    ): "workers on this machine, running our own function",
    ("addon/exports/report.py", "bpy.ops.wm.url_open"): "shows the page that was just written: a file",
    (
        "addon/cli/study.py",
        "subprocess",
    ): "starts this same Python on our own program, without a shell",
    ("core/files.py", "np.load"): "with allow_pickle=False, see the test below",
}


def sources() -> dict[str, ast.Module]:
    files = [
        file for name in SHIPPED for file in ([ROOT / name] if name.endswith(".py") else (ROOT / name).rglob("*.py"))
    ]
    return {file.relative_to(ROOT).as_posix(): ast.parse(file.read_text("utf-8")) for file in sorted(files)}


def dotted(node: ast.expr) -> str:
    """``a.b.c`` of an attribute or a name, empty for anything else."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        start = dotted(node.value)
        return f"{start}.{node.attr}" if start else ""
    return ""


def dangers(tree: ast.Module) -> set[str]:
    """What of the forbidden a file uses."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names} & FORBIDDEN_MODULES
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found |= {node.module.split(".")[0]} & FORBIDDEN_MODULES
            found |= {f"{node.module}.{alias.name}" for alias in node.names} & FORBIDDEN_ATTRIBUTES
        elif isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and node.func.id in FORBIDDEN_CALLS:
                found.add(node.func.id)
            if any(word.arg == "shell" for word in node.keywords):
                found.add("shell=")
            if any(word.arg == "allow_pickle" and not is_false(word.value) for word in node.keywords):
                found.add("allow_pickle")
        elif isinstance(node, ast.Attribute) and dotted(node) in FORBIDDEN_ATTRIBUTES:
            found.add(dotted(node))
    return found


def is_false(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is False


def test_nothing_is_executed_and_nothing_leaves_the_machine():
    found = {(path, danger) for path, tree in sources().items() for danger in dangers(tree)}
    assert found == set(EXCEPTIONS), "forbidden, or an exception that is no longer needed"


def test_arrays_are_read_without_pickle():
    n_found = 0
    for path, tree in sources().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and dotted(node.func) in (
                "np.load",
                "numpy.load",
                "np.lib.format.read_array",
            ):
                words = {word.arg: word.value for word in node.keywords}
                assert "allow_pickle" in words and is_false(words["allow_pickle"]), f"{path}, line {node.lineno}"
                n_found += 1
    assert n_found > 0


@pytest.mark.parametrize(
    ("source", "danger"),
    [
        ("import pickle", "pickle"),
        ("from urllib.request import urlopen", "urllib"),
        ("def f(x):\n    return eval(x)", "eval"),
        ("import os\nos.system('ls')", "os.system"),
        ("from os import system", "os.system"),
        ("run('ls', shell=True)", "shell="),
        ("np.load(path, allow_pickle=True)", "allow_pickle"),
        ("import bpy\nbpy.ops.wm.url_open(url='a')", "bpy.ops.wm.url_open"),
    ],
)
def test_would_see_each_of_them(source, danger):
    assert danger in dangers(ast.parse(source))


def test_the_manifest_asks_for_files_only():
    text = (ROOT / "blender_manifest.toml").read_text("utf-8")
    permissions = text[text.index("[permissions]") :].split("\n[")[0].splitlines()[1:]
    assert [line.split(" =")[0] for line in permissions if line and not line.startswith("#")] == ["files"]


class Explosive:
    """Would write a file if anybody unpickled it."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (Path.touch, (self.path,))


@pytest.mark.parametrize("load", [load_embedding, load_motion_graph])
def test_a_pickle_in_an_archive_is_refused_unread(load, tmp_path):
    marker = tmp_path / "executed"
    content = np.empty(1, dtype=object)
    content[0] = Explosive(marker)
    graph = sample_graph()
    save_motion_graph(graph, tmp_path / "graph.npz")
    with np.load(tmp_path / "graph.npz", allow_pickle=False) as archive:
        members = {name: archive[name] for name in archive.files}
    for victim in members:
        np.savez(tmp_path / "trap.npz", **{**members, victim: content})
        with pytest.raises(MotionGraphError):
            load(tmp_path / "trap.npz")
    assert not marker.exists()


@pytest.mark.parametrize("name", ["with spaces", "Größe", "動作", "emoji 🚶", 'quote\'s "here"', "dot.dot", "a" * 100])
def test_files_of_any_name(name, tmp_path):
    folder = tmp_path / name
    folder.mkdir()
    graph = sample_graph()
    save_motion_graph(graph, folder / f"{name}.npz")
    assert load_motion_graph(folder / f"{name}.npz").links.tolist() == graph.links.tolist()
    embedding = embed(graph, Environment(Grid((8, 8, 4), 0.5), np.zeros((32, 32), dtype=bool)))
    embedding.save(folder / f"e {name}.npz")
    assert load_embedding(folder / f"e {name}.npz").planes == embedding.planes
    assert sorted(path.name for path in folder.iterdir()) == sorted([f"{name}.npz", f"e {name}.npz"])
