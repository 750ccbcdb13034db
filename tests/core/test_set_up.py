"""How dev.py makes its folders of packages: by one process at a time, and afresh after an interruption."""

import os
import platform
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import dev

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import sys
from pathlib import Path
import dev
dev.ROOT = Path(sys.argv[1])
print("python:", dev.Venv("venv", [sys.argv[2]], sys.argv[3]).set_up())
"""
RUNNING = platform.python_version().rpartition(".")[0]


def start(folder: Path, requirements: str) -> subprocess.Popen:
    """A dev.py that needs packages (none: nothing is fetched), in a process group of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(folder), RUNNING, requirements],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def said(process: subprocess.Popen) -> str:
    output, _ = process.communicate(timeout=300)
    assert process.returncode == 0, output
    return output


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("checkout")


def test_two_at_once_do_it_once(folder):
    python = folder / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    for requirements, n_made, n_installed in (("# none", 1, 1), ("# other words", 0, 1), ("# other words", 0, 0)):
        outputs = [said(process) for process in [start(folder, requirements) for _ in range(2)]]
        assert all(output.endswith(f"python: {python}\n") for output in outputs)
        both = "".join(outputs)
        assert (both.count("] making"), both.count("] installing")) == (n_made, n_installed), both


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="this system has no process groups to kill")
def test_one_that_was_interrupted_is_made_afresh(folder):
    venv = folder / "venv"
    said(start(folder, "# none"))
    (venv / "wayfarer-installed").rename(venv / "wayfarer-unfinished")
    interrupted = start(folder, "# none")
    assert "removing" in interrupted.stdout.readline() and "making" in interrupted.stdout.readline()
    os.killpg(interrupted.pid, signal.SIGKILL)
    interrupted.wait()
    # Its lock goes with the last process of the group, some of which may still be ending; then nobody waits.
    with dev.only_one(venv / "wayfarer-lock"):
        pass
    output = said(start(folder, "# none"))
    assert "] making" in output and "waiting" not in output
    assert not (venv / "wayfarer-unfinished").exists()


def test_wheels_are_those_that_are_named(tmp_path):
    listed = dev.REQUIREMENTS.read_text("utf-8")
    for name, (_, versions) in dev.WHEEL_TAGS.items():
        for version in versions:
            pattern = dev.wheel_pattern(name, version).replace("*", r"\S*").replace(".whl", r"\.whl")
            assert re.search(rf"(?m)^# [0-9a-f]{{64}}  {pattern}$", listed), (name, version)
    known = tmp_path / re.search(r"(?m)^# [0-9a-f]{64}  (\S+)$", listed)[1]
    known.write_bytes(b"something else")
    with pytest.raises(dev.Trouble, match=r"is not the file that requirements\.txt names"):
        dev.check_wheel(known)
    unknown = known.rename(tmp_path / "scipy-9.9.9-cp311-cp311-win_amd64.whl")
    with pytest.raises(dev.Trouble, match="has no SHA-256"):
        dev.check_wheel(unknown)
    for wheel in dev.WHEELS.glob("*.whl"):
        dev.check_wheel(wheel)
