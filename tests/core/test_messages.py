"""Sentences for people are Wayfarer's own: no exception of Python, of the system or of Blender is quoted in one."""

import ast
import inspect
from pathlib import Path

import pytest

from core import errors

ROOT = Path(__file__).parents[2]
SOURCES = sorted(path for folder in ("core", "addon") for path in (ROOT / folder).rglob("*.py"))

#: Exceptions whose text is written here: those of core/errors.py and their like in the addon, and what stands for them.
OWN = {name for name, kind in inspect.getmembers(errors, inspect.isclass) if issubclass(kind, errors.MotionGraphError)}
OWN |= {"FileError", "Ended"}

#: What makes text of an exception, and the parts of one that are text.
TEXTS, PARTS = {"str", "repr", "format"}, {"strerror", "args", "msg"}


#: Functions that may read a foreign exception's text, and why.
READERS = {"core/study/plan.py:_place": "takes the number of a line from it, and no word"}


def is_own(kind: ast.expr | None) -> bool:
    """True if an except clause, or an annotation, speaks of exceptions of ours alone."""
    if isinstance(kind, ast.Tuple):
        return all(is_own(one) for one in kind.elts)
    if isinstance(kind, ast.Attribute):  # the error of a format, see core/archive.py
        return kind.attr in {"error", *OWN}
    return isinstance(kind, ast.Name) and kind.id in OWN


def quoting(path: Path) -> list[str]:
    """Return the places that put a foreign exception, or a part of one, into text."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ExceptHandler) and node.name and not is_own(node.type):
            found += places(path, node, node.name)
        if isinstance(node, ast.FunctionDef) and f"{path.relative_to(ROOT).as_posix()}:{node.name}" not in READERS:
            for argument in node.args.args:
                words = ast.unparse(argument.annotation).split() if argument.annotation else []
                if any(word.endswith(("Error", "Exception")) and word not in OWN for word in words):
                    found += places(path, node, argument.arg)
    return found


def places(path: Path, scope: ast.AST, name: str) -> list[str]:
    """Return where the exception of this name is made text within ``scope``, where that is not known to be ours."""
    found = []
    guarded = {
        id(part)
        for test in ast.walk(scope)
        if isinstance(test, (ast.If, ast.IfExp)) and asks_for_own(test.test, name)
        for body in (test.body if isinstance(test.body, list) else [test.body])
        for part in ast.walk(body)
    }
    for node in ast.walk(scope):
        if id(node) in guarded:
            continue
        texts = []
        called = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        if isinstance(node, ast.FormattedValue):
            texts = [node.value]
        elif isinstance(node, ast.Call) and called in TEXTS:
            texts = node.args
        elif isinstance(node, ast.Attribute) and node.attr in PARTS:
            texts = [node]
        elif isinstance(node, ast.Call) and called == "getattr" and ast.literal_eval(node.args[1]) in PARTS:
            texts = node.args[:1]
        found += [f"{path.relative_to(ROOT)}:{node.lineno}" for text in texts if speaks_of(text, name)]
    return found


def asks_for_own(test: ast.expr, name: str) -> bool:
    return (
        isinstance(test, ast.Call)
        and isinstance(test.func, ast.Name)
        and test.func.id == "isinstance"
        and ast.unparse(test.args[0]) == name
        and is_own(test.args[1])
    )


def speaks_of(text: ast.expr, name: str) -> bool:
    """True if the value of an expression is, or holds, the exception itself."""
    if isinstance(text, ast.Call) and isinstance(text.func, ast.Name) and text.func.id not in TEXTS:
        return False  # what it is handed to is looked at by itself
    if isinstance(text, ast.Attribute) and text.attr in {"filename", "errno"}:
        return False
    if isinstance(text, ast.Name):
        return text.id == name
    return any(speaks_of(part, name) for part in ast.iter_child_nodes(text) if isinstance(part, ast.expr))


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_sentence_quotes_a_foreign_exception(path):
    assert sorted(set(quoting(path))) == []
