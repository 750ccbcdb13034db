"""The engine format: what the reference reader finds in it, knowing nothing of us, is what the embedding is."""

import hashlib
import io
import json
import os
import subprocess
import sys
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import Environment, build_environment
from core.environment.grid import Grid
from core.errors import ExportError
from core.evaluation.goals import goal_in_cells
from core.evaluation.reach import time_to_reach_steps
from core.export.engine_format import engine_arrays, engine_files_steps, engine_header
from core.export.table import engine_table_steps
from core.motion.graph import build_motion_graph
from core.motion.repertoire import sample_repertoire
from core.playback.walk import Walk
from core.progress import finish
from core.tuning.budget import table_bytes

from .geometry import box_triangles
from .reference import explicit_embedding, random_problem

ROOT = Path(__file__).resolve().parents[2]
READER = ROOT / "assets" / "engine"
SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def write(embedding, folder):
    folder.mkdir()
    for name, raw in finish(engine_files_steps(embedding)).items():
        (folder / name).write_bytes(raw)


def read_alone(tmp_path, *words):
    """Run Python with NumPy and the standard library, and nothing else to import."""
    alone = tmp_path / "alone"
    alone.mkdir(exist_ok=True)
    for found in Path(np.__file__).parents[1].glob("numpy*"):
        if not (alone / found.name).exists():
            (alone / found.name).symlink_to(found)
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(alone)}
    command = [sys.executable, "-S", *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, cwd=tmp_path)


def check(embedding, folder):
    found = np.load(folder / "found.npz")
    mask = embedding.node_mask()
    nodes = np.argwhere(mask)
    assert np.array_equal(found["nodes"], nodes)
    # Links, one by one, by the stencil that each plays.
    reader = LinkReader(embedding)
    row, stencil = reader.links_from(nodes)
    ends = reader.wrapped(reader.ends(nodes[row], stencil))
    flat = [np.ravel_multi_index(tuple(states.T), mask.shape) for states in (nodes[row], ends)]
    ours = np.column_stack([flat[0], stencil, flat[1]])
    assert len(ours) == embedding.n_links
    for links in (found["leaving"], found["arriving"]):
        assert np.array_equal(links[np.lexsort(links.T)], ours[np.lexsort(ours.T)])
    # The same as the plain table tells it: ends by their numbers.
    rows, first, after = found["table_nodes"].astype(int), found["table_first"].astype(int), found["table_links"]
    assert np.array_equal(rows[np.lexsort(rows.T[::-1])], nodes)
    numbers = np.ravel_multi_index(tuple(rows.T), mask.shape)
    listed = np.column_stack([np.repeat(numbers, np.diff(first)), numbers[after]])
    assert first[0] == 0 and first[-1] == len(after) == embedding.n_links
    expected = ours[:, [0, 2]]
    assert np.array_equal(listed[np.lexsort(listed.T)], expected[np.lexsort(expected.T)])
    size = (folder / "embedding.table").stat().st_size
    assert size == table_bytes(embedding.n_nodes, embedding.n_links)
    told = json.loads((folder / "embedding.json").read_text())["table"]
    raw = (folder / told["file"]).read_bytes()
    assert told["bytes"] == len(raw) == size and told["sha256"] == hashlib.sha256(raw).hexdigest()
    goal = np.zeros(mask.shape[:2], dtype=bool)
    goal[tuple(found["goal"].T)] = True
    times = finish(time_to_reach_steps(embedding, goal_in_cells(embedding, goal))).frames_at(nodes)
    assert np.array_equal(found["times"], times)
    walked, promised, arrived = found["ways"].T
    assert np.array_equal(walked, promised) and arrived.all()
    walk = Walk(embedding, found["states"], found["stencils"])
    assert walk.duration >= 60 and found["path"].shape == walk.root_path.shape
    assert np.allclose(found["path"], walk.root_path, atol=1e-9)
    return times


