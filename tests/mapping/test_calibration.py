"""The distance scale from ranges."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.mapping.calibration import RangeScale, calibration_state
from topomap.mapping.odometry import Calibration
from topomap.types import Motion

WIDTH = 720


def down_the_hall(scale: float, seed: int, turn: float = 0.0, outliers: float = 0.0) -> RangeScale:
    rng, estimator = np.random.default_rng(seed), RangeScale()
    for step in range(80):
        x = 0.1 * step
        ranges = np.full(WIDTH, 3.0)
        ranges[:10], ranges[-10:], ranges[350:370] = 9.0 - x, 9.0 - x, 1.0 + x
        ranges += rng.normal(0, 0.01, WIDTH)
        if rng.random() < outliers:
            ranges[:] = rng.uniform(0.5, 9)
        read = 0.1 * scale * (1 + rng.normal(0, 0.01)) if step else 0.0
        estimator.update(Motion(read, 0.0, turn, np.eye(3) * 1e-6, 0.25), ranges.astype(np.float32))
    return estimator


@pytest.mark.parametrize("scale", [0.9, 0.95, 1.0, 1.06])
def test_scale_is_found_within_its_sigma(scale: float) -> None:
    found = [down_the_hall(scale, seed).estimate() for seed in range(4)]
    assert all(f.observed for f in found)
    assert all(abs(f.value - scale) < 3 * f.sigma for f in found)
    assert abs(np.mean([f.value for f in found]) - scale) < 0.01


def test_people_in_the_way_dont_change_it() -> None:
    found = down_the_hall(0.95, 1, outliers=0.15).estimate()
    assert found.observed
    assert abs(found.value - 0.95) < 0.02


def test_unobserved_without_straight_moves_or_ranges() -> None:
    assert not down_the_hall(0.95, 0, turn=0.1).estimate().observed
    blind = RangeScale()
    for _ in range(50):
        blind.update(Motion(0.1, 0.0, 0.0, np.eye(3), 0.25), np.full(WIDTH, np.nan, np.float32))
        blind.update(Motion(0.1, 0.0, 0.0, np.eye(3), 0.25), None)
    assert blind.moves == 0
    assert blind.estimate().value == 1.0


def test_observed_means_half_the_prior() -> None:
    covariance = np.diag([0.02, 0.009, 0.1]) ** 2
    state = calibration_state(Calibration(1.04, 0.003, 0.95), covariance, (0.05, 0.01, 0.1))
    assert (state.rotation_scale.observed, state.curvature.observed) == (True, False)
    assert state.rotation_scale.sigma == pytest.approx(0.0208)
