"""Mutated files of every format that is read: what they say, or a sentence; no traceback, no hang, little memory.

Each format is tried in a process of its own, which measures its slowest file and its memory. WAYFARER_FUZZ=900 tries
some ten thousand files of each, WAYFARER_FUZZ_SEED another set of them.
"""

import io
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from core.embedding.archive import embedding_to_bytes, load_embedding
from core.embedding.embedding import embed
from core.errors import MotionGraphError, StorageError
from core.export.engine_format import engine_files_steps
from core.files import LIST_FILE, check_folder, write_files
from core.maps.legend import ColorBar, MapLegend, Swatch
from core.motion.bvh.character import understand_bvh_steps
from core.motion.bvh.clip import bvh_clip_steps
from core.motion.bvh.reader import load_bvh_steps
from core.motion.graph_archive import graph_to_bytes, load_motion_graph
from core.motion.repertoire import sample_repertoire
from core.parcels.set_file import read_set, write_set
from core.progress import finish
from core.study.clip_set import ClipSet, clip_set_to_bytes, load_clip_set
from core.study.geometry import load_scene, scene_to_bytes
from core.study.plan import read_plan

from .bvh_writer import bvh_text
from .reference import random_problem
from .studies import region, room

ROOT = Path(__file__).resolve().parents[2]
EFFORT, SEED = (
    int(os.environ.get(name, default)) for name, default in (("WAYFARER_FUZZ", "1"), ("WAYFARER_FUZZ_SEED", "0"))
)
N_FILES = 12
SECONDS, MEGABYTES = 10.0, 500.0

NUMBERS = (
    b"0",
    b"-1",
    b"1e308",
    b"-1e999",
    b"nan",
    b"inf",
    b"99999999999999999999",
    b"9" * 5000,
    b"1_000",
    b"0x10",
    b"",
)
WORDS = (
    b"\0",
    b"\xff\xfe",
    b"[" * 100_000,
    b"{" * 5000,
    b"../../x",
    b"=cmd()",
    b"\xe2\x80\xae",
    b"'",
    b'"',
    b"\r",
    b"true",
    b"null",
)


# ---------------------------------------------------------------------------------------------- mutations


def mutated(raw: bytes, rng: np.random.Generator) -> bytes:
    """Return a file that is almost the given one: its text, its members or its bytes changed here and there."""
    if raw.startswith(b"PK") and rng.random() < 0.8:
        return _mutated_archive(raw, rng)
    change = _mutated_text if _is_text(raw) and rng.random() < 0.85 else _mutated_bytes
    for _ in range(rng.integers(1, 4)):
        raw = change(raw, rng)
    return raw


def _is_text(raw: bytes) -> bool:
    return b"\0" not in raw[:2000]


def _mutated_text(raw: bytes, rng: np.random.Generator) -> bytes:
    tokens = re.split(rb"(\s+|[\[\]{}(),:=])", raw)
    at = int(rng.integers(len(tokens)))
    numbers = [i for i, token in enumerate(tokens) if re.fullmatch(rb"-?[\d.]+(e-?\d+)?", token)]
    kind = rng.integers(7)
    if kind == 0 and numbers:
        tokens[rng.choice(numbers)] = NUMBERS[rng.integers(len(NUMBERS))]
    elif kind == 1:
        tokens[at] = WORDS[rng.integers(len(WORDS))]
    elif kind == 2:
        other = int(rng.integers(len(tokens)))
        tokens[at], tokens[other] = tokens[other], tokens[at]
    elif kind == 3:
        del tokens[at : at + int(rng.integers(1, 20))]
    elif kind == 4:
        tokens[at:at] = tokens[at : at + int(rng.integers(1, 40))] * int(rng.integers(1, 50))
    elif kind == 5:
        return (
            b"".join(tokens)
            .decode("utf-8", "replace")
            .encode(("utf-16", "utf-32", "cp932")[rng.integers(3)], "replace")
        )
    else:
        return _mutated_bytes(raw, rng)
    return b"".join(tokens)


def _mutated_bytes(raw: bytes, rng: np.random.Generator) -> bytes:
    data, at = bytearray(raw), int(rng.integers(max(len(raw), 1)))
    kind = rng.integers(5)
    if kind == 0 and data:
        data[at] ^= 1 << int(rng.integers(8))
    elif kind == 1:
        del data[at:]
    elif kind == 2:
        # A count of something, as far as it can go.
        data[at : at + 8] = (b"\xff" * 8, b"\0" * 8, b"\x7f" + b"\xff" * 7, b"\xff\xff\xff\x7f" + b"\0" * 4)[
            rng.integers(4)
        ]
    elif kind == 3:
        data[at:at] = data[at : at + int(rng.integers(1, 200))]
    else:
        data[at : at + int(rng.integers(1, 50))] = b""
    return bytes(data)


