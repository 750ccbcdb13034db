"""The settings that a study may vary, by name."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

from .. import wording
from ..embedding.footprint import FootprintRule, FootprintSettings
from ..errors import StudyError
from ..motion.graph_settings import MotionGraphSettings, ThresholdMode

Value = bool | int | float | str


class Stage(Enum):
    """First result that a setting changes; what comes before it is not computed again for another value."""

    GRAPH = "motion graph"
    ENVIRONMENT = "environment"
    EMBEDDING = "embedding"
    TUNING = "tuning"
    SCALE = "scale"


@dataclass(frozen=True)
class Setting:
    """A setting of a study.

    Attributes
    ----------
    stage : Stage
    kind : type
        bool, int, float or str.
    meaning : str
        What it is, with its unit.
    """

    stage: Stage
    kind: type
    meaning: str


#: What the scenes and clip sets do not say otherwise is as in the settings' own defaults.
SETTINGS: dict[str, Setting] = {
    "max_cost": Setting(Stage.GRAPH, float, "threshold: cost up to which frames are linked (rad^2)"),
    "min_segment_duration": Setting(Stage.GRAPH, float, "shortest segment (s)"),
    "frame_rate": Setting(Stage.GRAPH, float, "samples per second"),
    "cell_size": Setting(Stage.ENVIRONMENT, float, "side of a grid cell (m)"),
    "n_headings": Setting(Stage.ENVIRONMENT, int, "headings of the grid"),
    "tiled": Setting(Stage.ENVIRONMENT, bool, "whether the ground repeats"),
    "radius": Setting(Stage.ENVIRONMENT, float, "distance to keep from obstacles (m)"),
    "step_height": Setting(Stage.ENVIRONMENT, float, "what is lower is walked on (m)"),
    "head_height": Setting(Stage.ENVIRONMENT, float, "what is higher is walked under (m)"),
    "footprint_rule": Setting(Stage.EMBEDDING, str, "snap or conservative"),
    "position_base": Setting(Stage.EMBEDDING, float, "edit of position allowed for every segment (m)"),
    "position_rate": Setting(Stage.EMBEDDING, float, "edit of position allowed for each metre (m/m)"),
    "heading_base": Setting(Stage.EMBEDDING, float, "edit of heading allowed for every segment (rad)"),
    "heading_rate": Setting(Stage.EMBEDDING, float, "edit of heading allowed for each metre (rad/m)"),
    "k": Setting(Stage.TUNING, int, "nodes kept at each position and heading; 0 keeps all"),
    "parcel_size": Setting(Stage.SCALE, float, "side of the parcels of a large ground (m); 0: in one piece"),
}


_LARGEST = 1e12
"""No number of any setting makes sense beyond it: so none that a float or an array cannot hold gets any further."""


def checked(name: str, value: object) -> Value:
    """Read a value for a setting; StudyError if there is no such setting, or it cannot have that value.

    >>> checked("radius", 1), checked("k", "all")
    (1.0, 0)
    """
    if name not in SETTINGS:
        raise StudyError(f"There is no setting {wording.quoted(name)}; there are {', '.join(SETTINGS)}.")
    setting = SETTINGS[name]
    if name == "k" and value == "all":
        return 0
    if setting.kind is bool and isinstance(value, bool):
        return value
    if setting.kind is str and name == "footprint_rule" and value in [rule.value for rule in FootprintRule]:
        return str(value)
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST:
        if setting.kind is int and value == int(value) and value >= 0:
            return int(value)
        if setting.kind is float and math.isfinite(value) and value >= 0:
            return float(value)
    raise StudyError(f"The setting '{name}' cannot be {wording.quoted(value)}; it is {setting.meaning}.")


def of_stage(values: Mapping[str, Value], *stages: Stage) -> dict[str, Value]:
    """Return those of the values whose settings belong to the stages."""
    return {name: value for name, value in values.items() if SETTINGS[name].stage in stages}


def graph_settings(base: MotionGraphSettings, values: Mapping[str, Value]) -> MotionGraphSettings:
    """Settings of a motion graph with the values of a case."""
    given: dict[str, object] = dict(of_stage(values, Stage.GRAPH))
    if "max_cost" in given:
        # Whoever names a threshold wants no other.
        given["threshold_mode"] = ThresholdMode.COST
    return replace(base, **given)


def footprint_settings(base: FootprintSettings, values: Mapping[str, Value]) -> FootprintSettings:
    """Footprints with the values of a case."""
    given: dict[str, object] = dict(of_stage(values, Stage.EMBEDDING))
    rule = given.pop("footprint_rule", base.rule.value)
    return replace(base, rule=FootprintRule(rule), **given)
