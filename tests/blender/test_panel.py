"""What the tab in the sidebar consists of, and how it is worded. That it draws is seen in a real window only."""

from functools import cache

import blf
import bpy
import pytest

from bl_ext.user_default.wayfarer.addon import properties
from bl_ext.user_default.wayfarer.addon.bridge import units
from bl_ext.user_default.wayfarer.addon.operators import CLASSES as OPERATORS
from bl_ext.user_default.wayfarer.addon.results import store
from bl_ext.user_default.wayfarer.addon.ui import drawing, lists
from bl_ext.user_default.wayfarer.addon.ui.panels import PANELS
from bl_ext.user_default.wayfarer.core.environment.environment import EnvironmentSettings
from bl_ext.user_default.wayfarer.core.environment.regions import RegionRule
from bl_ext.user_default.wayfarer.core.motion.contacts import ContactSettings
from bl_ext.user_default.wayfarer.core.motion.graph_settings import MotionGraphSettings, ThresholdMode

GROUPS = properties.CLASSES
SMALL_WORDS = {"a", "an", "and", "as", "at", "for", "from", "in", "of", "or", "the", "to"}


def own_properties():
    for group in GROUPS:
        for name, prop in group.bl_rna.properties.items():
            if name not in ("rna_type", "name"):
                yield f"{group.__name__}.{name}", prop


def is_title_case(text: str) -> bool:
    words = text.replace("-", " ").split()
    return all(word[0].isupper() or word[0].isdigit() or word in SMALL_WORDS for word in words)


def test_panels_follow_the_workflow():
    top = [panel for panel in PANELS if not hasattr(panel, "bl_parent_id")]
    assert [panel.bl_label for panel in top] == [
        "Clips",
        "Motion Graph",
        "Environment",
        "Embedding",
        "Map",
        "Evaluation",
        "Tuning",
        "Queries",
        "Walk",
    ]
    for panel in top:
        assert (panel.bl_space_type, panel.bl_region_type, panel.bl_category) == ("VIEW_3D", "UI", "Wayfarer")


def draw(panel) -> "Layout":
    """Drawn with a stand-in for the layout, because nothing is drawn without a window."""
    layout = Layout()
    of_step = {
        name: getattr(panel, name)
        for name in ("result_is_there", "result_is_stale", "presets", "topic")
        if hasattr(panel, name)
    }
    instance = type("Drawn", (), {"layout": layout, "is_popover": False, **of_step})()
    bases = [base for base in panel.__mro__ if base is panel or base.__name__ in ("Step", "FindingPart", "TopicPart")]
    for name in ("draw_header", "draw_header_preset", "draw"):
        if any(name in vars(base) for base in bases):
            getattr(panel, name)(instance, bpy.context)
    return layout


@cache
def icon_names() -> set[str]:
    return set(bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys())


@cache
def options_of(operator: str) -> set[str]:
    """Names of an operator's options; it fails if there is no such operator."""
    module, name = operator.split(".")
    assert name in dir(getattr(bpy.ops, module))
    return set(getattr(getattr(bpy.ops, module), name).get_rna_type().properties.keys())


def check(layout: "Layout") -> None:
    """Everything that is drawn exists, and buttons are given what they know."""
    assert layout.drawn
    for kind, *what in layout.drawn:
        if kind == "prop":
            data, name = what
            assert name in data.bl_rna.properties, name
        elif kind == "operator":
            assert set(what[1]) <= options_of(what[0])
        elif kind == "icon":
            assert what[0] in icon_names()


def texts(layout: "Layout") -> list[str]:
    return [what[0] for kind, *what in layout.drawn if kind == "text"]


@pytest.mark.parametrize("panel", PANELS, ids=lambda panel: panel.__name__)
def test_panels_draw_what_exists_before_anything_is_done(panel):
    bpy.ops.wayfarer.add_sample_room()
    if not hasattr(panel, "poll") or panel.poll(bpy.context):
        check(draw(panel))


def finish(settings):
    """Everything done that there is to do."""
    operators = bpy.ops.wayfarer
    # One clip shorter than a segment, so that there is a finding.
    clip = next(clip for clip in settings.clips if clip.use)
    clip.action.use_frame_range, clip.action.frame_start, clip.action.frame_end = True, 1, 12
    quantity, settings.tuning.k = settings.map.quantity, 20
    for step in ("build_motion_graph", "embed", "find_reach"):
        assert getattr(operators, step)() == {"FINISHED"}
    settings.map.quantity = quantity
    for step in (
        "examine_clips",
        "show_contacts",
        "guess_weights",
        "build_motion_graph",
        "embed",
        "prune",
        "count_lost_links",
        "paint_map",
        "measure",
        "find_weak_spots",
        "ablate",
        "find_deletable",
        "direct_capture",
        "find_occupancy",
        "sweep_pruning",
        "random_walk",
    ):
        assert getattr(operators, step)() == {"FINISHED"}


