"""The tests' own BVH reader: on a hand-made file, and on recorded walks where they are present."""

import os
from pathlib import Path

import numpy as np
import pytest

from tests.core.bvh import read_bvh

DATA = Path(os.environ.get("WAYFARER_DATA", Path(__file__).parents[2] / ".." / "shared" / "data")) / "cmu16"

SMALL = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT LeftUpLeg
  {
    OFFSET 1 -1 0
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0 -5 0
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -1 -1 0
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0 -5 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.05
0 10 0 0 0 0 0 0 0 0 0 0
0 10 3 0 90 0 0 0 0 0 0 0
"""


def test_hand_made_file(tmp_path):
    path = tmp_path / "small.bvh"
    path.write_text(SMALL)
    clip = read_bvh(path, scale=0.1)
    assert clip.name == "small" and clip.frame_rate == 20
    assert clip.skeleton.names == ("Hips", "LeftUpLeg", "RightUpLeg")
    np.testing.assert_allclose(clip.skeleton.forward, [0, 0, 1])
    _, positions = clip.world
    # BVH's Z, its forward, is -Y; its left, X, stays X.
    np.testing.assert_allclose(positions[0], [[0, 0, 1], [0.1, 0, 0.9], [-0.1, 0, 0.9]], atol=1e-12)
    # A quarter turn to the left about the vertical: from facing -Y to facing +X, the left leg at +Y.
    np.testing.assert_allclose(positions[1], [[0, -0.3, 1], [0, -0.2, 0.9], [0, -0.4, 0.9]], atol=1e-12)
    np.testing.assert_allclose(clip.ground_path, [[0, 0, -np.pi / 2], [0, -0.3, 0]], atol=1e-12)


def test_dropped_frames(tmp_path):
    path = tmp_path / "small.bvh"
    path.write_text(SMALL.replace("Frames: 2", "Frames: 3") + "0 10 6 0 90 0 0 0 0 0 0 0\n")
    clip = read_bvh(path, scale=1, drop_first=1)
    assert clip.n_frames == 2 and clip.first_frame == 1
    np.testing.assert_allclose(clip.translations[:, 0, 1], [-3, -6])


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no motion data at {DATA} (see WAYFARER_DATA)")
def test_recorded_walk():
    clip = read_bvh(DATA / "16_16.bvh")
    assert clip.n_frames == 510 and clip.frame_rate == 120 and clip.skeleton.n_joints == 31
    x, y, heading = clip.ground_path.T
    assert np.hypot(x[-1] - x[0], y[-1] - y[0]) == pytest.approx(4.31, abs=0.02)
    travel = np.arctan2(y[-1] - y[0], x[-1] - x[0])
    assert abs(np.angle(np.exp(1j * (travel - heading.mean())))) < np.radians(10)
    _, positions = clip.world
    heights = positions[:, :, 2]
    assert 0.9 < heights[:, 0].mean() < 1.05
    assert np.all(heights.min(axis=1) > -0.05) and 1.4 < heights.max() < 1.9


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no motion data at {DATA} (see WAYFARER_DATA)")
def test_recorded_turn_is_to_the_right():
    heading = read_bvh(DATA / "16_19.bvh").ground_path[:, 2]
    assert np.degrees(heading[-1] - heading[0]) == pytest.approx(-91, abs=3)
