"""What all core tests share: the optional motion capture data, and repeatable property tests."""

import os
from pathlib import Path

import hypothesis
import pytest

# The same examples on every run and machine, and no time limits, which noisy machines break.
hypothesis.settings.register_profile("wayfarer", derandomize=True, deadline=None, max_examples=50)
hypothesis.settings.load_profile("wayfarer")


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of recorded motions (cmu16, cmu_locomotion, cmu_obstacle); skips the test without it."""
    beside = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    folder = Path(os.environ.get("WAYFARER_DATA", beside))
    if not folder.is_dir():
        pytest.skip(f"needs the recorded motions, and there is no folder {folder}: set WAYFARER_DATA to theirs")
    return folder