def test_panels_draw_what_exists_when_all_is_done(sample_settings):
    settings = sample_settings
    settings.graph.use_custom_weights = True
    settings.map.quantity = "WHY_NOT"
    finish(settings)
    report = settings.walk.report
    report.active_worst = 0
    drawn = {}
    modes = [(mode, "OBJECT") for mode in ("COST", "LINKS", "COVERAGE")]
    for mode, source in [*modes, ("COST", "BOUNDS"), ("COST", "TYPED")]:
        settings.graph.threshold_mode, settings.environment.ground_source = mode, source
        for panel in PANELS:
            assert not hasattr(panel, "poll") or panel.poll(bpy.context), panel
            check(drawn.setdefault((panel.__name__, mode, source), draw(panel)))

    def properties_of(panel, mode="COST", source="OBJECT"):
        return {what[1] for kind, *what in drawn[panel, mode, source].drawn if kind == "prop"}

    assert "max_links" in properties_of("WAYFARER_PT_motion_graph", mode="LINKS")
    assert "min_coverage" in properties_of("WAYFARER_PT_motion_graph", mode="COVERAGE")
    assert not {"max_links", "min_coverage"} & properties_of("WAYFARER_PT_motion_graph")
    assert "ground" in properties_of("WAYFARER_PT_environment")
    typed = {"ground_low", "ground_high", "ground_height"}
    assert typed <= properties_of("WAYFARER_PT_environment", source="TYPED")
    assert not (typed | {"ground"}) & properties_of("WAYFARER_PT_environment", source="BOUNDS")

    health = drawn["WAYFARER_PT_health", "COST", "OBJECT"]
    assert "Too Short" in texts(health)
    assert (
        "operator",
        "wayfarer.apply_remedy",
        {"action": settings.active_action().name, "finding": 0},
    ) in health.drawn
    legend = texts(drawn["WAYFARER_PT_map", "COST", "OBJECT"])
    assert "Can Go Here" in legend and sum(text.endswith("%") for text in legend) >= 3
    assert "Lost to Obstacles" in texts(drawn["WAYFARER_PT_lost_links", "COST", "OBJECT"])
    assert "Left Planted" in texts(drawn["WAYFARER_PT_contacts", "COST", "OBJECT"])
    graph = store.results(bpy.context.scene).graph
    dropped = texts(drawn["WAYFARER_PT_dropped", "COST", "OBJECT"])
    assert {clip.clip for clip in graph.dropped} & set(dropped)
    # Wrapped, not cut off.
    reason = graph.dropped[0].reason
    assert reason[:1].upper() + reason[1:] in " ".join(dropped) and not any(reason in text for text in dropped)
    chosen = report.worst[report.active_worst]
    told = " ".join(texts(drawn["WAYFARER_PT_walk_quality", "COST", "OBJECT"]))
    assert f"Frame {chosen.frame}: {chosen.what}, {chosen.amount}" in told
    hubs = texts(drawn["WAYFARER_PT_hubs", "COST", "OBJECT"])
    assert {segment.name for segment in graph.segments} & set(hubs)


def test_lists_draw_what_exists(sample_settings):
    finish(sample_settings)
    settings = sample_settings
    for kind, name in (("clips", "clips"), ("joint_weights", "joint_weights")):
        data = settings if kind == "clips" else settings.graph
        layout = Layout()
        drawing = getattr(lists, f"WAYFARER_UL_{kind}").draw_item
        for index, item in enumerate(getattr(data, name)):
            drawing(None, bpy.context, layout, data, item, 0, None, "", index)
        check(layout)
        if kind == "clips":
            icons = [what[0] for drawn, *what in layout.drawn if drawn == "icon"]
            used = sum(clip.use for clip in settings.clips)
            assert icons.count("ERROR") == 1 and icons.count("CHECKMARK") == used - 1
            chosen = [what[1]["clip"] for drawn, *what in layout.drawn if drawn == "operator"]
            assert chosen == [i for i, clip in enumerate(settings.clips) if clip.use]


@pytest.mark.parametrize("width", [40, 120, 400])
def test_sentences_are_wrapped(width):
    sentence = "Clip 'walk' pops at frames 12-13: bones 'LeftUpLeg' and 'LeftLeg' jump; split it into frames 1-11."
    lines = drawing.wrapped(sentence, width, 11)
    assert " ".join(lines) == sentence
    blf.size(0, 11)
    assert all(blf.dimensions(0, line)[0] <= width or " " not in line for line in lines)
    assert len(lines) <= 3 * blf.dimensions(0, sentence)[0] / width + 2


class Layout:
    """Notes what is drawn; every part of the layout is this one object."""

    def __init__(self):
        self.drawn = []

    def __getattr__(self, name):
        def note(*arguments, **options):
            if name in ("prop", "prop_search"):
                self.drawn.append(("prop", *arguments[:2]))
            if name == "prop_search":
                self.drawn.append(("prop", *arguments[2:4]))
            elif name == "template_list":
                self.drawn.append(("prop", *arguments[2:4]))
                assert hasattr(bpy.types, arguments[0])
            if "icon" in options:
                self.drawn.append(("icon", options["icon"]))
            if "text" in options:
                self.drawn.append(("text", options["text"]))
            if name == "operator":
                given = {}
                self.drawn.append(("operator", arguments[0], given))
                return Given(given)
            return self

        return note


