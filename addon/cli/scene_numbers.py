"""What the commands of the command line tell about a scene."""

import math

import bpy

from ...core.evaluation.floor import floor_cells
from ..results.advice import clip_advice, embedding_advice, environment_advice
from ..results.store import embedding_of, graph_of, results, whole_of


def graph_numbers(scene) -> dict:
    """What every command tells about the scene and its motion graph."""
    settings, summary, graph = scene.wayfarer, results(scene).summary, graph_of(scene)
    return {
        "file": bpy.data.filepath,
        "scene": scene.name,
        "character": settings.character.name,
        "graph": {
            "clips": summary.clips,
            "clips_played": summary.clips_played,
            "segments": len(graph.segments),
            "links": len(graph.links),
            "max_cost": None if math.isnan(graph.max_cost) else float(graph.max_cost),
            "motion_seconds": summary.motion_seconds,
            "dropped_seconds": summary.dropped_seconds,
        },
    }


def embedding_numbers(scene) -> dict:
    """What every command tells about the embedding."""
    summary, embedding = results(scene).summary, embedding_of(scene)
    environment = embedding.environment
    cell = environment.grid.cell_size**2
    free, covered = floor_cells(whole_of(scene)), embedding.covered().any(axis=2)
    return {
        "embedding": {
            "cells": list(environment.grid.shape[:2]),
            "headings": environment.grid.n_headings,
            "cell_size": environment.grid.cell_size,
            "nodes": embedding.n_nodes,
            "links": embedding.n_links,
        },
        "coverage": {
            "share": summary.coverage,
            "square_metres": float(covered.sum() * cell),
            "free_square_metres": float(free.sum() * cell),
        },
    }


def warnings(scene, is_embedded: bool) -> list[str]:
    """What to look out for, in sentences."""
    sentences = [*clip_advice(scene), *environment_advice(scene), *(embedding_advice(scene) if is_embedded else ())]
    if results(scene).problem:
        sentences.append(results(scene).problem)
    return [f"{sentence}." for sentence in sentences]
