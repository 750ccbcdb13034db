"""What the tab in the sidebar consists of, and how it is worded. That it draws is seen in a real window only."""

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon import properties
from bl_ext.user_default.wayfarer.addon.operators import _CLASSES as OPERATORS
from bl_ext.user_default.wayfarer.addon.ui.panels import PANELS
from bl_ext.user_default.wayfarer.core.environment.environment import EnvironmentSettings
from bl_ext.user_default.wayfarer.core.environment.regions import RegionRule
from bl_ext.user_default.wayfarer.core.motion.graph import MotionGraphSettings

GROUPS = properties._CLASSES
SMALL_WORDS = {"a", "an", "and", "as", "at", "for", "in", "of", "or", "the", "to"}


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
        "Walk",
    ]
    for panel in top:
        assert (panel.bl_space_type, panel.bl_region_type, panel.bl_category) == ("VIEW_3D", "UI", "Wayfarer")


@pytest.mark.parametrize("panel", PANELS, ids=lambda panel: panel.__name__)
def test_panels_use_what_exists(panel):
    """Drawn with a stand-in for the layout, because nothing is drawn without a window."""
    bpy.ops.wayfarer.add_sample_room()
    layout = Layout()
    instance = type("Drawn", (), {"layout": layout, "__getattr__": lambda self, name: getattr(panel, name)})()
    panel.draw(instance, bpy.context)
    assert layout.drawn
    for kind, *what in layout.drawn:
        if kind == "prop":
            data, name = what
            assert name in data.bl_rna.properties
        elif kind == "operator":
            module, name = what[0].split(".")
            assert name in dir(getattr(bpy.ops, module))
        elif kind == "icon":
            icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
            assert what[0] in icons.keys()  # noqa: SIM118 (an RNA collection, not a dict)


class Layout:
    """Notes what is drawn; every part of the layout is this one object."""

    def __init__(self):
        self.drawn = []

    def __getattr__(self, name):
        def note(*arguments, **options):
            if name == "prop":
                self.drawn.append(("prop", *arguments[:2]))
            elif name == "operator":
                self.drawn.append(("operator", arguments[0]))
            elif name == "template_list":
                self.drawn.append(("prop", *arguments[2:4]))
                assert hasattr(bpy.types, arguments[0])
            if "icon" in options:
                self.drawn.append(("icon", options["icon"]))
            return self

        return note


def test_every_property_explains_itself():
    for name, prop in own_properties():
        if prop.type in ("POINTER", "COLLECTION") and prop.fixed_type.identifier.startswith("Wayfarer"):
            continue
        if name.endswith((".active_clip", ".active_region")):
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
    for name in ("cell_size", "radius", "step_height", "head_height"):
        assert units[f"WayfarerEnvironmentSettings.{name}"].unit == "LENGTH"
    assert units["WayfarerRegion.margin"].unit == "LENGTH"
    assert units["WayfarerEmbeddingSettings.heading_rate"].unit == "ROTATION"
    assert units["WayfarerGraphSettings.min_segment_duration"].unit == "TIME_ABSOLUTE"
    assert units["WayfarerWalkSettings.duration"].unit == "TIME_ABSOLUTE"


def test_defaults_are_the_cores():
    settings = bpy.context.scene.wayfarer
    built, wanted = settings.graph.to_core(), MotionGraphSettings()
    for name in ("frame_rate", "min_segment_duration", "max_cost"):
        assert getattr(built, name) == pytest.approx(getattr(wanted, name))
    body, wanted = settings.environment.to_core(0.0), EnvironmentSettings()
    for name in ("radius", "step_height", "head_height", "ground_height"):
        assert getattr(body, name) == pytest.approx(getattr(wanted, name))
    rules = properties.WayfarerRegion.bl_rna.properties["rule"].enum_items
    assert [item.identifier for item in rules] == [rule.name for rule in RegionRule]
