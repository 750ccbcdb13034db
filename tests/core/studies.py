"""Small scenes and clips for the tests of studies, built once."""

from functools import cache
from pathlib import Path

import numpy as np

from core.environment.regions import Region, RegionRule
from core.motion.graph import MotionGraph, build_motion_graph
from core.motion.graph_archive import save_motion_graph
from core.motion.repertoire import sample_repertoire
from core.progress import finish
from core.study.case import case_result, embed_case
from core.study.clip_set import ClipSet, save_clip_set
from core.study.geometry import SceneGeometry, save_scene
from core.study.plan import StudyPlan, plan_of
from core.study.run import run_study_steps

from .geometry import box_triangles
from .motion_graphs import SHORT


@cache
def few_clips():
    """Clips that make a small motion graph."""
    wanted = ("walk", "turn_left_90", "turn_right_90")
    return tuple(clip for clip in sample_repertoire() if clip.name.startswith(wanted))


@cache
def small_graph() -> MotionGraph:
    return build_motion_graph(few_clips(), SHORT)


def room(width=4.0, pillar=(1.5, 1.5), regions=()) -> SceneGeometry:
    """A room with a pillar on a coarse grid."""
    low = np.array([*pillar, 0.0])
    boxes = box_triangles(tuple(low), tuple(low + [0.5, 0.75, 2.0]))
    return SceneGeometry(boxes, (0.0, 0.0), (width, 4.0), tuple(regions), cell_size=0.25, n_headings=8)


def region(rule=RegionRule.FORBID, tag="step") -> Region:
    return Region("door", rule, tag, box_triangles((2.5, 2.5, 0), (3.5, 3.5, 1)), 0.0)


def lay_out(folder: Path, **tables) -> StudyPlan:
    """A study of two rooms and one motion graph in a folder; ``tables`` are further entries of its file."""
    folder.mkdir(parents=True, exist_ok=True)
    save_scene(room(), folder / "open.npz")
    save_scene(room(pillar=(1.0, 2.0), regions=[region()]), folder / "door.npz")
    save_motion_graph(small_graph(), folder / "graph.npz")
    save_clip_set(ClipSet(few_clips()), folder / "clips.npz")
    return plan(folder, **tables)


def plan(folder: Path, **tables) -> StudyPlan:
    """The plan over what :func:`lay_out` wrote."""
    given = {
        "scenes": {"open": "open.npz", "door": "door.npz"},
        "clips": {"graph": "graph.npz"},
        "settings": {"radius": [0.2, 0.3]},
        "measures": ["nodes", "links", "coverage", "variability"],
        **tables,
    }
    return plan_of(given, folder, "test")


def rows_of(outcome):
    """What a study found, without what differs from run to run."""
    return [
        (
            entry.case,
            entry.problem,
            None if entry.result is None else (dict(entry.result.numbers), entry.result.remarks),
            None if entry.result is None else entry.result.picture.levels.tobytes(),
        )
        for entry in outcome.outcomes
    ]


def run_case(geometry, graph, values, measures):
    """Embed, prune and measure in this process."""
    return case_result(embed_case(geometry, graph, values), values, measures)


def run_study(plan, folder, executor=None):
    """Run a study to its end."""
    return finish(run_study_steps(plan, folder, executor))