class Given:
    """Notes the properties that a button is given."""

    def __init__(self, given):
        object.__setattr__(self, "given", given)

    def __setattr__(self, name, value):
        self.given[name] = value


def test_every_property_explains_itself():
    for name, prop in own_properties():
        if prop.type in ("POINTER", "COLLECTION") and prop.fixed_type.identifier.startswith("Wayfarer"):
            continue
        assert prop.description and not prop.description.endswith("."), name
        assert is_title_case(prop.name), name


def test_every_operator_explains_itself():
    for operator in OPERATORS:
        assert operator.bl_idname.startswith("wayfarer.")
        assert is_title_case(operator.bl_label)
        assert operator.bl_description and not operator.bl_description.endswith(".")
        assert {"REGISTER", "UNDO"} <= operator.bl_options


def test_lengths_angles_and_times_have_units():
    units = dict(own_properties())
    for name in ("cell_size", "radius", "step_height", "head_height", "ground_low", "ground_high", "ground_height"):
        assert units[f"WayfarerEnvironmentSettings.{name}"].unit == "LENGTH"
    for name in ("height", "release_height"):
        assert units[f"WayfarerContactSettings.{name}"].unit == "LENGTH"
    for name in ("speed", "release_speed"):
        assert units[f"WayfarerContactSettings.{name}"].unit == "VELOCITY"
    assert units["WayfarerRegion.margin"].unit == "LENGTH"
    assert units["WayfarerEmbeddingSettings.heading_rate"].unit == "ROTATION"
    assert units["WayfarerGraphSettings.min_segment_duration"].unit == "TIME_ABSOLUTE"
    assert units["WayfarerWalkSettings.duration"].unit == "TIME_ABSOLUTE"


def test_edits_are_told_for_each_metre():
    settings = bpy.context.scene.wayfarer.embedding
    assert settings.bl_rna.properties["position_rate"].subtype == "FACTOR"
    settings.position_rate, settings.heading_rate = 0.08, 0.1
    panel = next(panel for panel in PANELS if panel.bl_label == "Embedding")
    assert {"8.00 cm per m", "5.7° per m"} <= set(texts(draw(panel)))


@pytest.mark.parametrize(("system", "told"), [("METRIC", "1.20 m"), ("NONE", "1.20 m"), ("IMPERIAL", "3.94'")])
def test_panels_tell_lengths_in_the_units_of_the_scene(system, told):
    scene = bpy.context.scene
    # A unit is a metre, whatever its scale.
    scene.unit_settings.system, scene.unit_settings.scale_length = system, 0.01
    crowd = scene.wayfarer.walk.crowd
    crowd.n_walking, crowd.n_wanted, crowd.closest = 2, 3, 1.2
    panel = next(panel for panel in PANELS if panel.bl_label == "Crowd")
    assert [text for text in texts(draw(panel)) if text[:1].isdigit()] == ["2 of 3", told]


def test_slides_are_told_in_the_units_of_the_scene():
    scene = bpy.context.scene
    scene.unit_settings.system = "METRIC"
    assert units.scene_slide(scene, 0.0213) == "2.13 cm/s"
    scene.unit_settings.system = "IMPERIAL"
    assert units.scene_slide(scene, 0.3048) == "1 ft/s"


def test_defaults_are_the_cores():
    settings = bpy.context.scene.wayfarer
    built, wanted = settings.graph.to_core(), MotionGraphSettings()
    for name in ("frame_rate", "min_segment_duration", "max_cost", "max_links", "min_coverage"):
        assert getattr(settings.graph, name) == pytest.approx(getattr(wanted, name))
    for name in ("frame_rate", "min_segment_duration", "max_cost"):
        assert getattr(built, name) == pytest.approx(getattr(wanted, name))
    assert built.threshold_mode is wanted.threshold_mode and built.cost == wanted.cost
    modes = properties.motion_graph.WayfarerGraphSettings.bl_rna.properties["threshold_mode"].enum_items
    assert [item.identifier for item in modes] == [mode.name for mode in ThresholdMode]
    for name in ("height", "release_height", "speed", "release_speed"):
        assert getattr(settings.contacts, name) == pytest.approx(getattr(ContactSettings(), name))
    body, wanted = settings.environment.to_core(0.0), EnvironmentSettings()
    for name in ("radius", "step_height", "head_height", "ground_height"):
        assert getattr(body, name) == pytest.approx(getattr(wanted, name))
    rules = properties.environment.WayfarerRegion.bl_rna.properties["rule"].enum_items
    assert [item.identifier for item in rules] == [rule.name for rule in RegionRule]
