"""The distance scale from measured moves, and when a value counts as observed."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.mapping.odometry.calibration import DistanceScale, calibration_state
from topomap.mapping.odometry.increments import Calibration


def estimator(scale: float, seed: int, moves: int = 60, wrong: float = 0.0) -> DistanceScale:
    """Moves of 0.5 m with 3 % noise, a share of them measured quite wrong."""
    rng, found = np.random.default_rng(seed), DistanceScale()
    for _ in range(moves):
        measured = 0.5 * (1.0 if rng.random() >= wrong else 1.15)
        found.add(0.5 * scale + rng.normal(0.0, 0.015), measured, 0.015)
    return found


@pytest.mark.parametrize("scale", [0.9, 0.95, 1.0, 1.08])
def test_the_scale_is_found_within_its_sigma(scale: float) -> None:
    off = []
    for seed in range(20):
        found = estimator(scale, seed).estimate()
        assert found.observed
        off.append((found.value - scale) / found.sigma)
    assert np.sqrt(np.mean(np.square(off))) < 1.3
    assert abs(np.mean(off)) < 0.6


def test_wrong_measurements_barely_bend_it() -> None:
    found = estimator(0.95, 3, wrong=0.2).estimate()
    assert found.value == pytest.approx(0.95, abs=0.015)


def test_nothing_measured_is_unobserved() -> None:
    for moves in (0, 5):
        found = estimator(0.95, 0, moves=moves).estimate()
        assert (found.value, found.sigma, found.observed) == (1.0, 0.1, False)


def test_a_value_is_observed_once_its_sigma_has_halved() -> None:
    state = calibration_state(Calibration(1.04, 0.003, 0.95), np.diag([0.01, 0.009, 0.04]) ** 2, (0.05, 0.01, 0.1))
    assert state.rotation_scale.observed
    assert state.rotation_scale.sigma == pytest.approx(0.0104)
    assert not state.curvature.observed
    assert state.distance_scale.observed


@pytest.mark.parametrize("bias", [0.01, 0.03])
def test_what_all_moves_err_by_alike_stays_however_many_there_are(bias: float) -> None:
    rng, found = np.random.default_rng(0), DistanceScale()
    for _ in range(1000):
        found.add(0.5 + rng.normal(0.0, 0.01), 0.5, 0.01, bias)
    assert found.estimate().sigma == pytest.approx(bias, rel=0.1)


def test_what_is_vague_counts_for_as_much_as_it_tells() -> None:
    rng, found = np.random.default_rng(0), DistanceScale()
    for _ in range(1000):
        found.add(0.45 + rng.normal(0.0, 0.01), 0.5, 0.01, 0.1)
    told = found.estimate()
    assert not told.observed
    assert told.value == pytest.approx(0.95, abs=0.003)
    assert told.sigma == pytest.approx(0.0707, abs=0.001)
