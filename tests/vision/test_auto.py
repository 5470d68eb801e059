"""The automatic choice: what it picks, how far its confidence can be trusted, and the Python API."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from calibration import measured
from scenes import view

import topomap
from topomap.core.errors import DataError
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.vision.homing.auto import Auto

HOME = Pose2(3.7, 2.8, 0.4)
POSE = Pose2(3.2, 3.3, -1.1)


def bare(panorama: Panorama) -> Panorama:
    return Panorama(panorama.image)


def test_it_picks_by_what_is_there() -> None:
    here, there, near = view(POSE), view(HOME), view(Pose2(3.6, 2.8, 0.4))
    assert Auto().answer(here, there).choice == "epipolar"
    few = Auto(points=1e9)
    assert few.answer(here, there).choice == "range"
    assert few.answer(bare(near), bare(there)).choice == "dtw"
    assert few.answer(bare(here), bare(there)).choice == "warping"
    for choice in (Auto(), few):
        for pair in ((here, there), (bare(here), bare(there)), (bare(near), bare(there))):
            pose = Pose2(3.6, 2.8, 0.4) if pair[0].image is near.image else POSE
            home = choice.answer(*pair).alignment.home
            assert home is not None
            assert abs(wrap(home.bearing - pose.bearing_to(HOME))) < math.radians(20)
            assert home.confidence > 0.5


def test_ranges_give_the_distance() -> None:
    home = Auto().home(view(POSE), view(HOME))
    assert home.distance == pytest.approx(POSE.distance(HOME), rel=0.1)
    assert Auto().home(bare(view(POSE)), bare(view(HOME))).distance is None


def test_confidence_is_the_share_of_right_answers() -> None:
    """On rooms with other seeds than the calibration's, thickets and views of another room among them."""
    results = [(a.alignment.home, right) for a, right in measured(Auto(), range(300, 302), 11)]
    sure = np.array([home.confidence for home, _ in results if home is not None])
    right = np.array([right for _, right in results], float)
    answered = sure > 0.0
    assert answered.mean() > 0.4
    assert right[answered].mean() == pytest.approx(sure[answered].mean(), abs=0.15)
    assert right[sure > 0.9].mean() > 0.9


def test_home_in_five_lines(tmp_path: Path) -> None:
    for name, pose in (("here", POSE), ("goal", HOME)):
        clockwise = np.roll(view(pose).image, 359, axis=1)[:, ::-1, ::-1]  # nose in column 360, BGR
        cv2.imwrite(str(tmp_path / f"{name}.png"), clockwise)
    here, goal = topomap.load_panorama(tmp_path / "here.png"), topomap.load_panorama(tmp_path / "goal.png")
    np.testing.assert_array_equal(here.image, view(POSE).image)
    height, width = here.image.shape[:2]
    assert (here.rig.horizon_row, here.rig.focal) == ((height - 1) / 2, width / TAU)
    assert topomap.load_panorama(tmp_path / "here.png", 40.0).rig.horizon_row == 40.0
    way = topomap.home(here, goal)
    assert abs(wrap(way.bearing - POSE.bearing_to(HOME))) < math.radians(3)
    matched = topomap.home(here, goal, "dtw-unifying")
    assert abs(wrap(matched.bearing - POSE.bearing_to(HOME))) < math.radians(15)
    with pytest.raises(DataError, match="unknown homing method"):
        topomap.home(here, goal, "telepathy")
    with pytest.raises(DataError, match="ranges"):
        topomap.home(here, goal, "area-centroid")


def test_importing_topomap_stays_light() -> None:
    code = "import sys, topomap; print(any(m in sys.modules for m in ('numpy', 'cv2', 'numba')))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"