def test_the_reader_finds_what_is_there(tmp_path):
    embeddings = {}
    for seed in range(60):
        problem = random_problem(seed, tiled=seed % 3 == 0)
        embedding = embed(*problem, SETTINGS)
        if embedding.n_nodes:
            explicit = explicit_embedding(*problem, SETTINGS)
            assert embedding.n_links == len(explicit.links)
            embeddings[tmp_path / str(seed)] = embedding
            write(embedding, tmp_path / str(seed))
    assert len(embeddings) > 15 and any(e.environment.grid.tiled for e in embeddings.values())
    result = read_alone(tmp_path, ROOT / "tests" / "core" / "reader_driver.py", READER, *embeddings)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"
    longest = [check(embedding, folder).max() for folder, embedding in embeddings.items()]
    assert max(longest) > 10


def test_the_reader_walks_in_a_room(tmp_path):
    clips = [clip for clip in sample_repertoire() if clip.name.startswith(("walk", "turn_left_90", "turn_right_90"))]
    grid = Grid.over_rectangle((0, 0), (4, 4), 0.25, 12)
    environment = build_environment(grid, box_triangles((1.5, 1.5, 0), (2, 2.5, 2)))
    embedding = embed(build_motion_graph(clips), environment)
    assert embedding.n_nodes > 1000
    write(embedding, tmp_path / "room")
    result = read_alone(tmp_path, ROOT / "tests" / "core" / "reader_driver.py", READER, tmp_path / "room")
    assert result.returncode == 0, result.stderr
    check(embedding, tmp_path / "room")
    header = json.loads((tmp_path / "room" / "embedding.json").read_text())
    graph = embedding.graph
    for told, segment in zip(header["segments"], graph.segments, strict=True):
        clip = graph.clips[segment.clip]
        assert told["clip"] == clip.name and told["end"] - told["start"] == pytest.approx(segment.duration)
        assert told["end"] <= clip.duration + 1e-9
    result = read_alone(tmp_path, READER / "wayfarer_reader.py", tmp_path / "room")
    assert result.returncode == 0 and f"{embedding.n_nodes:,} nodes" in result.stdout


def test_how_the_reader_is_run_is_said(tmp_path):
    for words in ([], ["a", "b"]):
        result = read_alone(tmp_path, READER / "wayfarer_reader.py", *words)
        assert (result.returncode, result.stdout) == (2, "")
        assert result.stderr == "usage: python wayfarer_reader.py FOLDER\n"
    result = read_alone(tmp_path, READER / "wayfarer_reader.py", tmp_path / "nothing")
    assert result.returncode == 1 and "No such file" in result.stderr and "Traceback" not in result.stderr


def test_tables_that_are_too_large_are_refused():
    embedding = next(e for e in (embed(*random_problem(s, True), SETTINGS) for s in range(30)) if e.n_nodes)
    assert set(finish(engine_files_steps(embedding, with_table=False))) == {"embedding.json", "embedding.npz"}
    header = json.loads(finish(engine_files_steps(embedding, with_table=False))["embedding.json"])
    assert header["table"] is None
    counted = replace(embedding)
    counted.__dict__.update(n_links=2**31)
    with pytest.raises(
        ExportError, match=r"would take 8\.59 GB; prune the embedding, or leave the table out.*--no-table"
    ):
        finish(engine_files_steps(counted))
    assert finish(engine_files_steps(counted, with_table=False))
    # To the byte: the table, and eight beside it for each node.
    needed = table_bytes(embedding.n_nodes, embedding.n_links) + 8 * embedding.n_nodes
    enough = replace(embedding, settings=replace(embedding.settings, memory_limit=needed))
    assert finish(engine_table_steps(enough)) == finish(engine_table_steps(embedding))
    with pytest.raises(ExportError, match="leave the table out"):
        finish(engine_table_steps(replace(embedding, settings=replace(embedding.settings, memory_limit=needed - 1))))


