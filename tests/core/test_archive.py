"""Motion graphs and embeddings in files: equal to the last bit when read, refused with a sentence when damaged."""

import io
import json
import zipfile
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.archive import ArchiveFormat, archive_from_bytes, archive_to_bytes
from core.embedding.archive import embedding_from_bytes, embedding_to_bytes, load_embedding
from core.embedding.arrays import EMBEDDING_FORMAT, fields_to_arrays
from core.embedding.embedding import Embedding, EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintRule, FootprintSettings
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import EmbeddingError, MotionGraphError
from core.motion.graph import MotionGraph
from core.motion.graph_archive import graph_from_bytes, graph_to_bytes, load_motion_graph, save_motion_graph
from core.playback.walk import WalkSettings, random_walk_steps
from core.progress import finish

from .motion_graphs import recorded_graph, sample_graph
from .reference import random_problem

FOOTPRINT = FootprintSettings(0.1, 0.2, 0.4, 0.4, FootprintRule.CONSERVATIVE)


def assert_same(a, b, where="value"):
    """Equal to the last bit, field by field, however deep; arrays of the same type and shape."""
    assert type(a) is type(b), where
    if isinstance(a, np.ndarray):
        assert (a.dtype, a.shape) == (b.dtype, b.shape), where
        assert np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes(), where
    elif is_dataclass(a) and not isinstance(a, Enum):
        # What is known beside the value itself follows from it.
        for field in (field for field in fields(a) if field.name != "known_network"):
            assert_same(getattr(a, field.name), getattr(b, field.name), f"{where}.{field.name}")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), where
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{where}[{i}]")
    elif isinstance(a, dict):
        assert list(a) == list(b), where
        for key in a:
            assert_same(a[key], b[key], f"{where}[{key!r}]")
    else:
        assert a == b or (a != a and b != b), where


@cache
def sample_embedding() -> Embedding:
    blocked = np.zeros((40 * 4, 36 * 4), dtype=bool)
    blocked[50:70, 60:90] = True
    return embed(sample_graph(), Environment(Grid((40, 36, 12), 0.15, (-1.5, 0.25)), blocked))


@settings(max_examples=200)
@given(st.integers(0, 10**6), st.booleans(), st.sampled_from([FootprintSettings(), FOOTPRINT]))
def test_random_embeddings_come_back_to_the_last_bit(seed, tiled, footprint):
    embedding = embed(*random_problem(seed, tiled), EmbeddingSettings(footprint, 1e9))
    read = embedding_from_bytes(embedding_to_bytes(embedding))
    assert_same(read, embedding)
    assert read.n_links == embedding.n_links
    if embedding.n_nodes:
        walks = [
            finish(random_walk_steps(e, np.random.default_rng(seed), WalkSettings(2.0))) for e in (read, embedding)
        ]
        assert_same(*(walk.states for walk in walks))
        assert_same(*(walk.root_path for walk in walks))


def test_the_sample_character_comes_back_to_the_last_bit(tmp_path):
    embedding = sample_embedding()
    assert embedding.n_nodes > 1000
    embedding.save(tmp_path / "sample.npz")
    read = load_embedding(tmp_path / "sample.npz")
    assert_same(read, embedding)
    assert np.array_equal(read.node_mask(), embedding.node_mask())
    assert read.n_links == embedding.n_links
    walks = [finish(random_walk_steps(e, np.random.default_rng(7), WalkSettings(20.0))) for e in (read, embedding)]
    assert_same(*(walk.states for walk in walks))
    # Clips of one skeleton still share it, and what the embedding is part of can go on.
    assert len({id(clip.skeleton) for clip in read.graph.clips}) == len({id(c.skeleton) for c in embedding.graph.clips})
    assert embed(read.graph, read.environment, read.settings, previous=read).planes == embedding.planes


def test_a_pruned_embedding_comes_back_pruned():
    embedding = sample_embedding()
    n_headings = embedding.shape[2]
    pruned = finish(restrict_steps(embedding, embedding.nodes.where(lambda plane: plane >= 2 * n_headings)))
    assert 0 < pruned.n_nodes < embedding.n_nodes and not any(pruned.planes[: 2 * n_headings])
    assert_same(embedding_from_bytes(embedding_to_bytes(pruned)), pruned)


