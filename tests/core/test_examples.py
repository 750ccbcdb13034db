"""Docstrings: their examples run, and their first words say what is done or what a thing is."""

import ast
import doctest
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FEWEST_EXAMPLES = 30
"""Public functions and classes of the core that have an example, at least."""
NOT_YET = (
    "addon/bridge/bvh_file",
    "addon/bridge/import_bvh",
    "core/errors",
    "core/motion",
    "core/progress",
    "core/wording",
)
"""Folders and modules with docstrings that still begin with a word that they should not begin with."""


def sources(*folders: str) -> list[Path]:
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def examples() -> list[doctest.DocTest]:
    """Every docstring of the core with an example in it."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = []
    for path in sources("core"):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        if ">>>" in path.read_text("utf-8"):
            found += [test for test in finder.find(importlib.import_module(name), name) if test.examples]
    return found


EXAMPLES = examples()


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_an_example_runs(example):
    said: list[str] = []
    failed, tried = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(example, out=said.append)
    assert tried and not failed, "".join(said)


def test_public_functions_have_examples():
    public = [test.name for test in EXAMPLES if not re.search(r"\._", test.name)]
    assert len(public) >= FEWEST_EXAMPLES


def test_a_docstring_begins_with_a_verb_or_a_noun():
    places = []
    for path in sources("core", "addon", "tools"):
        name = path.relative_to(ROOT).with_suffix("").as_posix()
        if any(name == folder or name.startswith(folder + "/") for folder in NOT_YET):
            continue
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                words = ast.get_docstring(node) or ""
                if re.match(r"(What|Whether|Which|Where|Of|As|How)\b", words):
                    places.append(f"{name}.py:{getattr(node, 'lineno', 1)}: {words.splitlines()[0]}")
    assert not places, "\n".join(places)
