"""The chain without its inner nodes: the same solution as with all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ring import edges_of, ring

from topomap.core.errors import TopomapError
from topomap.mapping.optimizer import AxisEdge, OdometryEdges, Problem, TurnEdge, gauss_newton
from topomap.mapping.optimizer.gauss_newton import GaussNewton
from topomap.mapping.optimizer.objective import Objective


def problem() -> Problem:
    """A ring with seen turns, two of them on one edge and some over several edges, and axes."""
    made = ring(1, nodes=60, length=60, closures=6).problem
    turns = [TurnEdge(k, k + 1, 0.1 + 0.01 * (k % 3), 0.02) for k in range(0, 59, 2)]
    turns += [TurnEdge(20, 21, 0.08, 0.05), TurnEdge(30, 35, 0.5, 0.03), TurnEdge(41, 40, -0.1, 0.02)]
    return replace(made, turns=tuple(turns), axes=(AxisEdge(3, 4, 0.2), AxisEdge(50, 51, 0.2)))


def solved(made: Problem, keep_all: bool, monkeypatch: pytest.MonkeyPatch) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    graph = Objective(made, 3.0)
    at = graph.linearise(graph.start())
    if keep_all:
        plain = gauss_newton.condense
        monkeypatch.setattr(gauss_newton, "condense", lambda c, o, s, keep: plain(c, o, s, np.ones_like(keep)))
    system = GaussNewton(graph).system(at, np.full(len(made.closures), 0.7))
    poses, calibration = system.solve()
    return poses, calibration, system.covariance()


def test_leaving_nodes_out_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    made = problem()
    for mine, whole in zip(solved(made, False, monkeypatch), solved(made, True, monkeypatch), strict=True):
        assert np.allclose(mine, whole, rtol=1e-6, atol=1e-9)


def test_a_chain_without_closures_follows_its_odometry() -> None:
    made = replace(ring(2, nodes=30, length=30, closures=0).problem, turns=())
    graph = Objective(made, 3.0)
    poses, calibration = GaussNewton(graph).system(graph.linearise(graph.start()), np.zeros(0)).solve()
    assert np.allclose(poses, 0.0, atol=1e-9)
    assert np.allclose(calibration, 0.0, atol=1e-9)


def test_a_map_of_one_node_is_determined() -> None:
    one = Problem(np.zeros((1, 3)), OdometryEdges.of(()))
    graph = Objective(one, 3.0)
    poses, _ = GaussNewton(graph).system(graph.linearise(graph.start()), np.zeros(0)).solve()
    assert poses.shape == (1, 3)


def test_nodes_off_the_chain_are_undetermined() -> None:
    made = ring(2, nodes=10, length=10, closures=0).problem
    cut = replace(made, odometry=OdometryEdges.of(edges_of(made)[:5]))
    graph = Objective(cut, 3.0)
    with pytest.raises(TopomapError, match="isn't determined"):
        GaussNewton(graph).system(graph.linearise(graph.start()), np.zeros(0)).solve()
