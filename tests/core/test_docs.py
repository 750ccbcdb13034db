"""What the documentation says is so: links lead somewhere, commands exist, labels and messages are in the code."""

import ast
import re
import tomllib
from functools import cache
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

import dev
from core.embedding.component import EXPLICIT_LINKS
from core.embedding.footprint import STANDING_LENGTH, FootprintSettings
from core.embedding.settings import EmbeddingSettings
from core.evaluation.ablation import COLLAPSED_SHARE, IMPORTANT_FLOOR, IMPORTANT_PLACES, SPARE_SHARE
from core.evaluation.geodesic import REACH
from core.evaluation.weak_spots import WeakSpotSettings
from core.evaluation.why_not import REASON_LABELS, Reason
from core.motion.contacts import ContactSettings
from core.motion.distance import CostSettings
from core.motion.doctor import FindingKind
from core.motion.graph_settings import MotionGraphSettings
from core.playback import near_cheapest, spikes, wandering
from core.playback.cheapest import BEAM
from core.playback.cleanup import CleanupSettings
from core.playback.crowd import CrowdSettings
from core.playback.curve import CurveSettings
from core.playback.directed import LEAST_TIME
from core.playback.loop import HOMEWARD
from core.playback.pace import IDLE_SPEED, SPEED_TIME, TURN_ANGLE, TURN_TIME
from core.playback.prices import EDIT_LENGTH, HEADING_LEVER, PriceSettings
from core.playback.styles import WalkRequest
from core.playback.synthesis import SynthesisSettings
from core.study.plan import read_plan

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
GUIDE, METHOD = ROOT / "docs" / "guide.md", ROOT / "docs" / "method.md"
# Pages in which bold words are labels of the interface, as the guide says.
LABELLED = (GUIDE, ROOT / "README.md")
HOLE = "\0"
"""Stands where a message has a name or a number."""


def page_id(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def prose(page: Path) -> str:
    """A page without what is code: fenced and indented blocks, and spans between backticks."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "", text)


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as Git hosts make them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), re.MULTILINE)
    plain = [re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading)).strip().lower() for heading in headings]
    return {heading.replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("page", PAGES, ids=page_id)
def test_links_lead_somewhere(page):
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = unquote(target).partition("#")
        linked = page if not path else page.parent / path
        if not linked.exists() or (anchor and anchor not in anchors(linked)):
            broken.append(target)
    assert not broken


@pytest.mark.parametrize("page", PAGES, ids=page_id)
def test_commands_exist(page):
    commands = set(re.findall(r"^  (\w+)", dev.HELP, re.MULTILINE))
    named = set(re.findall(r"python3 dev\.py (\w+)", page.read_text("utf-8")))
    assert commands >= {"demo", "test"} and named <= commands


def test_the_changelog_is_of_this_version():
    version = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))["version"]
    latest = (ROOT / "CHANGELOG.md").read_text("utf-8").split("\n## ")[1]
    assert re.search(rf"\b{re.escape(version)}\b", latest)


def test_the_changelog_tells_all_commands():
    tree = dict(sources("addon"))["addon/cli/command.py"]
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    added = [node for node in calls if getattr(node.func, "attr", "") == "add_parser"]
    told = re.findall(r"--command wayfarer ([\w|]+)", (ROOT / "CHANGELOG.md").read_text("utf-8"))
    assert added and {ast.literal_eval(node.args[0]) for node in added} == set(told[0].split("|"))


@cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text("utf-8"))


def sources(*folders: str) -> list[tuple[str, ast.Module]]:
    """Path from the root (with slashes) and syntax tree of every Python file in the folders."""
    files = sorted(file for folder in folders for file in (ROOT / folder).rglob("*.py"))
    return [(file.relative_to(ROOT).as_posix(), parsed(file)) for file in files]


def template(node: ast.AST) -> str | None:
    """A string of the source, with a hole for whatever is filled in; None for anything else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else HOLE for part in node.values)
    return None


@cache
def strings(*folders: str) -> frozenset[str]:
    """Every string in the sources of some folders that is no docstring."""
    found = set()
    for _, tree in sources(*folders):
        docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            text = template(node)
            if text is not None and id(node) not in docstrings:
                found.add(text)
    return frozenset(found)


@pytest.mark.parametrize("page", LABELLED, ids=page_id)
def test_labels_are_those_of_the_interface(page):
    quoted = {" ".join(label.split()) for label in re.findall(r"\*\*(.+?)\*\*", prose(page), re.DOTALL)}
    unknown = sorted(quoted - strings("addon", "core"))
    assert len(quoted) > 3
    assert not unknown, f"no label of the interface: {unknown}"


def table_rows(page: Path, heading: str) -> list[list[str]]:
    """The cells of all tables under a heading, up to the next one of the same level."""
    text = page.read_text("utf-8").partition(f"\n{heading}\n")[2]
    text = re.split(rf"^{'#' * heading.count('#')} ", text, maxsplit=1, flags=re.MULTILINE)[0]
    rows = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in text.split("\n") if line[:1] == "|"]
    return [row for row in rows if not set(row[0]) <= set("-| ")]


def test_messages_are_those_of_the_code():
    known = [" ".join(text.split()) for text in strings("addon", "core")]
    messages = [row[0] for row in table_rows(GUIDE, "## Troubleshooting") if row[0] != "message"]
    strange = [message for message in messages if not any(message.replace("…", HOLE) in text for text in known)]
    assert len(messages) > 20
    assert not strange, f"no message of the code: {strange}"


def test_every_finding_is_explained():
    explained = {row[0] for row in table_rows(GUIDE, "### Health")}
    in_one_armature = set(FindingKind) - {FindingKind.OTHER_SKELETON, FindingKind.OTHER_PROPORTIONS}
    assert {kind.value.title() for kind in in_one_armature} <= explained


