"""A bounded solve between two closures: the newest stretch alone, hung on what was solved before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from topomap.geometry import FloatArray
from topomap.mapping.backend.problem import Closures, IntArray, OdometryEdge, Problem, Solution, TurnEdge
from topomap.mapping.backend.settings import BackendSettings
from topomap.mapping.backend.solver import solve


def solve_recent(
    problem: Problem, edges: int, calibration_covariance: FloatArray, settings: BackendSettings | None = None
) -> Solution:
    """Solve the nodes of the last `edges` odometry edges; the work doesn't grow with the map.

    All other poses stay, and the first of these nodes is held. The calibration is held to the problem's own with
    calibration_covariance (3, 3), what the last full solve left. Closures that reach further back aren't heard: their
    weights are 1, as a closure asks for a full solve. The solution is the whole map's. Raises TopomapError.
    """
    if edges >= len(problem.odometry):
        return solve(problem, settings)
    part, nodes, heard = _tail(problem, edges, calibration_covariance)
    found = solve(part, settings)
    poses, weights = problem.poses.copy(), np.ones(len(problem.closures))
    poses[nodes] = found.poses
    weights[heard] = found.closure_weights
    return replace(found, poses=poses, closure_weights=weights)


def _tail(problem: Problem, edges: int, covariance: FloatArray) -> tuple[Problem, IntArray, IntArray]:
    """Return the problem of the newest nodes, those nodes, and which closures lie among them."""
    odometry = problem.odometry[len(problem.odometry) - edges :]
    nodes = np.array([odometry[0].i, *(edge.j for edge in odometry)], np.int64)
    place = np.full(len(problem.poses), -1)
    place[nodes] = np.arange(len(nodes))
    closures = problem.closures
    heard = np.flatnonzero((place[closures.i] >= 0) & (place[closures.j] >= 0))
    some = closures[heard]
    part = Problem(
        problem.poses[nodes],
        tuple(OdometryEdge(k, k + 1, edge.increments) for k, edge in enumerate(odometry)),
        Closures(place[some.i], place[some.j], some.relative, some.covariance, some.weight),
        tuple(
            TurnEdge(int(place[t.i]), int(place[t.j]), t.turn, t.sigma)
            for t in problem.turns
            if place[t.i] >= 0 and place[t.j] >= 0
        ),
        problem.calibration,
        problem.calibration,
        tuple(np.sqrt(np.diag(covariance)).tolist()),
    )
    return part, nodes, heard
