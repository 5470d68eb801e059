"""The back end against finite differences, gtsam's own factor, and rings with known errors."""

from __future__ import annotations

from dataclasses import replace

import gtsam
import numpy as np
import pytest
from ring import TRUE, Ring, ate, blinded, edges_of, ring

from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2, wrap_all
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, track
from topomap.mapping.optimizer import (
    ClosureEdge,
    Closures,
    OdometryEdge,
    OdometryEdges,
    Problem,
    Slices,
    Solution,
    TurnEdge,
    solve,
    solving,
)
from topomap.mapping.optimizer.objective import Objective, State
from topomap.mapping.optimizer.residuals import Residuals, closure_residuals


def by_differences(graph: Objective, state: State, part: str, node: int, axis: int) -> np.ndarray:
    moved = []
    for sign in (1, -1):
        poses = state.poses.copy()
        poses[node, axis] += sign * 1e-6
        blocks: Residuals = getattr(graph.linearise(State(poses, state.calibration)), part)
        moved.append(blocks.residual)
    return (moved[0] - moved[1]) / 2e-6


@pytest.mark.parametrize("part", ["odometry", "closures", "turns"])
def test_pose_jacobians_against_differences(part: str) -> None:
    problem = ring(0, nodes=24, length=24, closures=5).problem
    mixed = problem.closures.covariance.copy()
    mixed[2:, 2, 2] = 40.0
    relative = problem.closures.relative + np.array([0.3, -0.2, 0.1])
    closures = replace(problem.closures, covariance=mixed, relative=relative)
    problem = replace(problem, closures=closures, turns=(TurnEdge(3, 4, 0.2, 0.05),))
    graph, state = Objective(problem, 3.0), State(problem.poses, TRUE)
    blocks: Residuals = getattr(graph.linearise(state), part)
    for k in range(len(blocks.i)):
        if part == "closures" and k >= 2:
            continue  # the blind ones whiten with one sigma both ways: checked below
        for axis in range(3):
            assert np.allclose(
                by_differences(graph, state, part, int(blocks.i[k]), axis)[k], blocks.by_i[k, :, axis], atol=1e-3
            )
            assert np.allclose(
                by_differences(graph, state, part, int(blocks.j[k]), axis)[k], blocks.by_j[k, :, axis], atol=1e-3
            )


def test_calibration_jacobian_against_differences() -> None:
    problem = ring(0, nodes=24, length=24, closures=2).problem
    graph = Objective(problem, 3.0)
    blocks = graph.linearise(State(problem.poses, TRUE)).odometry
    assert blocks.by_calibration is not None
    for axis, step in enumerate(np.eye(3) * 1e-6):
        ends = [Calibration.of(TRUE.vector() + sign * step) for sign in (1, -1)]
        plus, minus = (graph.linearise(State(problem.poses, end)).odometry.residual for end in ends)
        # the whitening also moves with the calibration, by second-order little
        assert np.allclose((plus - minus) / 2e-6, blocks.by_calibration[:, :, axis], rtol=0.02, atol=2.0)