def listed(embedding) -> bytes:
    """The table, node by node and link by link."""
    nx, ny, _, _ = embedding.shape
    nodes = embedding.node_mask().transpose(3, 2, 0, 1)
    number = np.cumsum(nodes).reshape(nodes.shape) - 1
    reader, rows, begins, after = LinkReader(embedding), [], [0], []
    for segment, heading, x, y in np.argwhere(nodes).tolist():
        node = (x, y, heading, segment)
        rows.append(node)
        ends = [reader.follow(node, stencil) for stencil in reader.stencils_from(node).tolist()]
        after += [number[end[3], end[2], end[0] % nx, end[1] % ny] for end in ends]
        begins.append(len(after))
    parts = (np.array(rows, "<u2"), np.array(begins, "<u4"), np.array(after, "<u4"))
    return b"".join(part.tobytes() for part in parts)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), tiled=st.booleans(), kept=st.sampled_from([1.0, 0.9]))
def test_the_table_is_as_written_out(seed, tiled, kept):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    if kept < 1:
        # With planes that differ between segments that have the same children.
        indices = np.argwhere(embedding.node_mask().transpose(3, 2, 0, 1).reshape(len(embedding.planes), -1))
        indices = indices[np.random.default_rng(seed).random(len(indices)) < kept]
        embedding = finish(restrict_steps(embedding, embedding.network.nodes(indices)))
    if embedding.n_nodes:
        assert bytes(finish(engine_table_steps(embedding))) == listed(embedding)


def test_files_are_made_in_steps():
    clips = [clip for clip in sample_repertoire() if clip.name.startswith(("walk", "turn_left_90", "turn_right_90"))]
    embedding = embed(build_motion_graph(clips), build_environment(Grid((12, 14, 12), 0.25), np.empty((0, 3, 3))))
    assert embedding.n_nodes
    told, steps = [], engine_files_steps(embedding)
    while True:
        try:
            told.append(next(steps))
        except StopIteration as stop:
            files = stop.value
            break
    fractions = [progress.fraction for progress in told]
    assert fractions == sorted(fractions) and fractions[0] >= 0 and fractions[-1] <= 1
    # One for each heading and exit group at least, so that whoever presses Esc need not wait.
    assert len(told) > 12 * len(embedding.network.exit_groups)
    assert list(dict.fromkeys(progress.message for progress in told)) == [
        "Counting links",
        "Listing links",
        "Packing planes",
    ]
    assert files == finish(engine_files_steps(embedding)) and bytes(files["embedding.table"]) == listed(embedding)
    # What cannot be made is refused before any work.
    small = replace(embedding, settings=replace(embedding.settings, memory_limit=1000))
    for refused in (engine_table_steps(small), engine_files_steps(small)):
        with pytest.raises(ExportError, match="leave the table out"):
            next(refused)


def test_tables_take_little_more_memory_than_they_are_large():
    clips = [clip for clip in sample_repertoire() if clip.name.startswith(("walk", "turn_left_90", "turn_right_90"))]
    embedding = embed(build_motion_graph(clips), build_environment(Grid((40, 40, 12), 0.25), np.empty((0, 3, 3))))
    size = table_bytes(embedding.n_nodes, embedding.n_links)
    assert size > 1_000_000
    tracemalloc.start()
    try:
        raw = finish(engine_table_steps(embedding))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(raw) == size and peak < 2 * size


def test_the_reader_says_that_there_is_no_table(tmp_path):
    embedding = next(e for e in (embed(*random_problem(s, True), SETTINGS) for s in range(30)) if e.n_nodes)
    for name, raw in finish(engine_files_steps(embedding, with_table=False)).items():
        (tmp_path / name).write_bytes(raw)
    look = f"import sys; sys.path[:0] = [{str(READER)!r}]; import wayfarer_reader as w; w.read_table({str(tmp_path)!r})"
    result = read_alone(tmp_path, "-c", look)
    assert result.stderr.strip().endswith(
        f"Damaged: '{tmp_path}' holds no table: it was left out; export again with it"
    )


def test_tags_are_told_by_frames():
    graph, environment = next(
        (graph, environment)
        for graph, environment in (random_problem(seed, False) for seed in range(100))
        if any(mask.any() and not mask.all() for s in graph.segments for mask in s.tags.values())
    )
    told = engine_header(embed(graph, environment))["segments"]
    for entry, segment in zip(told, graph.segments, strict=True):
        for tag, mask in segment.tags.items():
            again = np.zeros(segment.n_frames, dtype=bool)
            for first, last in entry["tags"][tag]:
                again[first : last + 1] = True
            assert np.array_equal(again, mask)