def odd_graph() -> MotionGraph:
    """A graph with what the sample's has not: headings, tags on clips, quaternions of every sign, dropped motion."""
    graph, rng = sample_graph(), np.random.default_rng(5)
    clips = []
    for clip in graph.clips[:3]:
        rotations = rng.normal(size=clip.rotations.shape)
        rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
        rotations[0, 0], rotations[1, 0], rotations[2, 0] = (-1, 0, 0, 0), (-0.0, 1, 0, 0), (1e-200, 0, -1, 0)
        rotations[3] *= 1.0004  # as far from unit length as single precision may leave them
        tags = {"jump": rng.random(clip.n_frames) < 0.3, "étape": np.ones(clip.n_frames, dtype=bool)}
        clips.append(
            replace(clip, rotations=rotations, tags=tags, first_frame=17.25, heading=rng.normal(size=clip.n_frames))
        )
    inside = np.flatnonzero([segment.clip < 3 for segment in graph.segments])
    segments = tuple(
        replace(graph.segments[i], tags={"étape": np.ones(graph.segments[i].n_frames, dtype=bool)}) for i in inside
    )
    assert len(segments) > 3
    return MotionGraph(
        tuple(clips),
        30.0,
        segments[:-1],
        np.array([[0, 1], [1, 0]]),
        np.array([0.1, np.pi]),
        graph.dropped,
        0.25,
        segments[-1:],
        np.array([[0, len(segments) - 1]]),
    )


def test_motion_graphs_come_back_to_the_last_bit(tmp_path):
    for graph in (sample_graph(), odd_graph(), random_problem(3, False)[0]):
        raw = graph_to_bytes(graph)
        assert_same(graph_from_bytes(raw), graph)
        assert graph_to_bytes(graph_from_bytes(raw)) == raw
    save_motion_graph(odd_graph(), tmp_path / "odd.npz")
    assert_same(load_motion_graph(tmp_path / "odd.npz"), odd_graph())


def test_recorded_motion_takes_no_more_room_than_it_must(data_folder):
    graph = recorded_graph(data_folder)
    raw = graph_to_bytes(graph)
    assert_same(graph_from_bytes(raw), graph)
    assert len(raw) < 0.46 * sum(clip.rotations.nbytes + clip.translations.nbytes for clip in graph.clips)


def test_other_programs_can_open_the_file_without_pickles(tmp_path):
    sample_embedding().save(tmp_path / "sample.npz")
    with np.load(tmp_path / "sample.npz", allow_pickle=False) as file:
        header = json.loads(file["header"].tobytes())
        assert {name: [file[name].dtype.str, list(file[name].shape)] for name in header["arrays"]} == header["arrays"]
        assert set(file.files) == {"header", *header["arrays"], "checksum"}
        assert np.array_equal(file["blocked"], sample_embedding().environment.blocked)
    assert (header["format"], header["version"]) == ("wayfarer embedding", 2)


@cache
def small_archives() -> list[tuple[bytes, object, object]]:
    """(bytes, value, what reads it)"""
    embedding = embed(*random_problem(4, True))
    assert embedding.n_nodes > 0
    return [
        (embedding_to_bytes(embedding), embedding, embedding_from_bytes),
        (graph_to_bytes(embedding.graph), embedding.graph, graph_from_bytes),
    ]


def value_or_refusal(read, raw):
    """What is read from the bytes, or the error that refuses them; any other error ends the test."""
    try:
        return read(raw, "room.npz")
    except MotionGraphError as error:
        return error


@settings(max_examples=400)
@given(st.sampled_from([0, 1]), st.data())
def test_damaged_bytes_are_refused_or_do_no_harm(which, data):
    """Truncated, flipped, overwritten or lengthened anywhere: an error that names the file, or the very same value."""
    raw, value, read = small_archives()[which]
    damaged = bytearray(raw)
    how = data.draw(st.sampled_from(["cut", "flip", "overwrite", "insert"]))
    place = data.draw(st.integers(0, len(raw) - 1))
    if how == "cut":
        del damaged[place:]
    elif how == "flip":
        damaged[place] ^= 1 << data.draw(st.integers(0, 7))
    else:
        new = data.draw(st.binary(min_size=1, max_size=20))
        damaged[place : place + (len(new) if how == "overwrite" else 0)] = new
    found = value_or_refusal(read, bytes(damaged))
    if isinstance(found, MotionGraphError):
        assert type(found) is (EmbeddingError if which == 0 else MotionGraphError)
        assert "'room.npz'" in str(found)
    else:
        # Dates and the like do not matter.
        assert how != "cut"
        assert_same(found, value)


