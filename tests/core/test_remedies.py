"""What an error tells to change exists, under the label that the interface gives it."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HOLE = "\0"
"""Stands where a sentence has a name or a number."""
NUMERIC = {"FloatProperty", "IntProperty"}
REPORTS = {"report", "poll_message_set", "append", "draw_sentences"}

# Words with a capital inside a sentence that are nobody's label.
NAMES = {
    "Action Editor",
    "BVH",
    "Blender",
    "Connected",
    "Ctrl-C",
    "Edit Mode",
    "Esc",
    "Image Editor",
    "Library Override",
    "NLA",
    "Object Mode",
    "Parquet",
    "Pollard",
    "Reitsma",
    "Scale",
    "T-pose",
    "T-poses",
    "Wayfarer",
}
COMPARATIVES = "fewer|larger|less|longer|lower|more|raise|shorten|shorter|smaller|wider|higher|another|allow"


def sources() -> list[ast.Module]:
    files = sorted(file for folder in ("core", "addon") for file in (ROOT / folder).rglob("*.py"))
    return [ast.parse(file.read_text("utf-8")) for file in files if "reproduce" not in str(file)]


def called(node: ast.Call) -> str:
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


@cache
def labels() -> tuple[frozenset[str], frozenset[str]]:
    """All labels of the interface (settings, choices, buttons, panels), and those of settings that are numbers."""
    every, numbers = set(), set()
    for tree in sources():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and called(node).endswith("Property"):
                for keyword in node.keywords:
                    if keyword.arg == "name" and isinstance(keyword.value, ast.Constant):
                        every.add(keyword.value.value)
                        if called(node) in NUMERIC:
                            numbers.add(keyword.value.value)
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "bl_label":
                every.add(ast.literal_eval(node.value))
            # The choices of a setting, and the labels of maps.
            if isinstance(node, ast.Tuple) and len(node.elts) in (2, 3) and isinstance(node.elts[-2], ast.Constant):
                every.add(str(node.elts[-2].value))
            if isinstance(node, ast.keyword) and node.arg == "label" and isinstance(node.value, ast.Constant):
                every.add(str(node.value.value))
    return frozenset(every), frozenset(numbers)


def texts(node: ast.AST) -> list[str]:
    """The strings that an argument can be, with holes for what is filled in."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, ast.JoinedStr):
        return ["".join(part.value if isinstance(part, ast.Constant) else HOLE for part in node.values)]
    if isinstance(node, ast.IfExp):
        return [*texts(node.body), *texts(node.orelse)]
    if isinstance(node, ast.List | ast.Tuple):
        return [text for element in node.elts for text in texts(element)]
    return []


@cache
def sentences() -> frozenset[str]:
    """What errors, reports and disabled buttons say, and what functions return for them."""
    found = set()
    for tree in sources():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and (called(node).endswith("Error") or called(node) in REPORTS):
                found.update(text for argument in node.args for text in texts(argument))
            # Sentences that are made elsewhere: advice, reasons, remedies in common.
            if isinstance(node, ast.Return | ast.Assign) and node.value is not None:
                found.update(text for text in texts(node.value) if re.search(r"[a-z][;.] ?\S* \S+", text))
    return frozenset(text for text in found if " " in text and "\n" not in text)


def named(sentence: str) -> tuple[set[str], set[str]]:
    """The labels that a sentence names, and its other words with capitals that do not begin a sentence."""
    plain = re.sub(r"'[^']*'|--\S+|\b[A-Z_]{4,}\b", HOLE, sentence)
    found = set()
    for label in sorted(labels()[0] | NAMES, key=len, reverse=True):
        if label[:1].isupper() and label in plain:
            plain, count = re.subn(rf"\b{re.escape(label)}\b", HOLE, plain)
            found |= {label} if count else set()
    return found, set(re.findall(r"(?<=[a-z,;(] )[A-Z][\w-]*", plain))


def test_settings_that_remedies_name_exist():
    found = {sentence: named(sentence) for sentence in sentences()}
    assert {"Cell Size", "Max Cost", "Min Segment", "Spacing", "Walkers"} <= set().union(
        *(f for f, _ in found.values())
    )
    assert {sentence: strange for sentence, (_, strange) in found.items() if strange} == {}


def test_settings_are_named_as_the_interface_labels_them():
    numbers = {label.lower(): label for label in labels()[1]}
    assert len(numbers) > 50 and "cell size" in numbers
    wrong = []
    for sentence in sentences():
        for words in re.findall(rf"\b(?:{COMPARATIVES}) ([a-z]+(?: [a-z]+)?)", sentence):
            wrong += [(sentence, numbers[w]) for w in (words, words.split()[0]) if w in numbers]
    assert wrong == []