def test_what_is_not_sound_is_refused(tmp_path):
    graph, environment = random_problem(0, True)
    blocked = Environment(environment.grid, np.ones_like(environment.blocked))
    with pytest.raises(ExportError, match="nothing to export"):
        finish(engine_files_steps(embed(graph, blocked)))
    embedding = next(e for e in (embed(*random_problem(s, True), SETTINGS) for s in range(30)) if e.n_nodes)
    assert finish(engine_files_steps(embedding)) == finish(engine_files_steps(embedding))
    write(embedding, tmp_path / "a")
    raw = bytearray((tmp_path / "a" / "embedding.npz").read_bytes())
    raw[len(raw) // 2] ^= 1
    (tmp_path / "a" / "embedding.npz").write_bytes(raw)
    assert "damaged" in read_alone(tmp_path, READER / "wayfarer_reader.py", tmp_path / "a").stderr
    header = json.loads((tmp_path / "a" / "embedding.json").read_text())
    (tmp_path / "a" / "embedding.json").write_text(json.dumps({**header, "version": 2}))
    assert (
        "no embedding that this reader knows"
        in read_alone(tmp_path, READER / "wayfarer_reader.py", tmp_path / "a").stderr
    )


def test_the_reader_makes_no_more_than_the_files_can_hold(tmp_path):
    """However large a header claims to be: 1 GB of memory is more than enough to say so."""
    embedding = next(e for e in (embed(*random_problem(s, True), SETTINGS) for s in range(30)) if e.n_nodes)
    write(embedding, tmp_path / "a")
    header, arrays = tmp_path / "a" / "embedding.json", tmp_path / "a" / "embedding.npz"
    sound, packed = json.loads(header.read_text()), arrays.read_bytes()

    def refused(changes, raw=packed) -> str:
        arrays.write_bytes(raw)
        header.write_text(json.dumps({**sound, "sha256": hashlib.sha256(raw).hexdigest(), **changes}))
        command = 'ulimit -v 1000000; exec "$@"'
        words = ["sh", "-c", command, "sh", sys.executable, READER / "wayfarer_reader.py", tmp_path / "a"]
        result = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=60)
        assert result.returncode == 1 and "Traceback" not in result.stderr and "Memory" not in result.stderr
        return result.stderr

    huge = {**sound["grid"], "shape": [10**6, 10**6, sound["grid"]["shape"][2]]}
    assert "do not fit their header" in refused({"grid": huge})
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(packed)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            start = io.BytesIO()
            np.lib.format.write_array_header_1_0(start, {"descr": "|u1", "fortran_order": False, "shape": (10**11,)})
            new.writestr(name, start.getvalue() + bytes(1000) if name == "nodes.npy" else old.read(name))
    assert "'nodes' is none that an export has" in refused({}, out.getvalue())
    for changes in ({"segments": 7}, {"grid": {"shape": []}}, {"grid": None}):
        assert "is damaged" in refused(changes)
    header.write_text("[" * 100_000)
    assert "is damaged" in read_alone(tmp_path, READER / "wayfarer_reader.py", tmp_path / "a").stderr
    header.unlink()
    header.symlink_to("/dev/zero")
    assert "is no file" in read_alone(tmp_path, READER / "wayfarer_reader.py", tmp_path / "a").stderr


def test_the_documentation_names_everything():
    text = (ROOT / "docs" / "engine_format.md").read_text()
    embedding = next(e for e in (embed(*random_problem(s, True), SETTINGS) for s in range(30)) if e.n_nodes)
    header = engine_header(embedding)
    names = {*header, "table", "sha256", *engine_arrays(embedding), *header["grid"], *header["segments"][0]}
    assert {name for name in names if f"`{name}`" not in text} == set()
    assert len((READER / "wayfarer_reader.py").read_text().splitlines()) < 260
