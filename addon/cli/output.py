"""The numbers of a command: for programs, and in sentences for people."""

import contextlib
import math
import os
import sys

import bpy

from ...core.errors import StorageError
from ...core.evaluation.floor import floor_cells
from ...core.wording import amount, area, counted, share, short, time
from ..results.advice import clip_advice, embedding_advice, environment_advice, unlisted_advice
from ..results.store import embedding_of, graph_of, results, whole_of


def graph_numbers(scene) -> dict:
    """Return what every command reports about the scene and its motion graph."""
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
    """Return what every command reports about the embedding."""
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
    """Return what to look out for, in sentences."""
    sentences = [
        *clip_advice(scene),
        *environment_advice(scene),
        *unlisted_advice(scene),
        *(embedding_advice(scene) if is_embedded else ()),
    ]
    if results(scene).problem:
        sentences.append(results(scene).problem)
    return [f"{sentence}." for sentence in sentences]


def summary_lines(numbers: dict) -> list[str]:
    """Return the numbers of a command in sentences."""
    graph, embedding, coverage = numbers["graph"], numbers["embedding"], numbers["coverage"]
    lines = [
        f"Motion graph: {counted(graph['segments'], 'segment')}, {counted(graph['links'], 'link')} from "
        f"{graph['clips_played']} of {counted(graph['clips'], 'clip')}, {time(graph['motion_seconds'])} of motion",
        f"Embedding: {counted(embedding['nodes'], 'node')}, {counted(embedding['links'], 'link')} on "
        f"{embedding['cells'][0]} x {embedding['cells'][1]} cells x {embedding['headings']} headings",
        f"Coverage: {share(coverage['share'])} of the free floor, "
        f"{amount(coverage['square_metres'])} of {area(coverage['free_square_metres'])}",
    ]
    if "variability" in numbers:
        ways = numbers["variability"]
        lines.append(
            f"Variability: {amount(ways['mean'])} ways on average, up to {counted(ways['highest'], 'way')} in a cell"
        )
    if "parcels" in numbers:
        made = numbers["parcels"]
        lines.append(f"In parcels of {short(made['parcel_size'])} m; table, page and maps: {made['folder']}")
    if "walk" in numbers:
        made = numbers["walk"]
        lines.append(
            f"Walk: {time(made['seconds'])}, {amount(made['metres'])} m, {counted(made['segments'], 'segment')}, in "
            f"the action '{made['action']}', frames {made['frames'][0]} to {made['frames'][1]}"
        )
    if "report" in numbers:
        made = numbers["report"]
        lines.append(f"Report written to {made['folder']}: {made['files'][0]} and {len(made['files']) - 1} files more")
    if "export" in numbers:
        made = numbers["export"]
        lines.append(f"Exported to {made['folder']}: {', '.join(made['files'])}")
    if "saved" in numbers:
        lines.append(f"Saved as {numbers['saved']}")
    return lines


@contextlib.contextmanager
def clean_output():
    """A file for what was asked for: what Blender prints meanwhile goes to standard error instead.

    Blender prints from C, so that the file descriptor itself is turned. Raises StorageError if it is closed.
    """
    if sys.stderr is None:
        # Whoever closes it wants to hear nothing; what is opened next must not take its place.
        _nowhere(2)
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 (as long as the program runs)
    if sys.stdout is None:
        _nowhere(1)
        raise StorageError("Standard output is closed, so that there is nowhere to answer; send it to a file.")
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    # Names of files need not be text.
    out = open(kept, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
    try:
        yield out
    finally:
        # What could not be written has been told; it must not be tried again.
        with contextlib.suppress(OSError):
            out.close()
        os.dup2(kept, 1)
        os.close(kept)


def _nowhere(descriptor: int) -> None:
    """Let a file descriptor that is closed lead nowhere."""
    opened = os.open(os.devnull, os.O_WRONLY)
    if opened != descriptor:
        os.dup2(opened, descriptor)
        os.close(opened)
