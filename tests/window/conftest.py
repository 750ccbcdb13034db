"""Runs the session once, in a Blender with a window; the tests look at what came of it."""

import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

import dev

from .blender_window import blender_root, job_folder, run_in_window, why_not_here

HERE = Path(__file__).parent
SCRIPTS = (
    "session.py",
    "making_chapters.py",
    "using_chapters.py",
    "live_chapters.py",
    "asking_chapters.py",
    "delivering_chapters.py",
    "managing_chapters.py",
    "scene_facts.py",
    "hand.py",
    "sidebar.py",
    "editors.py",
    "picture.py",
)
"""Those that Blender runs, the first of which runs the others."""
PICTURES = Path(os.environ.get("WAYFARER_PICTURES") or dev.ROOT / "dist" / "window")
_SECONDS = 3600
"""After which Blender is stopped; it needs a fifteenth of that on a machine that does nothing else."""


@dataclass(frozen=True)
class Session:
    """What is known of a session: facts by chapter, the log, and the folder of the pictures."""

    facts: dict[str, dict]
    code: int | None
    log: str
    pictures: Path

    def chapter(self, name: str) -> dict:
        """The facts of a chapter; the test fails if the session did not get to its end."""
        if name not in self.facts:
            last, found = list(self.facts.items())[-1] if self.facts else ("its start", {})
            pytest.fail(f"the session ended in {last}: {found.get('failed', self.log[-2000:])}")
        if "failed" in self.facts[name]:
            pytest.fail(f"{self.facts[name]['failed']}\nThe screen is in {self.pictures}/failed_in_{name}.png")
        return self.facts[name]


@pytest.fixture(scope="session")
def session() -> Session:
    root = blender_root()
    reason = why_not_here(root)
    if reason:
        pytest.skip(reason)
    found = _run(root)
    if found.code != 0 or any("failed" in facts for facts in found.facts.values()):
        # Once more: a window on a busy machine is at the mercy of others. What is wrong is wrong again.
        found = _run(root)
    return found


def _run(root: Path) -> Session:
    PICTURES.mkdir(parents=True, exist_ok=True)
    for old in PICTURES.glob("*.png"):
        old.unlink()
    with job_folder(root) as job:
        platform, python = dev.this_platform(), dev.main_python()
        dev.build_archive(platform, dev.download_wheels(platform, python), job / "wayfarer.zip", python)
        for name in SCRIPTS:
            shutil.copy(HERE / name, job)
        outcome = run_in_window(root, job, SCRIPTS[0], _SECONDS)
        for picture in job.glob("*.png"):
            shutil.copy(picture, PICTURES)
        written = job / "facts.json"
        facts = json.loads(written.read_text("utf-8")) if written.exists() else {}
        (PICTURES / "facts.json").write_text(json.dumps(facts, indent=1), "utf-8")
        (PICTURES / "blender.log").write_text(outcome.log, "utf-8")
    return Session(facts, outcome.code, outcome.log, PICTURES)