@settings(max_examples=200)
@given(st.binary(max_size=300))
def test_other_files_are_refused(raw):
    for read, error in ((embedding_from_bytes, EmbeddingError), (graph_from_bytes, MotionGraphError)):
        with pytest.raises(error, match=r"'scene\.npz' is damaged or no"):
            read(raw, "scene.npz")


def test_files_of_other_programs_formats_and_versions_are_refused(tmp_path):
    for arrays in ({"a": np.arange(3)}, {"header": np.arange(3)}, {"header": np.frombuffer(b"{}", dtype=np.uint8)}):
        np.savez(tmp_path / "other.npz", **arrays)
        with pytest.raises(EmbeddingError, match=r"other\.npz' is damaged or no embedding"):
            load_embedding(tmp_path / "other.npz")
    pickled = np.array([print], dtype=object)
    np.savez(tmp_path / "pickled.npz", header=pickled)
    with pytest.raises(EmbeddingError, match="damaged or no"):
        load_embedding(tmp_path / "pickled.npz")
    with pytest.raises(EmbeddingError, match=r"'graph\.npz' holds a motion graph and no embedding"):
        embedding_from_bytes(graph_to_bytes(sample_graph()), "graph.npz")
    later = archive_to_bytes(ArchiveFormat("embedding", 3, EmbeddingError), {}, {})
    with pytest.raises(EmbeddingError, match=r"'new\.npz' was saved by a later version.*format 3"):
        embedding_from_bytes(later, "new.npz")


def test_no_more_is_unpacked_than_the_file_can_hold():
    form = ArchiveFormat("test", 1, MotionGraphError)

    def read(raw):
        return archive_from_bytes(form, raw, "bomb.npz", lambda _, arrays: arrays)

    zeros = archive_to_bytes(form, {}, {"zeros": np.zeros(500_000)})
    assert len(zeros) < 10_000 and read(zeros)["zeros"].nbytes == 4_000_000

    def changed(header_of, replaced):
        """The archive with another header, and its members replaced, but their checks in order."""
        out = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(zeros)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                data = old.read(name)
                if name == "header.npy":
                    text = json.dumps(header_of(json.loads(data[data.index(b"\n") + 1 :]))).encode()
                    start = io.BytesIO()
                    np.lib.format.write_array(start, np.frombuffer(text, dtype=np.uint8))
                    data = start.getvalue()
                new.writestr(name, replaced.get(name, data))
        return out.getvalue()

    assert read(changed(lambda header: header, {}))["zeros"].nbytes == 4_000_000
    huge = changed(lambda header: {**header, "arrays": {"zeros": ["<f8", [10**12]]}}, {})
    with pytest.raises(MotionGraphError, match="announces more"):
        read(huge)
    for shape in ([-1], [500_001], [499_999], "x", [2.5e400]):
        with pytest.raises(MotionGraphError, match="damaged"):
            read(changed(lambda header, shape=shape: {**header, "arrays": {"zeros": ["<f8", shape]}}, {}))
    with pytest.raises(MotionGraphError, match="damaged"):
        read(changed(lambda header: {**header, "arrays": {"zeros": ["|O", [1]]}}, {}))
    with pytest.raises(MotionGraphError, match="damaged"):
        read(changed(lambda header: header, {"zeros.npy": bytes(10_000_000)}))
    with pytest.raises(MotionGraphError, match="checksum"):
        read(changed(lambda header: {**header, "content": {"a": 1}}, {}))


@pytest.mark.parametrize("with_checksum", [False, True])
def test_files_of_earlier_versions_are_refused(with_checksum):
    """With a sentence that says so, however else they were made; the last ones had their checksum in the header."""
    for read, name, error in (
        (embedding_from_bytes, "embedding", EmbeddingError),
        (graph_from_bytes, "motion graph", MotionGraphError),
    ):
        header = {
            "format": f"wayfarer {name}",
            "version": 1,
            "arrays": {"a": ["<f8", [3]]},
            "content": {},
            "sha256": "",
        }
        raw = io.BytesIO()
        encoded = {"header": np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), "a": np.zeros(24, np.uint8)}
        np.savez_compressed(raw, **encoded, **({"checksum": np.zeros(32, np.uint8)} if with_checksum else {}))
        with pytest.raises(error, match=r"'old\.npz' was saved by an earlier version of Wayfarer .*make it anew"):
            read(raw.getvalue(), "old.npz")


