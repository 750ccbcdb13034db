"""Someone who does one random thing after another in Blender: everything of ours, and what artists do beside it."""

import os
from collections.abc import Iterator
from pathlib import Path

import bpy

from bl_ext.user_default.wayfarer.addon.live import live
from bl_ext.user_default.wayfarer.addon.results import clips, staleness, store
from tests.blender.meddler import NAMES, Meddler

WEIGHTS = {
    "run": 12,
    "change_setting": 5,
    "move": 3,
    "reshape": 1,
    "color": 0.6,
    "purge": 0.2,
    "undo": 2,
    "redo": 1,
    "tick": 1,
    "key": 1,
    "rig": 0.5,
    "point": 1,
    "rename": 0.7,
    "delete": 0.4,
    "save": 0.4,
    "reopen": 0.4,
    "evaluate_live": 0.8,
    "remedy": 0.3,
    "preset": 0.3,
    "region": 0.3,
    "frame": 0.4,
    "edit_mode": 0.3,
    "copy_scene": 0.25,
    "change_scene": 0.3,
    "delete_scene": 0.25,
    "second_character": 0.15,
    "link": 0.2,
}
"""What is done, and how often."""

LEFT_OUT = {
    # They need a window.
    "pick_place",
    # They need what :class:`Artist` has steps of its own for, or files that other tests make up.
    "apply_remedy",
    "import_bvh",
    "import_motion",
    # Twenty-eight clips, made and written: it takes as long as a hundred other steps.
    "add_sample_character",
}
SLOW = (
    "write_report",
    "export_engine",
    "export_results",
    "direct_capture",
    "crowd",
    "examine_clips",
    "add_sample_room",
)
"""Run less often than the others: they write pictures and files."""

# Values of settings: what is finer, longer or more than this takes more time than there is, and shows nothing else.
RANGES = {
    "graph.frame_rate": (8.0, 20.0),
    "graph.min_segment_duration": (0.2, 1.5),
    "graph.max_links": (1, 200),
    "environment.cell_size": (0.2, 0.6),
    "environment.n_headings": (4, 14),
    "environment.ground_low": (-3.0, 1.0),
    "environment.ground_high": (-1.0, 3.0),
    "environment.ground_height": (-0.5, 0.5),
    "embedding.position_rate": (0.0, 0.15),
    "embedding.heading_rate": (0.0, 0.2),
    "evaluation.n_pairs": (1, 6),
    "evaluation.n_candidates": (1, 4),
    "evaluation.few_ways": (0, 100),
    "map.few_ways": (0, 100),
    "map.heading": (-10.0, 10.0),
    "tuning.max_links": (0, 5000),
    "queries.n_walks": (1, 4),
    "queries.duration": (0.1, 4.0),
    "queries.times": (0.0, 9.0),
    "walk.duration": (0.1, 5.0),
    "walk.crowd.n_walkers": (1, 3),
    "walk.crowd.duration": (0.1, 3.0),
    "contacts.height": (0.001, 0.3),
    "active_clip": (-2, 6),
    "graph.active_joint_weight": (-2, 6),
    "environment.active_region": (-2, 3),
}


def known_operators() -> list[str]:
    return sorted(name for name in dir(bpy.ops.wayfarer) if name not in LEFT_OUT)


def settings_of(group, path: str = "") -> Iterator[tuple]:
    """(group, property, path) of everything that can be set under ``scene.wayfarer``."""
    for prop in group.bl_rna.properties:
        if prop.identifier in ("rna_type", "name") or path == "walk.report.":
            continue
        if prop.type == "POINTER" and isinstance(getattr(group, prop.identifier), bpy.types.PropertyGroup):
            yield from settings_of(getattr(group, prop.identifier), f"{path}{prop.identifier}.")
        elif prop.type in ("FLOAT", "INT", "BOOLEAN", "ENUM", "STRING") and not prop.is_readonly:
            yield group, prop, path + prop.identifier


