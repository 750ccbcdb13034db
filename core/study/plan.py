"""The file that describes a study, in TOML::

    title = "Three levels"
    measures = ["coverage", "links", "path_efficiency",
                {measure = "time_to_reach", name = "to the door", position = [3.0, 1.5]}]

    [scenes]
    plaza = "plaza.blend"
    alley = {file = "town.blend", scene = "Alley"}
    cellar = "cellar.npz"                        # a scene that was read before
    valley = {file = "valley.blend", parcel_size = 25.0}

    [clips]
    walks = "hero.blend"
    all = {file = "hero.blend", character = "Hero", actions = ["walk*", "turn*"]}
    tuned = "graph.npz"                          # an exported motion graph, or a clip set that was read before

    [settings]                                   # one value, or several in brackets: see :mod:`.settings`
    radius = [0.2, 0.3]
    max_cost = [0.1, 0.2]
    k = ["all", 2]

Files are sought from the folder of the study's own file. Every scene is tried with every clip set and every combination
of settings.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from .. import wording
from ..errors import StudyError
from ..files import LARGEST_TEXT, read_regular, why
from .measures import Measure, checked_measure
from .settings import Stage, Value, checked, of_stage

#: More cases than this are a slip of the keyboard.
MAX_CASES = 100_000

_NAME = re.compile(r"[\w][\w .+-]*")
_DEFAULT_MEASURES = ("coverage", "nodes", "links", "variability")


@dataclass(frozen=True)
class Source:
    """Source of a scene or a clip set.

    Attributes
    ----------
    name : str
    file : Path
        A .blend file, or an .npz that Wayfarer wrote.
    scene : str
        Scene of the .blend; empty for the one that was open when it was saved.
    character : str
        Armature of the .blend whose actions are meant; empty for the one chosen in the scene.
    actions : tuple of str
        Patterns such as "walk*"; empty for the actions in use in the scene.
    parcel_size : float
        Metres: sides of the parcels in which a large scene is embedded; 0 for one piece.
    """

    name: str
    file: Path
    scene: str = ""
    character: str = ""
    actions: tuple[str, ...] = ()
    parcel_size: float = 0.0

    @property
    def is_blend(self) -> bool:
        """True if Blender has to read it."""
        return self.file.suffix.lower() == ".blend"


@dataclass(frozen=True)
class Case:
    """One combination: names of a scene and a clip set, and the values of all settings that the study names."""

    scene: str
    clips: str
    values: Mapping[str, Value]

    def label(self, varied: Mapping[str, object]) -> str:
        """Return a label for people, with the settings that vary."""
        parts = [f"{name} {shown(name, self.values[name])}" for name in varied if name in self.values]
        return ", ".join([self.scene, self.clips, *parts])


@dataclass(frozen=True)
class StudyPlan:
    """A study as its file describes it."""

    title: str
    scenes: tuple[Source, ...]
    clip_sets: tuple[Source, ...]
    settings: Mapping[str, tuple[Value, ...]]
    measures: tuple[Measure, ...]

    @property
    def varied(self) -> dict[str, tuple[Value, ...]]:
        """The settings of more than one value."""
        return {name: values for name, values in self.settings.items() if len(values) > 1}

    def cases(self, ready_graphs: frozenset[str] = frozenset()) -> Iterator[Case]:
        """Yield all combinations; k varies fastest, so that neighbours share their embedding.

        For clip sets that are motion graphs already (``ready_graphs``) settings of the graph make no difference: they
        are left out.
        """
        order = sorted(self.settings, key=lambda name: name == "k")
        for scene, clips in product(self.scenes, self.clip_sets):
            known = set()
            for values in product(*(self.settings[name] for name in order)):
                given = dict(zip(order, values, strict=True))
                if clips.name in ready_graphs:
                    given = {n: v for n, v in given.items() if n not in of_stage(given, Stage.GRAPH)}
                if "parcel_size" not in given and scene.parcel_size:
                    given["parcel_size"] = scene.parcel_size
                if (key := tuple(given.items())) not in known:
                    known.add(key)
                    yield Case(scene.name, clips.name, given)


def shown(name: str, value: Value) -> str:
    """Write a value for people."""
    if name == "k" and value == 0:
        return "all"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _place(error: BaseException) -> str:
    """Return the line of a file that is no TOML, as far as that is known, as a part of a sentence."""
    line = re.search(r"line (\d+)", str(error))
    return f": line {line[1]} cannot be understood" if line else ""


def read_plan(path: Path) -> StudyPlan:
    """Read the file of a study; StudyError, naming the file and the entry, if it cannot be understood."""
    try:
        table = tomllib.loads(read_regular(path, LARGEST_TEXT).decode())
    except OSError as error:
        raise StudyError(f"'{path}' cannot be read: {why(error)}.") from None
    except (ValueError, RecursionError) as error:
        raise StudyError(f"'{path}' is no TOML{_place(error)}; correct it.") from error
    try:
        return plan_of(table, path.parent, path.stem)
    except StudyError as error:
        raise StudyError(f"'{path.name}': {error}") from None


def plan_of(table: Mapping[str, Any], folder: Path, title: str) -> StudyPlan:
    """Read the table of a study, its files sought from ``folder``; StudyError as for :func:`read_plan`."""
    unknown = set(table) - {"title", "scenes", "clips", "settings", "measures"}
    if unknown:
        raise StudyError(
            f"There is no entry {wording.quoted(min(unknown))}; there are title, scenes, clips, settings and measures."
        )
    scenes = _sources(table, "scenes", folder, {"file", "scene", "parcel_size"})
    clips = _sources(table, "clips", folder, {"file", "scene", "character", "actions"})
    settings = {name: _values(name, given) for name, given in _table(table, "settings").items()}
    wanted = table.get("measures", _DEFAULT_MEASURES)
    if not isinstance(wanted, list | tuple) or not wanted:
        raise StudyError("The measures are a list of names, such as ['coverage', 'links'].")
    measures = tuple(checked_measure(entry) for entry in wanted)
    twice = [m.name for i, m in enumerate(measures) if m.name in [other.name for other in measures[:i]]]
    if twice:
        raise StudyError(f"Two measures are called '{twice[0]}'; give one of them another name.")
    n_cases = len(scenes) * len(clips) * prod(len(values) for values in settings.values())
    if n_cases > MAX_CASES:
        raise StudyError(
            f"That makes {wording.number(n_cases)} cases, more than {wording.number(MAX_CASES)}; leave some values out."
        )
    return StudyPlan(str(table.get("title", title)), scenes, clips, settings, measures)


def _table(table: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = table.get(name, {})
    if not isinstance(found, dict):
        raise StudyError(f"The entry '{name}' must be a table: [{name}].")
    return found


def _sources(table: Mapping[str, Any], kind: str, folder: Path, known: set[str]) -> tuple[Source, ...]:
    found = []
    for name, entry in _table(table, kind).items():
        if not _NAME.fullmatch(name):
            raise StudyError(
                f"{wording.quoted(name)} in [{kind}] is no name: use letters, digits, spaces, dots and dashes."
            )
        entry = {"file": entry} if isinstance(entry, str) else entry
        if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
            raise StudyError(f"'{name}' in [{kind}] names no file.")
        if set(entry) - known:
            raise StudyError(
                f"'{name}' in [{kind}] has no {wording.quoted(min(set(entry) - known))}; it has "
                f"{', '.join(sorted(known))}."
            )
        file = folder / entry["file"]
        if "\0" in entry["file"]:
            raise StudyError(f"'{name}' in [{kind}] names a file that no file can be called; correct it.")
        if file.suffix.lower() not in (".blend", ".npz"):
            raise StudyError(f"'{name}' in [{kind}] is '{file.name}'; it must be a .blend or an .npz file.")
        actions = entry.get("actions", [])
        if not isinstance(actions, list) or not all(isinstance(pattern, str) for pattern in actions):
            raise StudyError(f"The actions of '{name}' are a list of names, such as ['walk*'].")
        size = checked("parcel_size", entry.get("parcel_size", 0.0))
        texts = {n: str(entry.get(n, "")) for n in ("scene", "character")}
        found.append(Source(name, file, **texts, actions=tuple(actions), parcel_size=float(size)))
    if not found:
        raise StudyError(f"There are no {kind}; name at least one file in [{kind}].")
    return tuple(found)


def _values(name: str, given: object) -> tuple[Value, ...]:
    values = tuple(checked(name, value) for value in (given if isinstance(given, list) else [given]))
    if not values:
        raise StudyError(f"The setting '{name}' has no values; give one or more, or leave it out.")
    return tuple(dict.fromkeys(values))
