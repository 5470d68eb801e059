"""Pre-integration, its Jacobian and its covariance; corrections of single motions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topomap.core.errors import ShapeError
from topomap.core.geometry import Pose2, wrap
from topomap.core.records import Motion
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, advance, integrate, track
from topomap.mapping.uncertainty.odometry_chain import Chain

CALIBRATION = Calibration(1.04, 0.01, 0.95)


def wiggle(k: int = 30, seed: int = 0) -> Increments:
    rng = np.random.default_rng(seed)
    deltas = np.column_stack([rng.uniform(0.05, 0.1, k), rng.normal(0, 0.005, k), rng.normal(0.03, 0.1, k)])
    return Increments(np.arange(1, k + 1) * 10, deltas, np.tile(np.diag([1e-5, 1e-6, 1e-4]), (k, 1, 1)))


@given(st.floats(0.8, 1.2), st.floats(-0.02, 0.02), st.floats(0.8, 1.2), st.floats(-0.4, 0.4))
def test_correct_undoes_what_the_odometer_does(r: float, c: float, d: float, turn: float) -> None:
    read = Motion(d * 0.1, d * 0.01, r * turn + c * 0.1, np.eye(3), 0.25)
    true = Calibration(r, c, d).correct(read)
    assert np.allclose([true.forward, true.left, true.turn], [0.1, 0.01, turn])


def test_integration_agrees_with_stepping() -> None:
    read, pose = wiggle(), Pose2()
    for f, s, t in read.deltas:
        pose = advance(pose, CALIBRATION.correct(Motion(f, s, t, np.eye(3), 0.25)))
    delta, _, _ = integrate(read, CALIBRATION)
    assert np.allclose(delta, pose.array(), atol=1e-12)
    assert np.allclose(track(read, CALIBRATION)[-1], pose.array(), atol=1e-12)


def test_split_and_concatenate_are_inverse() -> None:
    read = wiggle()
    first, rest = read.split(11)
    assert (len(first), len(rest)) == (11, 19)
    joined = Increments.concatenate([first, rest])
    assert np.array_equal(joined.deltas, read.deltas)
    a, _, _ = integrate(first, CALIBRATION)
    b, _, _ = integrate(rest, CALIBRATION)
    whole, _, _ = integrate(read, CALIBRATION)
    assert np.allclose((Pose2.of(a) @ Pose2.of(b)).array(), whole)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.floats(0.9, 1.1), st.floats(-0.02, 0.02), st.floats(0.9, 1.1))
def test_jacobian_against_differences(seed: int, r: float, c: float, d: float) -> None:
    read, calibration = wiggle(seed=seed), Calibration(r, c, d)
    _, _, jacobian = integrate(read, calibration)
    for column, step in enumerate(np.eye(3) * 1e-6):
        plus, _, _ = integrate(read, Calibration.of(calibration.vector() + step))
        minus, _, _ = integrate(read, Calibration.of(calibration.vector() - step))
        change = plus - minus
        change[2] = wrap(change[2])
        assert np.allclose(change / 2e-6, jacobian[:, column], atol=1e-5)


def test_covariance_against_draws() -> None:
    read, rng = wiggle(20), np.random.default_rng(1)
    delta, covariance, _ = integrate(read, CALIBRATION)
    sigma = np.sqrt(np.diagonal(read.covariances, axis1=1, axis2=2))
    draws = [
        integrate(Increments(read.stamps_ns, read.deltas + rng.normal(size=(20, 3)) * sigma, read.covariances),
                  CALIBRATION)[0] - delta
        for _ in range(3000)
    ]  # fmt: skip
    assert np.allclose(np.cov(np.array(draws).T), covariance, rtol=0.15, atol=2e-5)


@pytest.mark.parametrize(("i", "j"), [(2, 9), (9, 2)])
def test_chain_covariance_against_draws(i: int, j: int) -> None:
    """The covariance of a pair of nodes holds for random and systematic errors, in both directions."""
    read, rng = wiggle(100), np.random.default_rng(2)
    sigma, prior = np.array([3e-3, 1e-3, 1e-2]), np.array([0.03, 0.01, 0.02])
    start = CALIBRATION.vector()
    nodes = track(read, CALIBRATION)[::10]
    increments = [
        Increments(read[k : k + 10].stamps_ns, read[k : k + 10].deltas, np.tile(np.diag(sigma**2), (10, 1, 1)))
        for k in range(0, 100, 10)
    ]
    edges = EdgeIncrements.of(increments).integrate(CALIBRATION)
    chain = Chain.of(nodes, edges, CALIBRATION, np.diag(prior**2))
    expected = Pose2.of(nodes[i]).to(Pose2.of(nodes[j])).array()
    draws = []
    for _ in range(1500):
        deltas = read.deltas + rng.normal(size=(100, 3)) * sigma
        drawn = Calibration.of(start + rng.normal(size=3) * prior)
        poses = track(Increments(read.stamps_ns, deltas, read.covariances), drawn)[::10]
        draws.append(Pose2.of(poses[i]).to(Pose2.of(poses[j])).array() - expected)
    covariance = chain.covariance(np.array([i]), np.array([j]))[0]
    assert np.allclose(np.cov(np.array(draws).T), covariance, rtol=0.2, atol=0.05 * np.abs(covariance).max())


def test_shapes_are_checked() -> None:
    with pytest.raises(ShapeError, match="increments need deltas"):
        Increments(np.zeros(2, np.int64), np.zeros((3, 3)), np.zeros((2, 3, 3)))


def test_no_increments_is_no_motion() -> None:
    delta, covariance, _ = integrate(Increments.empty(), CALIBRATION)
    assert not delta.any()
    assert not covariance.any()
