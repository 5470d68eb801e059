"""The bounded solve, and solves that numerics can't follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ring import edges_of, ring

from topomap.core.errors import TopomapError
from topomap.core.geometry import compose, wrap_all
from topomap.mapping.optimizer import (
    AxisEdge,
    Closures,
    Problem,
    Recent,
    Solution,
    TurnEdge,
    gauss_newton,
    solve,
    solving,
    solving_recent,
)
from topomap.mapping.optimizer.slices import drained


def recent(problem: Problem, edges: int) -> Recent:
    return drained(
        solving_recent(problem.poses, edges_of(problem)[-edges:], problem.closures, problem.turns, problem.calibration)
    )


def test_recent_solve_moves_only_the_newest_nodes() -> None:
    problem = ring(0, nodes=80, length=80, closures=0).problem
    turned = TurnEdge(70, 71, float(problem.poses[71, 2] - problem.poses[70, 2]) + 0.015, 0.007)
    found = recent(replace(problem, turns=(turned,)), 20)
    assert found.solution.improved
    assert found.nodes.tolist() == list(range(60, 81))
    moved = wrap_all(found.solution.poses[:, 2] - problem.poses[found.nodes, 2])
    assert moved[0] == 0.0
    assert moved[11:].mean() > 0.003
    assert np.allclose(found.solution.calibration.vector(), problem.calibration.vector(), atol=1e-6)


@pytest.mark.parametrize("blind", [False, True])
def test_a_closure_to_an_older_node_pulls_the_newest_stretch_to_where_that_stands(blind: bool) -> None:
    """The node it names should lie 0.2 m ahead and 0.1 m left of the old one, in the old one's frame."""
    problem = ring(0, nodes=80, length=80, closures=0).problem
    spread = np.diag([1e-6, 1e-6, 40.0 if blind else 1e-6])
    claim = np.array([0.2, 0.1, 0.3])
    edge = Closures(np.array([5]), np.array([80]), claim[None], spread[None], np.ones(1))
    there = compose(problem.poses[5], claim)
    start = problem.poses.copy()
    start[40:] += there - start[80] + np.array([0.3, -0.2, 0.0])  # off by less than what odometry allows
    found = recent(replace(problem, poses=start, closures=edge), 39)
    assert found.heard.tolist() == [0]
    assert np.allclose(found.solution.poses[-1, :2], there[:2], atol=0.02)
    if not blind:
        assert abs(wrap_all(found.solution.poses[-1:, 2] - there[2])[0]) < 0.01


def test_a_long_chain_with_fading_closures_ends_clearly() -> None:
    """Annealed to 1e-7 the closures leave a chain that isn't positive definite in double precision."""
    found = solve(ring(0, nodes=1000, length=1000, closures=400).problem)
    assert np.isfinite(found.poses).all()
    assert found.error_after <= found.error_before or not found.improved


def test_axes_straighten_a_bent_chain() -> None:
    problem = ring(0, nodes=60, length=60, closures=0).problem
    straight = [1, 7, 8, 15, 22, 23]
    found = solve(replace(problem, axes=tuple(AxisEdge(k, k + 1, 0.1) for k in straight)))
    spreads = [np.std(wrap_all(4 * poses[straight, 2]) / 4) for poses in (problem.poses, found.poses)]
    assert spreads[1] < 0.5 * spreads[0]


def test_an_edge_from_a_node_to_itself_is_refused() -> None:
    problem = ring(0, nodes=24, length=24, closures=2).problem
    closures = problem.closures
    with pytest.raises(TopomapError, match="joins a node with itself"):
        Problem(
            problem.poses,
            problem.odometry,
            Closures(closures.i, closures.i, closures.relative, closures.covariance, closures.weight),
        )


@pytest.mark.parametrize("nodes", [100, 2500])
def test_what_nothing_shows_keeps_its_prior_however_long_the_chain(nodes: int) -> None:
    """In absolute poses 1,000 edges use up double precision: the sigmas came out five times too small."""
    problem = ring(0, nodes=nodes, length=nodes, closures=0).problem
    sigmas = np.sqrt(np.diag(solve(problem).calibration_covariance))
    assert np.allclose(sigmas, problem.prior_sigmas, rtol=1e-6)


def test_a_large_solve_in_parts_of_a_step_finds_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = ring(0, nodes=60, length=60, closures=6, false=0.3).problem
    whole, few = counted(problem)
    monkeypatch.setattr(gauss_newton, "LARGE", 10)
    parts, many = counted(problem)
    assert many > 2 * few
    assert np.array_equal(whole.poses, parts.poses)
    assert np.array_equal(whole.calibration_covariance, parts.calibration_covariance)


def counted(problem: Problem) -> tuple[Solution, int]:
    """Return a solution and how many slices it took."""
    slices, count = solving(problem), 0
    while True:
        try:
            next(slices)
            count += 1
        except StopIteration as end:
            return end.value, count
