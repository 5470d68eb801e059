"""Every aligner on geometry: sign, accuracy, prior, and pictures that hold nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import around, view

from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.vision.compass import ALIGNERS, GivenHeading, MinWarpingCompass, VisualCompass
from topomap.vision.matching.difference_kernels import absolute_differences

HOME = Pose2(3.7, 2.8, 0.4)
TOLERANCE = {  # mean error [deg] at 0.5 m, eight directions, any rotation; 0.1 m for the visual compasses
    "visual-compass": (0.1, 5.0),
    "visual-compass-sad": (0.1, 5.0),
    "min-warping": (0.5, 2.0),
    "min-warping-near-compass": (0.5, 2.0),
}


@pytest.mark.parametrize("name", TOLERANCE)
@pytest.mark.parametrize("seed", [1, 2])
def test_rotation_of_displaced_views(name: str, seed: int) -> None:
    distance, limit = TOLERANCE[name]
    errors = [
        wrap(ALIGNERS[name].align(view(p, seed), view(HOME, seed)).rotation - (p.heading - HOME.heading))
        for p in around(HOME, distance)
    ]
    assert math.degrees(float(np.mean(np.abs(errors)))) < limit


@pytest.mark.parametrize("name", ALIGNERS)
@pytest.mark.parametrize("turn", [0.0, 0.5, -2.0, math.pi])
def test_pure_rotation(name: str, turn: float) -> None:
    columns = round(turn * 720 / TAU)
    prior = turn if name == "given" else None
    found = ALIGNERS[name].align(view(HOME).rolled(-columns), view(HOME), prior)
    limit = 1.5 if name.startswith(("min-warping", "auto")) else 0.5  # its columns are 5 degrees wide
    assert abs(wrap(found.rotation - columns * TAU / 720)) < math.radians(limit)


@pytest.mark.parametrize("aligner", [VisualCompass(window=0.4), MinWarpingCompass(window=0.4)])
def test_a_prior_bounds_the_search(aligner: VisualCompass | MinWarpingCompass) -> None:
    for prior in (2.0, -3.1):
        found = aligner.align(view(HOME), view(HOME), prior)
        assert abs(wrap(found.rotation - prior)) < 0.4 + math.radians(6)
        assert found.residual > aligner.align(view(HOME), view(HOME)).residual + 0.1


def test_given_heading_is_the_prior() -> None:
    assert GivenHeading().align(view(HOME), view(HOME), 1.25).rotation == 1.25
    assert GivenHeading().align(view(HOME), view(HOME)).residual == 0.0


@pytest.mark.parametrize("name", ALIGNERS)
def test_empty_pictures_give_no_home(name: str) -> None:
    ranges = view(HOME).ranges
    blank = [Panorama(np.full((100, 720, 3), value, np.uint8), ranges) for value in (0, 128)]
    for current, goal in [(blank[0], blank[1]), (blank[1], view(HOME)), (view(HOME), blank[0])]:
        found = ALIGNERS[name].align(current, goal)
        assert math.isfinite(found.rotation)
        assert math.isfinite(found.residual)
        assert found.home is None or found.home.confidence < 0.05


def test_purity() -> None:
    a, b = view(Pose2(3.2, 2.6, 1.0)), view(HOME)
    image = a.image.copy()
    for aligner in ALIGNERS.values():
        assert aligner.align(a, b) == aligner.align(
            Panorama(image.copy(), a.ranges), Panorama(b.image.copy(), b.ranges)
        )
    assert (a.image == image).all()


def test_absolute_differences_are_those_of_rolling() -> None:
    rng = np.random.default_rng(5)
    a, b = (rng.normal(size=(4, 9)).astype(np.float32) for _ in range(2))
    wanted = [np.abs(b - np.roll(a, k, axis=1)).mean() for k in range(9)]
    np.testing.assert_allclose(absolute_differences(a, b), wanted, rtol=1e-5)