class Artist(Meddler):
    """Does one random thing at a time, with our operators and beside them.

    Attributes
    ----------
    failed : bool
        Whether the last step ended in a sentence instead of a result.
    """

    def __init__(self, seed: int, folder: Path):
        super().__init__(seed, folder)
        self.failed = False

    def step(self) -> str:
        """Do something; its name, the operator's for one of ours."""
        [kind] = self.random.choices(list(WEIGHTS), list(WEIGHTS.values()))
        self.done.append(kind)
        self.failed = False
        return getattr(self, kind)() or kind

    def run(self) -> str:
        chance = self.random.random()
        rest = [name for name in known_operators() if name not in SLOW]
        name = self.sensible() if chance < 0.45 else self.random.choice(SLOW if chance < 0.5 else rest)
        self.call(name, **self.options(name))
        return name

    def sensible(self) -> str:
        """What someone would do next who wants to see the character walk."""
        found = store.results(self.scene)
        if found.graph is None or staleness.graph_is_stale(self.scene):
            return "build_motion_graph"
        if found.embedding is None or staleness.embedding_is_stale(self.scene):
            return "embed"
        return self.random.choice(["paint_map", "random_walk", "prune", "restore_embedding", "embed"])

    def call(self, operator: str, **options) -> None:
        """Run an operator: whatever it cannot do it says in a sentence."""
        self.note(f"{operator} {options}" if options else operator)
        try:
            self.failed = getattr(bpy.ops.wayfarer, operator)("EXEC_DEFAULT", True, **options) != {"FINISHED"}
        except RuntimeError as error:
            self.failed = True
            text = str(error)
            assert "Traceback" not in text, text
            assert "context is incorrect" not in text, f"{operator} does not say why it cannot be used"

    def options(self, name: str) -> dict:
        """Values for some of its properties, within their ranges."""
        options: dict = {}
        for prop in getattr(bpy.ops.wayfarer, name).get_rna_type().properties:
            if prop.identifier == "filepath":
                options["filepath"] = self.library if os.path.exists(self.library) else str(self.folder / "none.blend")
            elif prop.identifier == "directory":
                options["directory"] = str(self.folder)
            elif prop.identifier != "rna_type" and not prop.is_hidden and self.random.random() < 0.7:
                options[prop.identifier] = self.value(prop, prop.identifier)
        # The thorough report is the same work, for minutes.
        options.pop("thorough", None)
        return options

    def value(self, prop, path: str):
        """A random value of a property, now and then at the end of its range."""
        if prop.type == "BOOLEAN":
            return self.random.random() < 0.5
        if prop.type == "ENUM":
            items = [item.identifier for item in prop.enum_items]
            if prop.is_enum_flag:
                return {item for item in items if self.random.random() < 0.5}
            return self.random.choice(items) if items else ""
        if prop.type == "STRING":
            return self.random.choice(NAMES)
        low, high = RANGES.get(path, (max(prop.soft_min, -5), min(prop.soft_max, 5)))

        def number():
            if prop.type == "INT":
                return self.random.randint(int(low), int(high))
            return self.random.choice([low, high, *(self.random.uniform(low, high) for _ in range(6))])

        return [number() for _ in range(prop.array_length)] if prop.is_array else number()

    def change_setting(self) -> None:
        kinds: dict[str, list] = {}
        for setting in settings_of(self.settings):
            kinds.setdefault(setting[2].rpartition(".")[0], []).append(setting)
        group, prop, path = self.choose(self.choose(kinds.values()))
        value = self.value(prop, path)
        if prop.type == "ENUM" and not prop.is_enum_flag and not prop.enum_items:
            # Items that a function makes, such as the segments there are.
            return
        self.note(f"{path} = {value!r}")
        setattr(group, prop.identifier, value)
        self.push()

    def tick(self) -> None:
        clip = self.choose(self.settings.clips)
        if clip is not None:
            clip.use, clip.weight = not clip.use, self.random.choice([0.0, 1.0, 5.0])
            self.push()

    def evaluate_live(self) -> None:
        """What the timer does in a window."""
        self.settings.live = self.random.random() < 0.7
        evaluation = live.evaluation(self.scene)
        if store.results(self.scene).embedding is not None:
            if evaluation.notice_settings(self.scene) or self.random.random() < 0.8:
                evaluation.change(restart=self.random.random() < 0.5)
            for _ in range(self.random.choice([1, 1000])):
                graph = bpy.context.evaluated_depsgraph_get()
                if evaluation.step(self.scene, graph, 1.0, map_only=not self.settings.live):
                    break

    def remedy(self) -> None:
        self.call("examine_clips")
        for clip in self.settings.clips:
            health = clips.health_of(self.scene, clip.action) if clip.action else None
            if health is not None and health.findings:
                self.call("apply_remedy", action=clip.action.name, finding=0)
                return
        self.call("apply_remedy", action="Nobody", finding=3)

    def preset(self) -> None:
        kind = self.random.choice(["graph", "environment", "embedding"])
        self.call(f"add_{kind}_preset", name=f"Fuzz {self.random.randint(0, 2)}")
        paths = bpy.utils.preset_paths(f"wayfarer/{kind}")
        files = [os.path.join(path, name) for path in paths for name in sorted(os.listdir(path)) if "fuzz" in name]
        if files:
            bpy.ops.script.execute_preset(filepath=self.random.choice(files), menu_idname=f"WAYFARER_PT_{kind}_presets")
            self.push()

    def region(self) -> None:
        self.call("add_region")
        if self.settings.environment.regions:
            region = self.settings.environment.regions[-1]
            region.object = self.choose(obj for obj in bpy.data.objects if obj.type == "MESH")
            region.tag = self.random.choice(["step", "", "stride", " step "])
            region.margin = self.random.choice([0.0, 0.2])
        self.push()
