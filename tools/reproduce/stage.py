"""Clips and scenes for the reproduction, through the add-on's own operators."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import TypeVar

import bpy
import numpy as np

from ...addon.results.clips import health_of
from ...addon.sample.layouts import SceneLayout, layout_of
from ...addon.scene.inputs import make_environment, prepared_clips_steps, read_character, read_shapes
from ...core.embedding.embedding import Embedding, EmbeddingSettings, embed
from ...core.environment.environment import Environment
from ...core.environment.obstacles import clip_to_heights, occupied_samples
from ...core.motion.clip import MotionClip
from ...core.motion.doctor import FindingKind, RemedyKind
from ...core.progress import finish
from ...core.report.floor_chart import FloorScene

#: Metres: that of the rooms in the paper.
PAPER_CELL = 0.125

Result = TypeVar("Result")

#: Beginnings of the names of those clips of the sample character that a quick run uses.
_FEW = ("walk", "step_over", "pivot", "start", "stop")

#: What the clip doctor's advice is followed about; pops of a single bone matter little here.
_NO_MOTION = (FindingKind.REST_POSE, FindingKind.FROZEN)

#: Measurements that take longer than so many seconds are not repeated.
SLOW = 2.0


@dataclass(frozen=True)
class Coarseness:
    """The fineness of the grids: as in the paper, or coarser for a quick look.

    Attributes
    ----------
    cell_factor : float
        Of the scene's own cell size.
    n_headings : int or None
        None for the scene's own.
    """

    cell_factor: float = 1.0
    n_headings: int | None = None


@dataclass(frozen=True)
class Place:
    """A sample scene as the core sees it.

    Attributes
    ----------
    layout : SceneLayout
    environment : Environment
    obstacles : (T, 3, 3) float array
        Triangles of the meshes in the way.
    floor : FloorScene
        For maps.
    """

    layout: SceneLayout
    environment: Environment
    obstacles: np.ndarray
    floor: FloorScene

    def embed(self, graph, settings: EmbeddingSettings | None = None) -> Embedding:
        return embed(graph, self.environment, settings or EmbeddingSettings())


def bring_clips(folder: Path | None, few: bool = False) -> tuple[list[MotionClip], list[str]]:
    """Import a folder of BVH files, or make the sample character.

    ``few`` leaves out what the sample character does beside walking, turning on the spot and stepping over. Returns
    the clips as the operators of the panel read them, and what the clip doctor cut off them, in sentences.
    """
    scene = bpy.context.scene
    scene.render.fps = 30
    if folder is not None:
        bpy.ops.wayfarer.import_motion(directory=str(folder))
    else:
        bpy.ops.wayfarer.add_sample_character()
        for clip in scene.wayfarer.clips:
            clip.use = not few or clip.action.name.startswith(_FEW)
    trimmed = _trim_clips(scene) if folder is not None else []
    clips, _ = read_character(scene)
    return finish(prepared_clips_steps(clips, scene.wayfarer.graph.steady_heading, False)), trimmed


def _trim_clips(scene) -> list[str]:
    """Let the clip doctor cut off what is no motion at the ends of recordings; says what was found."""
    bpy.ops.wayfarer.examine_clips()
    sentences = []
    for action in scene.wayfarer.used_actions():
        health = health_of(scene, action)
        if health is None:
            continue
        for number, finding in enumerate(health.findings):
            if finding.kind in _NO_MOTION and finding.remedy is not None and finding.remedy.kind is RemedyKind.TRIM:
                bpy.ops.wayfarer.apply_remedy(action=action.name, finding=number)
                sentences.append(f"{health.sentences[number].rstrip('.')}.")
                break
    return sentences


def open_place(key: str, coarseness: Coarseness) -> Place:
    """Bring a sample scene into Blender's scene, in place of the one before, and read it."""
    scene = bpy.context.scene
    bpy.ops.wayfarer.add_sample_room(sample=key)
    settings = scene.wayfarer.environment
    if not settings.tiled:
        settings.cell_size = PAPER_CELL
    settings.cell_size *= coarseness.cell_factor
    settings.n_headings = coarseness.n_headings or settings.n_headings
    bpy.context.view_layer.update()
    shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get())
    environment = make_environment(scene, shapes)
    return Place(
        layout_of(key), environment, shapes.obstacles, FloorScene(environment, standing(scene, shapes, environment))
    )


def standing(scene, shapes, environment: Environment) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples on which something stands that a scene's character cannot step on."""
    body = scene.wayfarer.environment.to_core(shapes.ground_height)
    low, high = body.ground_height + body.step_height, body.ground_height + body.head_height
    return occupied_samples(environment.grid, clip_to_heights(shapes.obstacles, low, high), 0)


def timed(work: Callable[[], Result]) -> tuple[Result, float]:
    """(what the work returns, seconds of the processor): the best of three runs, the first if that takes long."""
    seconds = []
    while True:
        start = process_time()
        result = work()
        seconds.append(process_time() - start)
        if len(seconds) == 3 or seconds[0] > SLOW:
            return result, min(seconds)