@settings(max_examples=200)
@given(st.data())
def test_values_that_do_not_fit_together_are_refused(data):
    """A made-up archive, sound as a file: any array or entry may be missing or another one."""
    embedding = small_archives()[0][1]
    content, arrays = fields_to_arrays(*embedding.fields)
    content = json.loads(json.dumps(content))
    if data.draw(st.booleans()):
        name = data.draw(st.sampled_from(sorted(arrays)))
        changed = arrays[name].copy()
        how = data.draw(st.sampled_from(["missing", "longer", "shorter", "flat", "huge", "negative"]))
        if how == "missing":
            del arrays[name]
        elif how in ("huge", "negative"):
            if changed.dtype == bool or changed.size == 0 or np.issubdtype(changed.dtype, np.floating):
                return
            changed.flat[data.draw(st.integers(0, changed.size - 1))] = (
                255 if changed.dtype == np.uint8 else (-(10**15) if how == "negative" else 10**15)
            )
            if np.array_equal(changed, arrays[name]):
                return
            arrays[name] = changed
        elif how == "longer":
            arrays[name] = np.concatenate([changed, changed, np.zeros((1, *changed.shape[1:]), changed.dtype)])
        else:
            arrays[name] = changed[:-1] if how == "shorter" else changed.reshape(1, -1)
    else:
        entry = data.draw(st.sampled_from(sorted(content)))
        content[entry] = data.draw(st.sampled_from([None, -1, [], {}, "x", [None], [[-1, 2]], 10**30]))
    raw = archive_to_bytes(EMBEDDING_FORMAT, content, arrays)
    found = value_or_refusal(embedding_from_bytes, raw)
    if isinstance(found, MotionGraphError):
        assert "'room.npz'" in str(found)
    else:
        # What is not refused must be an embedding that can be worked with.
        assert found.n_links >= 0 and found.node_mask().shape == found.shape


@pytest.mark.parametrize("name", ["stencil_segment", "stencil_heading", "stencil_dx", "sweep_bounds", "sweep_shift"])
def test_fractions_in_place_of_whole_numbers_are_refused(name):
    content, arrays = fields_to_arrays(*sample_embedding().fields)
    raw = archive_to_bytes(EMBEDDING_FORMAT, content, {**arrays, name: arrays[name].astype(float)})
    with pytest.raises(EmbeddingError, match=r"'embedding'"):
        embedding_from_bytes(raw)


@pytest.mark.parametrize("name", ["stencil_dx", "stencil_dy", "sweep_shift"])
def test_the_smallest_integer_is_no_step(name):
    """Its absolute value overflows to itself; shifting a plane by it would take all memory."""
    content, arrays = fields_to_arrays(*sample_embedding().fields)
    changed = arrays[name].copy()
    changed[0] = np.iinfo(np.int64).min
    with pytest.raises(EmbeddingError, match=r"'embedding'"):
        embedding_from_bytes(archive_to_bytes(EMBEDDING_FORMAT, content, {**arrays, name: changed}))


def test_saving_keeps_the_old_file_until_the_new_one_is_complete(tmp_path, monkeypatch):
    path = tmp_path / "room.npz"
    first, second = sample_embedding(), embed(*random_problem(4, True))
    first.save(path)
    with pytest.raises(EmbeddingError, match="cannot be saved"):
        first.save(tmp_path / "no folder" / "room.npz")
    with pytest.raises(EmbeddingError, match=r"nowhere\.npz' cannot be read"):
        load_embedding(tmp_path / "nowhere.npz")

    def full(_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full)
        with pytest.raises(EmbeddingError, match="the disk is full"):
            second.save(path)
    assert_same(load_embedding(path), first)
    second.save(path)
    assert_same(load_embedding(path), second)
    assert [file.name for file in tmp_path.iterdir()] == ["room.npz"]
