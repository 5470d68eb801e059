"""Trajectory errors against cases worked by hand, and against evo."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_run import integrate, make_run, motions

from topomap.core.arrays import FloatArray
from topomap.core.geometry import compose
from topomap.evaluation.trajectory import (
    Similarity,
    align,
    ate,
    drift_percent,
    placed,
    position_errors,
    rpe,
    step_at,
    travel,
)

ROUTE = integrate(np.array([1.0, 2.0, 0.5]), motions(1))


def noisy(seed: int, sigma: float) -> FloatArray:
    return ROUTE + np.random.default_rng(seed).normal(0, sigma, ROUTE.shape)


@settings(max_examples=40, deadline=None)
@given(st.floats(0.2, 4.0), st.floats(-3.1, 3.1), st.floats(-50, 50), st.floats(-50, 50))
def test_align_finds_the_similarity_that_was_applied(scale: float, rotation: float, x: float, y: float) -> None:
    applied = Similarity(scale, rotation, x, y)
    found = align(ROUTE[:, :2], applied.apply(ROUTE[:, :2]), scale=True)
    assert found.scale == pytest.approx(scale, rel=1e-9)
    assert found.rotation == pytest.approx(rotation, abs=1e-9)
    assert (found.x, found.y) == pytest.approx((x, y), abs=1e-7)


def test_se2_alignment_keeps_the_scale_and_sim2_removes_it() -> None:
    half = ROUTE * np.array([0.5, 0.5, 1.0])
    centred = ROUTE[:, :2] - ROUTE[:, :2].mean(axis=0)
    spread = math.sqrt((centred**2).sum(axis=1).mean())
    assert ate(half, ROUTE) == pytest.approx(0.5 * spread, rel=1e-9)
    assert ate(half, ROUTE, scale=True) < 1e-9


def test_alignment_never_mirrors() -> None:
    mirrored = ROUTE * np.array([1.0, -1.0, -1.0])
    assert ate(mirrored, ROUTE, scale=True) > 1.0


def test_alignment_of_a_robot_that_stands_still() -> None:
    still = np.zeros((5, 3))
    assert ate(still, still, scale=True) == 0.0
    assert ate(still, ROUTE[:5], scale=True) == pytest.approx(ate(still, ROUTE[:5]))


def test_steps_without_truth_do_not_count() -> None:
    truth = ROUTE.copy()
    truth[::3] = np.nan
    wild = ROUTE.copy()
    wild[::3] += 100.0
    assert ate(wild, truth) < 1e-9
    assert math.isnan(ate(wild, np.full_like(ROUTE, np.nan)))


def test_moving_poses_turns_their_headings_too() -> None:
    moved = Similarity(1.0, 0.7, 3.0, -2.0).move(ROUTE)
    assert moved == pytest.approx(compose(np.array([3.0, -2.0, 0.7]), ROUTE))


def test_rpe_of_a_scaled_odometer_is_the_scale_error() -> None:
    steps = np.tile([0.1, 0.0, 0.0], (300, 1))
    truth = integrate(np.zeros(3), steps)
    error = rpe(integrate(np.zeros(3), steps * 0.95), truth, 10.0)
    assert error is not None
    assert error.stretches == 201
    assert error.translation == pytest.approx(0.5)
    assert error.rotation == pytest.approx(0.0)
    assert drift_percent(truth * np.array([0.95, 1, 1]), truth) == pytest.approx(5.0)


def test_rpe_sees_turning_and_not_the_frame() -> None:
    elsewhere = compose(np.array([5.0, -3.0, 2.0]), ROUTE)
    same = rpe(elsewhere, ROUTE, 1.0)
    assert same is not None
    assert same.translation < 1e-9
    turned = ROUTE + np.column_stack([np.zeros((len(ROUTE), 2)), 0.01 * travel(ROUTE)])
    error = rpe(turned, ROUTE, 1.0)
    assert error is not None
    assert error.rotation == pytest.approx(0.01, rel=1e-6)


def test_rpe_needs_a_stretch_and_headings() -> None:
    assert rpe(ROUTE[:5], ROUTE[:5], 10.0) is None
    headless = ROUTE.copy()
    headless[:, 2] = np.nan
    assert rpe(ROUTE, headless, 1.0) is None


def test_the_nearest_step_of_a_stamp() -> None:
    stamps = np.array([0, 10, 20], dtype=np.int64)
    assert [step_at(stamps, stamp) for stamp in (-5, 4, 5, 6, 14, 99)] == [0, 0, 0, 1, 1, 2]


def test_placed_at_the_start_pose_shows_drift_as_it_grew() -> None:
    run = make_run()
    errors = position_errors(run, run.dead_reckoning)
    assert errors is not None
    assert errors[0] == pytest.approx(0.0, abs=1e-12)
    assert errors[-1] > 1.0
    assert placed(run, run.final)[1] == "aligned at the start pose"


def test_placed_without_headings_fits_the_map() -> None:
    run = make_run()
    assert run.truth is not None
    headless = replace(run, truth=np.column_stack([run.truth[:, :2], np.full(len(run.truth), np.nan)]))
    there, how = placed(headless, headless.final)
    gaps = there[:, :2] - run.truth[:, :2]
    assert "best fit" in how
    assert math.sqrt((gaps**2).sum(axis=1).mean()) == pytest.approx(ate(run.final, run.truth), rel=1e-9)


@pytest.mark.parametrize("scale", [False, True])
def test_ate_agrees_with_evo(scale: bool) -> None:
    metrics = pytest.importorskip("evo.core.metrics")
    trajectory = pytest.importorskip("evo.core.trajectory")

    def of(poses: FloatArray) -> Any:
        half = poses[:, 2] / 2
        nothing = np.zeros(len(poses))
        quaternions = np.column_stack([np.cos(half), nothing, nothing, np.sin(half)])
        return trajectory.PoseTrajectory3D(
            np.column_stack([poses[:, :2], nothing]), quaternions, np.arange(len(poses), dtype=float)
        )

    estimate = Similarity(0.9, 2.0, 4.0, -7.0).move(noisy(1, 0.3))
    truth, aligned = of(ROUTE), of(estimate)
    aligned.align(truth, correct_scale=scale)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((truth, aligned))
    assert ate(estimate, ROUTE, scale) == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), rel=1e-9)