def test_closure_agrees_with_gtsam() -> None:
    """Near the claim: the squared error and the information of BetweenFactorPose2."""
    covariance = np.array([[0.2, 0.05, 0.01], [0.05, 0.1, 0.0], [0.01, 0.0, 0.02]])
    first, claim = Pose2(1.0, 2.0, 0.4), Pose2(1.2, -0.9, -1.5)
    poses = np.array([first.array(), (first @ claim).array() + np.array([1e-4, -2e-4, 1e-4])])
    blocks = closure_residuals(poses, Closures.of([ClosureEdge(0, 1, claim, covariance)]))
    values = gtsam.Values()
    for key, row in enumerate(poses):
        values.insert(key, gtsam.Pose2(*row))
    c, s = np.cos(claim.heading), np.sin(claim.heading)
    turned = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])  # gtsam measures in the frame of the claimed pose
    model = gtsam.noiseModel.Gaussian.Covariance(turned @ covariance @ turned.T)
    factor = gtsam.BetweenFactorPose2(0, 1, gtsam.Pose2(claim.x, claim.y, claim.heading), model)
    assert blocks.chi2()[0] == pytest.approx(2 * factor.error(values), rel=1e-3)
    body = []  # gtsam moves a pose in its own frame
    for pose, derivative in zip(poses, (blocks.by_i[0], blocks.by_j[0]), strict=True):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        body.append(derivative @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    whole = np.hstack(body)
    assert np.allclose(whole.T @ whole, factor.linearize(values).information(), rtol=1e-3, atol=0.02)


OTHER = Calibration(rotation_scale=1.0, curvature=-0.004, distance_scale=0.92)


def by_two_odometers(seed: int) -> tuple[Ring, Problem]:
    """The second lap read by another odometer, the first one's errors being known."""
    made = ring(seed, closures=60)
    odometry, half = made.problem.odometry, len(made.problem.odometry) // 2
    whole = odometry.increments
    read, second = whole.read_by(TRUE, OTHER), int(whole.starts[half])
    mixed = EdgeIncrements(
        np.vstack([whole.deltas[:second], read.deltas[second:]]),
        np.concatenate([whole.covariances[:second], read.covariances[second:]]), whole.starts,
    )  # fmt: skip
    way = Increments(np.arange(len(mixed.deltas)), mixed.deltas, mixed.covariances)
    starts = track(way, TRUE)[whole.starts]
    problem = replace(
        made.problem, poses=starts, odometry=replace(odometry, increments=mixed), calibration=TRUE, prior=TRUE
    )
    return made, problem


@pytest.mark.parametrize("seed", range(5))
def test_another_odometer_on_the_same_map_is_found_beside_the_first(seed: int) -> None:
    made, problem = by_two_odometers(seed)
    others = np.arange(len(problem.odometry)) < len(problem.odometry) // 2
    found = solve(replace(problem, prior_sigmas=(0.05, 0.01, 0.05), others=others))
    assert found.closure_weights.mean() > 0.95
    assert found.calibration.rotation_scale == pytest.approx(OTHER.rotation_scale, abs=0.025)
    assert found.calibration.distance_scale == pytest.approx(OTHER.distance_scale, abs=0.01)
    assert ate(found.poses, made.truth) < 0.6 * ate(solve(problem).poses, made.truth)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_ring_driven_both_ways_shows_scale_and_curvature(seed: int) -> None:
    made = ring(seed, back=True)
    solution = solve(made.problem)
    assert solution.improved
    assert ate(solution.poses, made.truth) < 0.25 * ate(made.problem.poses, made.truth)
    error = solution.calibration.vector() - TRUE.vector()
    sigma = np.sqrt(np.diag(solution.calibration_covariance))
    assert (np.abs(error[:2]) < 2.5 * sigma[:2]).all()
    assert sigma[0] < 0.01
    assert sigma[1] < 0.001


def test_one_way_round_scale_and_curvature_arent_told_apart() -> None:
    solution = solve(ring(0).problem)
    assert np.sqrt(solution.calibration_covariance[0, 0]) > 0.025


def test_seen_turns_tell_them_apart() -> None:
    made = ring(0)
    rng = np.random.default_rng(0)
    heading = made.truth[:, 2]
    seen = wrap_all(np.diff(heading)) + rng.normal(0, 0.03, len(heading) - 1)
    seen[::17] += 0.8  # a wrong compass now and then
    turns = tuple(TurnEdge(n, n + 1, float(t), 0.03) for n, t in enumerate(seen))
    solution = solve(replace(made.problem, turns=turns))
    assert np.sqrt(solution.calibration_covariance[0, 0]) < 0.015
    assert abs(solution.calibration.rotation_scale - 1.04) < 0.035


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_false_closures_are_rejected(seed: int) -> None:
    made = ring(seed, false=0.3, back=True)
    solution = solve(made.problem)
    kept = solution.closure_weights > 0.5
    wrong = made.false & kept
    assert wrong.sum() <= 1  # a chance hit may be right
    assert kept[~made.false].mean() > 0.9
    known = solve(replace(made.problem, closures=made.problem.closures[~made.false]))
    assert ate(solution.poses, made.truth) < ate(known.poses, made.truth) + 0.25


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_all_false_leaves_the_odometry_map(seed: int) -> None:
    made = ring(seed, false=1.0)
    solution = solve(made.problem)
    assert not solution.improved
    assert np.array_equal(solution.poses, made.problem.poses)
    assert solution.calibration == made.problem.calibration


def test_turns_seen_far_better_than_odometrys_are_believed_and_a_wrong_one_is_not() -> None:
    made = ring(5, nodes=120, length=120.0, closures=0)
    sigma = np.deg2rad(0.05)
    seen = wrap_all(np.diff(made.truth[:, 2])) + np.random.default_rng(5).normal(0.0, sigma, 120)
    seen[60] += np.deg2rad(40.0)
    turns = tuple(TurnEdge(n, n + 1, float(t), sigma) for n, t in enumerate(seen))
    solution = solve(replace(made.problem, turns=turns))
    assert solution.improved
    off = np.degrees(wrap_all(np.diff(solution.poses[:, 2]) - np.diff(made.truth[:, 2])))
    assert np.abs(np.delete(off, 60)).max() < 0.3, "odometry's own noise is 0.5 degrees a metre"
    assert abs(off[60]) < 2.5


def test_opposite_headings_without_a_claim_dont_turn_the_map() -> None:
    made: Ring = ring(1, back=True)
    problem = blinded(made.problem)
    solution = solve(problem)
    assert solution.improved
    assert ate(solution.poses, made.truth) < 0.3 * ate(problem.poses, made.truth)
    blocks = closure_residuals(problem.poses, replace(problem.closures, relative=problem.closures.relative * 0))
    assert not blocks.by_i[:, :, 2].any()


def test_no_closures_keep_the_map() -> None:
    problem = replace(ring(0).problem, closures=Closures.of(()))
    solution = solve(problem)
    assert not solution.improved
    assert np.array_equal(solution.poses, problem.poses)
    assert np.allclose(np.sqrt(np.diag(solution.calibration_covariance)), problem.prior_sigmas, rtol=0.01)


def test_one_node_alone() -> None:
    solution = solve(Problem(np.zeros((1, 3)), OdometryEdges.of(())))
    assert not solution.improved
    assert solution.poses.shape == (1, 3)


def test_same_input_same_bytes() -> None:
    problem = ring(2, false=0.3).problem
    assert solve(problem).poses.tobytes() == solve(problem).poses.tobytes()


def parked(k: int = 3) -> Increments:
    return Increments(np.zeros(k, np.int64), np.zeros((k, 3)), np.zeros((k, 3, 3)))


def test_a_parked_robot_with_no_noise_can_be_solved() -> None:
    claim = ClosureEdge(0, 2, Pose2(0.1, 0, 0), np.diag([0.1, 0.1, 0.1]) ** 2)
    edges = OdometryEdges.of((OdometryEdge(0, 1, parked()), OdometryEdge(1, 2, Increments.empty())))
    solution = solve(Problem(np.zeros((3, 3)), edges, Closures.of([claim])))
    assert np.abs(solution.poses).max() < 0.1


def test_clear_lines_for_bad_input() -> None:
    good = ring(0, nodes=24, length=24, closures=2).problem
    poses = good.poses.copy()
    poses[3, 1] = np.nan
    with pytest.raises(TopomapError, match="poses of the pose graph hold NaN"):
        replace(good, poses=poses)
    with pytest.raises(TopomapError, match="anchor"):
        replace(good, anchor=99)
    with pytest.raises(TopomapError, match="outside 0"):
        replace(good, closures=Closures.of([ClosureEdge(0, 99, Pose2(), np.eye(3))]))
    with pytest.raises(TopomapError, match="breaks between"):
        replace(good, odometry=OdometryEdges.of([edges_of(good)[0], edges_of(good)[4]]))
    with pytest.raises(TopomapError, match="isn't determined"):
        solve(Problem(np.zeros((3, 3)), OdometryEdges.of([OdometryEdge(0, 1, parked())])))


def test_closures_that_were_out_before_dont_make_a_solve_begin_afresh() -> None:
    made = ring(2, false=0.3).problem
    found = solve(made)
    out = found.closure_weights < 0.5
    assert out.any()
    again = replace(made, poses=found.poses + 0.002, calibration=found.calibration)
    (begun, slow), (followed, quick) = (drained(solving(again, doubted=doubted)) for doubted in (None, out))
    assert quick < slow
    assert np.allclose(followed.poses, begun.poses, atol=0.01)
    assert np.array_equal(followed.closure_weights, begun.closure_weights)


def drained(slices: Slices[Solution]) -> tuple[Solution, int]:
    """Return what a solve found and how many slices it took."""
    count = 0
    while True:
        try:
            next(slices)
            count += 1
        except StopIteration as end:
            return end.value, count