def test_every_reason_is_explained():
    explained, labels = {row[0] for row in table_rows(GUIDE, "## Maps")}, REASON_LABELS.values()
    # All but that of places that can be reached.
    assert len(labels) == len(Reason) and set(labels) - explained == {"Can Go Here"}


def test_every_map_is_explained():
    kinds = [
        {keyword.arg: getattr(keyword.value, "value", None) for keyword in node.keywords}
        for path, tree in sources("core/maps")
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "FloorMap"
    ]
    explained = {row[0].strip("*") for row in table_rows(GUIDE, "## Maps")}
    assert len(kinds) > 5 and {kind["label"] for kind in kinds} <= explained


def test_the_study_can_be_read(tmp_path):
    block = re.search(r"(?:^ {4}.*\n|^\n)*^ {4}title = .*\n(?:^ {4}.*\n|^\n)*", GUIDE.read_text("utf-8"), re.MULTILINE)
    assert block is not None
    file = tmp_path / "study.toml"
    file.write_text(re.sub(r"^ {4}", "", block.group(), flags=re.MULTILINE), "utf-8")
    plan = read_plan(file)
    assert len(list(plan.cases())) == 2 * 2 * 3 * 3 and len(plan.measures) == 4


def test_the_method_states_the_defaults():
    graph, cost, contacts = MotionGraphSettings(), CostSettings(), ContactSettings()
    footprint, synthesis, cleanup = FootprintSettings(), SynthesisSettings(), CleanupSettings()
    prices = PriceSettings()
    assert (cost.height_weight, cost.travel_weight, footprint.position_base, footprint.heading_base) == (1, 0.5, 0, 0)
    assert COLLAPSED_SHARE == 0.5
    stated = (
        f"({graph.frame_rate:g} per second unless set otherwise",
        f" = {cost.velocity_weight} s².",
        f"+ {cost.turn_weight}² (θ'_i",
        f"lower than {contacts.height} m above its floor *and* slower than {contacts.speed} m/s",
        f"higher than {contacts.release_height} m *or* faster than {contacts.release_speed} m/s",
        f"from {graph.n_starts} starts",
        f"b = {footprint.position_rate})",
        f"β = {footprint.heading_rate} rad",
        f"travels less than {STANDING_LENGTH} m",
        f"at most {EXPLICIT_LINKS:,} links",
        f"the limit ({EmbeddingSettings().memory_limit / 1e9:g} GB)",
        f"Areas under {WeakSpotSettings().min_area} m²",
        f"{IMPORTANT_FLOOR:.0%} of the floor or more, or {IMPORTANT_PLACES:.0%} of the places",
        f"{SPARE_SHARE:.1%} or more of either",
        f"straight lines between the centres of cells up to {REACH} cells apart in x and y",
        f"drawn evenly from the covered floor within {wandering.FARTHEST:g} m",
        f"goes by within {wandering.NEAR:g} m of it",
        f"at most {wandering.MORE_SEGMENTS} segments more than the fewest",
        f"the {wandering.LOOK_AHEAD} cheapest segments that can follow",
        f"each segment up to {wandering.CHANCE:.0%}".replace("%", " %"),
        f"more than {wandering.DEAR / 1000:g} s for each second that it takes, another place is drawn, up to "
        f"{wandering.DRAWS}",
        f"the best of {near_cheapest.STARTS} random nodes",
        f"1 rad² of transition cost | {prices.cost:g} |",
        f"1 m of edit, with {HEADING_LEVER:g} m for each radian | {prices.edit:g} |",
        f"path ({EDIT_LENGTH:g} m or more), in times of {prices.noticeable_bend:g} m/m, squared | {prices.bend:g} |",
        f"by less than {IDLE_SPEED:g} m/s, over {SPEED_TIME:g} s | {prices.idle:g} |",
        f"beyond {np.degrees(prices.free_turn):g}° within {TURN_TIME:g} s | {prices.back:g} |",
        f"the same segment again | {prices.again:g} |",
        f"each spike of the clip itself (section 14) | {prices.rough:g} |",
        f"more than {spikes.BEYOND:g} times the {spikes.USUAL:g}th percentile",
        f"(at least {spikes.SMOOTH_KNEE:g} rad/s² and {spikes.SMOOTH_JOINT:g} rad/s³)",
        f"by more than {spikes.LURCH:g} m/s² over {spikes.LURCH_TIME:g} s",
        f"turns of more than {np.degrees(TURN_ANGLE):g}° within {TURN_TIME:g} s",
        f"0 to 1 (by default {WalkRequest.smoothness:g}): a second weighs",
        f"(at least {LEAST_TIME:g}), all other prices s",
        f"no wave holds more than {BEAM} nodes",
        f"no point but the first holds more than {CurveSettings().beam} nodes",
        f"for the last {HOMEWARD:g} s",
        f"times exp(-m / {near_cheapest.TOLERANCE / 1000:g})",
        f"and goes on for {near_cheapest.LOOK_AHEAD} more",
        f"follow the {near_cheapest.BEAM} links that promise most",
        f"and {CurveSettings().time_weight:g} m² for each second of the price",
        f"the way to plan again ({CrowdSettings().repairs} times)",
        f"over a window of {synthesis.blend_duration} s",
        f"at most {synthesis.root_tolerance} m near a transition",
        f"in the {cleanup.window} s before and after",
        f"more than {cleanup.max_shift} m is taken for two",
        f"by {cleanup.max_drop} m at the most",
    )
    page = " ".join(METHOD.read_text("utf-8").split())
    missing = [sentence for sentence in stated if " ".join(sentence.split()) not in page]
    assert not missing, f"not on the page: {missing}"
