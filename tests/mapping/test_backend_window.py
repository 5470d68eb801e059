"""The bounded solve, and solves that numerics can't follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ring import ring

from topomap.errors import TopomapError
from topomap.geometry import wrap_all
from topomap.mapping.backend import AxisEdge, Closures, Problem, TurnEdge, solve, solve_recent


def test_recent_solve_moves_only_the_newest_nodes() -> None:
    problem = ring(0, nodes=80, length=80, closures=10).problem
    covariance = np.diag([1e-4, 1e-6, 1e-4])
    held = replace(
        problem, turns=(TurnEdge(70, 71, float(problem.poses[71, 2] - problem.poses[70, 2]) + 0.015, 0.007),)
    )
    found = solve_recent(held, 20, covariance)
    assert found.improved
    assert np.array_equal(found.poses[:60], problem.poses[:60])
    turned = wrap_all(found.poses[71:, 2] - problem.poses[71:, 2])
    assert turned.mean() > 0.003
    assert len(found.closure_weights) == len(problem.closures)


def test_recent_solve_of_everything_is_the_full_one() -> None:
    problem = ring(0, nodes=40, length=40, closures=5).problem
    assert np.array_equal(solve_recent(problem, 99, np.eye(3)).poses, solve(problem).poses)


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
