"""What is read is a regular file of a known size; what is written is whole, and only what is ours is replaced."""

import base64
import contextlib
import errno
import hashlib
import io
import json
import os
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

from core.archive import archive_from_bytes, archive_to_bytes
from core.errors import EmbeddingError, MotionGraphError, StorageError, StudyError
from core.files import (
    LIST_FILE,
    check_folder,
    from_json,
    inflate,
    is_sealed,
    read_arrays,
    read_regular,
    remove_files,
    why,
    write_alone,
    write_files,
    write_whole,
)
from core.motion.graph_archive import GRAPH_FORMAT, graph_to_arrays, load_motion_graph
from core.parcels.set_file import read_set
from core.parcels.work import Work
from core.study.case import result_from_json
from core.study.clip_set import holds_motion_graph
from core.study.plan import read_plan
from core.study.sources import CLIPS, SCENES, check_study_folder

from .motion_graphs import sample_graph
from .studies import lay_out, run_study

unix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names")


def content(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@contextlib.contextmanager
def peak_memory(n_bytes: int):
    """See that a block never holds more than so many bytes."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < n_bytes
    finally:
        tracemalloc.stop()


# ------------------------------------------------------------------------------------------------ writing


def test_what_was_written_before_is_replaced_and_removed(tmp_path):
    for text in (b"one", b"two", b"two"):
        write_files(tmp_path, {"a.txt": text, "sub/b.txt": text})
        assert (tmp_path / "a.txt").read_bytes() == (tmp_path / "sub" / "b.txt").read_bytes() == text
    remove_files(tmp_path, ["a.txt", "absent.txt"])
    assert set(content(tmp_path)) == {LIST_FILE, "sub/b.txt"}
    assert set(json.loads((tmp_path / LIST_FILE).read_text())) == {"sub/b.txt"}


def test_what_is_not_ours_stays(tmp_path):
    write_files(tmp_path, {"a.txt": b"ours", "b.txt": b"ours"})
    (tmp_path / "b.txt").write_text("changed since")
    (tmp_path / "c.txt").write_text("never ours")
    (tmp_path / "d.txt").mkdir()
    before = content(tmp_path)
    for name in ("b.txt", "c.txt", "d.txt"):
        with pytest.raises(StorageError, match=f"holds a '{name}' that Wayfarer did not write.*Nothing was written"):
            write_files(tmp_path, {"a.txt": b"new", name: b"new"})
        assert content(tmp_path) == before
    remove_files(tmp_path, ["b.txt", "c.txt", "d.txt"])
    assert (tmp_path / "b.txt").read_text() == "changed since" and (tmp_path / "c.txt").exists()


def test_a_list_that_is_not_ours_stays(tmp_path):
    for text in ("a diary", "[1, 2]", "[" * 100_000):
        (tmp_path / LIST_FILE).write_text(text)
        with pytest.raises(StorageError, match="is no list of files"):
            write_files(tmp_path, {"a.txt": b"new"})
        assert content(tmp_path) == {LIST_FILE: text.encode()}


def test_links_are_not_followed(tmp_path):
    mine, out = tmp_path / "mine", tmp_path / "out"
    mine.mkdir()
    out.mkdir()
    (mine / "a.txt").write_bytes(b"mine")
    (out / "linked").symlink_to(mine)
    (out / "a.txt").symlink_to(mine / "a.txt")
    (out / "dangling.txt").symlink_to(mine / "new.txt")
    (out / "loop").symlink_to(out / "loop")
    # Even if the content is what was written before.
    known = [hashlib.sha256(b"mine").hexdigest()]
    (out / LIST_FILE).write_text(json.dumps({"a.txt": known, "linked/a.txt": known}))
    for name in ("a.txt", "dangling.txt", "linked/a.txt", "linked/new.txt", "loop/a.txt", "loop"):
        with pytest.raises(StorageError, match="Nothing was written"):
            write_files(out, {name: b"new"})
    with pytest.raises(StorageError, match="is a link"):
        remove_files(out, ["linked/a.txt"])
    remove_files(out, ["a.txt"])
    assert content(mine) == {"a.txt": b"mine"} and (out / "a.txt").is_symlink()


def test_whatever_stops_the_writing_leaves_only_what_we_know_again(tmp_path, monkeypatch):
    write_files(tmp_path, {"a.txt": b"old", "b.txt": b"old"})
    replace, n_left = os.replace, [2]

    def failing(source, target):
        n_left[0] -= 1
        if n_left[0] < 0:
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", failing)
    with pytest.raises(StorageError, match="the disk is full"):
        write_files(tmp_path, {"a.txt": b"new", "b.txt": b"new"})
    monkeypatch.undo()
    assert (content(tmp_path)["a.txt"], content(tmp_path)["b.txt"]) == (b"new", b"old")
    assert not list(tmp_path.glob(".writing*"))
    write_files(tmp_path, {"a.txt": b"last", "b.txt": b"last"})


def test_a_file_that_stands_alone(tmp_path):
    path = tmp_path / "numbers.json"
    write_alone(path, {"nodes": 1})
    write_alone(path, {"nodes": 2, "share": 0.1})
    assert json.loads(path.read_text())["nodes"] == 2 and is_sealed(path.read_bytes())
    for text in (path.read_text().replace("2", "3", 1), "{}", "[]", "mine", "[" * 100_000):
        path.write_text(text)
        with pytest.raises(StorageError, match="choose another name, or move it away"):
            write_alone(path, {"nodes": 4})
        assert path.read_text() == text
    path.unlink()
    (tmp_path / "mine.json").write_text("mine")
    path.symlink_to(tmp_path / "mine.json")
    with pytest.raises(StorageError, match="Nothing was written"):
        write_alone(path, {"nodes": 4})


def test_names_that_no_file_can_have(tmp_path):
    for name in ("a\0b", "x" * 300):
        with pytest.raises(StorageError, match="cannot be written"):
            write_files(tmp_path, {name: b"new"})


def test_a_study_leaves_what_is_not_its_own(tmp_path):
    study = lay_out(tmp_path)
    out, mine = tmp_path / "out", tmp_path / "mine"
    mine.mkdir()
    out.mkdir()
    (mine / "note.txt").write_text("mine")
    for name in ("read", "cases", "graphs", "inputs", "large", "maps"):
        (out / name).symlink_to(mine)
        with pytest.raises(StudyError, match=f"{name}' is a link"):
            run_study(study, out)
        (out / name).unlink()
    (out / "read").mkdir()
    for kind in (SCENES, CLIPS):
        (out / "read" / kind).symlink_to(mine)
        with pytest.raises(StorageError, match="is a link"):
            check_study_folder(out)
        (out / "read" / kind).unlink()
    for name in ("results.csv", "results.html"):
        (out / name).write_text("mine")
        with pytest.raises(StudyError, match=f"holds a '{name}' that Wayfarer did not write"):
            run_study(study, out)
        (out / name).unlink()
    run_study(study, out)
    case = sorted((out / "cases").glob("*.json"))[0]
    case.write_text("mine")
    with pytest.raises(StudyError, match="is in the way"):
        run_study(study, out)
    assert case.read_text() == "mine" and content(mine) == {"note.txt": b"mine"}


# ------------------------------------------------------------------------------------------------ reading


@unix
def test_devices_and_pipes_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for name in ("pipe", "zero", "loop", "absent", ".", "nul\0"):
        path = tmp_path / name
        for read in (read_regular, read_arrays):
            with pytest.raises(OSError, match=r"no file|No such|symbolic|larger") as caught:
                read(path)
            assert caught.value.strerror
        with pytest.raises(MotionGraphError, match="cannot be read"):
            load_motion_graph(path)
        with pytest.raises(StudyError, match="cannot be read"):
            read_plan(path)
        with pytest.raises(EmbeddingError, match="cannot be read"):
            read_set(path, 1, 1)
        assert not holds_motion_graph(path)
    for name in ("pipe", "zero", "loop"):
        with pytest.raises(StorageError, match="did not write"):
            check_folder(tmp_path, [name])


@unix
def test_larger_files_than_allowed_are_not_read(tmp_path):
    with open(tmp_path / "large", "wb") as file:
        file.truncate(10**12)  # of which nothing lies on the disk
    with pytest.raises(OSError, match="larger than"):
        read_regular(tmp_path / "large")


@pytest.fixture(scope="module")
def bomb() -> bytes:
    """Zlib data of a billion zeros."""
    packing = zlib.compressobj(9)
    block = bytes(10_000_000)
    return b"".join(packing.compress(block) for _ in range(100)) + packing.flush()


def test_no_more_is_unpacked_than_was_expected(bomb):
    with peak_memory(50_000_000), pytest.raises(ValueError, match="does not hold what it announces"):
        inflate(bomb, 1000)
    found = {"numbers": {}, "remarks": [], "seconds": 0.0}
    picture = {"levels": base64.b64encode(bomb).decode(), "cell_size": 1.0}
    for shape in ([120, 120], [10**6, 10**6], [-1, -1]):
        with peak_memory(50_000_000), pytest.raises(ValueError, match=r"small map|announces"):
            result_from_json({**found, "picture": {**picture, "shape": shape}})


def test_sets_of_another_size_are_not_unpacked(tmp_path, bomb):
    head = b"WFSET1\n\0" + np.array([1000, 1_000_000, zlib.crc32(bomb)], "<u4").tobytes()
    (tmp_path / "0.set").write_bytes(head + bomb)
    for size in ((1000, 1_000), (1, 1)):
        with peak_memory(50_000_000), pytest.raises(EmbeddingError, match="is damaged"):
            read_set(tmp_path / "0.set", *size)


def test_archives_make_no_more_than_a_file_of_their_size_holds():
    """Deflate makes a thousand zeros one byte: few bytes announce many."""
    facts, arrays = graph_to_arrays(sample_graph())
    raw = archive_to_bytes(GRAPH_FORMAT, facts, {**arrays, "more": np.zeros(500_000_000, dtype=bool)})
    assert len(raw) < 3_000_000
    with peak_memory(50_000_000), pytest.raises(MotionGraphError, match="more than a file of its size can hold"):
        archive_from_bytes(GRAPH_FORMAT, raw, "bomb", lambda *_: None)


def test_arrays_are_as_large_as_they_announce(tmp_path):
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**10,)})
    for name, member in (("header", head.getvalue()), ("zeros", bytes(10_000_000))):
        path = tmp_path / f"{name}.npz"
        for inside in ("a.npy", "header.npy"):
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr(inside, member)
            with peak_memory(50_000_000), pytest.raises(ValueError, match=r"announces|file of its size|magic"):
                read_arrays(path)
            with peak_memory(50_000_000):
                assert not holds_motion_graph(path)
    rng = np.random.default_rng(0)
    arrays = {"a": rng.random((3, 4)), "b": np.asfortranarray(rng.random((3, 4))), "c": rng.random(5) > 0.5}
    np.savez_compressed(tmp_path / "sound.npz", **arrays)
    found = read_arrays(tmp_path / "sound.npz")
    assert set(found) == set(arrays) and all(np.array_equal(found[name], arrays[name]) for name in arrays)


def test_json_that_is_nested_too_deeply_is_no_json(tmp_path):
    for text in ("[" * 200_000, '{"a":' * 200_000, "1" * 5000 + "x", "nonsense"):
        with pytest.raises(ValueError, match=r"deeply|limit|value"):
            from_json(text)
    (tmp_path / "journal.json").write_text("[" * 200_000)

    class Problem:
        folder = tmp_path

    with pytest.raises(EmbeddingError, match=r"journal\.json' is damaged"):
        Work(Problem(), None)


def test_what_the_system_says_of_a_file_comes_in_our_words(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    told = {
        tmp_path / "nowhere": "there is no such file or folder",
        tmp_path / "file" / "below": "a part of its path is a file, and no folder",
        tmp_path: "it is a folder or a device, and no file",
        tmp_path / ("long" * 100): "its name is too long",
        tmp_path / "zero\0": "no file can have such a name",
    }
    for path, reason in told.items():
        with pytest.raises(OSError) as caught:  # noqa: PT011 (its kind is what is tested)
            read_regular(path)
        assert why(caught.value) == reason
    # All that Python's own words would be quoted for.
    for number in errno.errorcode:
        assert os.strerror(number).lower() not in why(OSError(number, os.strerror(number))).lower()
    assert why(OSError("Blender's words")) == why(OSError(errno.EDOM, "")) and "not known" in why(OSError())


def test_a_folder_that_nobody_may_write_to_is_told(tmp_path):
    path = tmp_path / "nested" / "a.txt"
    (tmp_path / "nested").write_bytes(b"")
    with pytest.raises(StorageError, match=r"a part of its path|something of that name"):
        write_whole(path, b"new")