def _mutated_archive(raw: bytes, rng: np.random.Generator) -> bytes:
    """Change one member of an archive, and pack it in order again: its header, its text, its numbers or its name."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        victim = int(rng.integers(len(old.namelist())))
        for number, name in enumerate(old.namelist()):
            data = old.read(name)
            if number == victim:
                head, body = data[: data.index(b"\n") + 1], data[data.index(b"\n") + 1 :]
                kind = rng.integers(5)
                if kind == 0:
                    shape = (10**11, -1, 0, 2**63, 7)[rng.integers(5)]
                    start = io.BytesIO()
                    known = {
                        "descr": ("|u1", "<f8", "<i4", "|O", "<U9")[rng.integers(5)],
                        "fortran_order": bool(rng.integers(2)),
                    }
                    np.lib.format.write_array_header_1_0(start, {**known, "shape": (shape,)})
                    data = start.getvalue() + body
                elif kind == 1:
                    data = head + _mutated_text(body, rng) if _is_text(body) else head + _mutated_bytes(body, rng)
                elif kind == 2:
                    data = bytes(50_000_000)
                elif kind == 3:
                    continue
                else:
                    data = _mutated_bytes(data, rng)
            new.writestr(name, data)
    return out.getvalue()


# ------------------------------------------------------------------------------------------------ formats


def _embedding():
    return next(e for e in (embed(*random_problem(seed, True)) for seed in range(30)) if e.n_nodes)


def _bvh(path: Path) -> None:
    file = finish(load_bvh_steps(path))
    (character,) = finish(understand_bvh_steps([file]))
    finish(bvh_clip_steps(file, character))


def _set(folder: Path) -> tuple[bytes, Callable[[Path], object]]:
    embedding = _embedding()
    n_bytes = max(plane.bit_length() for plane in embedding.planes) // 8 + 1
    write_set(folder / "sound.set", embedding.nodes, n_bytes)
    return (folder / "sound.set").read_bytes(), lambda path: read_set(path, len(embedding.planes), n_bytes)


def _list(folder: Path) -> tuple[bytes, Callable[[Path], object]]:
    write_files(folder / "ours", {"a.txt": b"a", "b.csv": b"b"})

    def read(path: Path) -> None:
        (folder / "ours" / LIST_FILE).write_bytes(path.read_bytes())
        check_folder(folder / "ours", ["a.txt", "b.csv", "c"])

    return (folder / "ours" / LIST_FILE).read_bytes(), read


def _legend(_: Path) -> tuple[bytes, Callable[[Path], object]]:
    bar = ColorBar(((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((0.0, "few"), (1.0, "many")))
    legend = MapLegend("Ways", "", bar, (Swatch((1.0, 0.0, 0.0), "out of reach", "12%"),), (("Cells", "1,200"),))

    def read(path: Path) -> None:
        try:
            MapLegend.from_json(path.read_text("utf-8"))
        except (ValueError, LookupError, TypeError, ArithmeticError) as error:
            # What the painted floor takes for no legend.
            raise StorageError("It is damaged.") from error

    return legend.to_json().encode(), read


def _engine(folder: Path) -> tuple[bytes, Callable[[Path], object]]:
    files = finish(engine_files_steps(_embedding()))
    for name, raw in files.items():
        (folder / name).write_bytes(raw)
    sys.path.insert(0, str(ROOT / "assets" / "engine"))
    import wayfarer_reader

    def read(path: Path) -> None:
        (folder / "embedding.json").write_bytes(path.read_bytes())
        try:
            wayfarer_reader.Embedding(folder)
        except wayfarer_reader.UNSOUND as error:
            raise StorageError("It is damaged.") from error

    return bytes(files["embedding.json"]), read


STUDY = b"""title = "Rooms"
measures = ["nodes", "coverage", {measure = "time_to_reach", position = [1.0, 2.0], radius = 0.5}]
[scenes]
room = "room.npz"
[clips]
walks = {file = "walks.blend", actions = ["walk*"], character = "Hero"}
[settings]
cell_size = [0.1, 0.2]
n_headings = 24
max_cost = 0.3
"""

FORMATS: dict[str, Callable[[Path], tuple[bytes, Callable[[Path], object]]]] = {
    "bvh": lambda _: (bvh_text(sample_repertoire(30)[0]).encode(), _bvh),
    "graph": lambda _: (graph_to_bytes(random_problem(1, False)[0]), load_motion_graph),
    "embedding": lambda _: (embedding_to_bytes(_embedding()), load_embedding),
    "set": _set,
    "study": lambda _: (STUDY, read_plan),
    "scene": lambda _: (scene_to_bytes(room(regions=(region(),))), load_scene),
    "clips": lambda _: (clip_set_to_bytes(ClipSet(tuple(sample_repertoire(30)[:2]))), load_clip_set),
    "list": _list,
    "legend": _legend,
    "engine": _engine,
}


def try_files(name: str, n_files: int, seed: int) -> dict:
    """Read so many mutated files of a format; returns how many were understood, the slowest and the memory (MB)."""
    rng = np.random.default_rng([seed, list(FORMATS).index(name)])
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        sound, read = FORMATS[name](folder)
        path = folder / f"file.{name}"
        path.write_bytes(sound)
        read(path)
        before, understood, slowest = _memory(), 0, 0.0
        for number in range(n_files):
            raw = mutated(sound, rng)
            path.write_bytes(raw)
            start = time.perf_counter()
            try:
                read(path)
                understood += 1
            except MotionGraphError as error:
                said = str(error)
                if not said.endswith(".") or len(said) > 2000:
                    raise ValueError(f"file {number} of {name}, seed {seed}: no sentence: {said[:500]}") from None
            except Exception as error:
                kept = Path(tempfile.gettempdir()) / f"mutated-{name}-{seed}-{number}"
                kept.write_bytes(raw)
                raise ValueError(f"{kept} is not refused by a sentence") from error
            slowest = max(slowest, time.perf_counter() - start)
    return {"understood": understood, "slowest": slowest, "memory": _memory() - before}


def _memory() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000


@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted otherwise here")
@pytest.mark.parametrize("name", FORMATS)
def test_mutated_files_are_understood_or_refused_with_a_sentence(name):
    words = f"print(json.dumps(try_files({name!r}, {N_FILES * EFFORT}, {SEED})))"
    words = f"import json; from tests.core.test_fuzz_files import try_files; {words}"
    result = subprocess.run([sys.executable, "-c", words], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr[-3000:]
    found = json.loads(result.stdout.splitlines()[-1])
    assert found["slowest"] < SECONDS and found["memory"] < MEGABYTES, found
    assert EFFORT == 1 or 0 < found["understood"] < N_FILES * EFFORT
