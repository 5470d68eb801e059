"""The robust solve: closures re-weighted from wide to narrow, odometry believed, never worse than before."""

from __future__ import annotations

import numpy as np

from topomap.geometry import FloatArray
from topomap.mapping.backend.blocks import closure_chi2
from topomap.mapping.backend.problem import Problem, Solution
from topomap.mapping.backend.settings import BackendSettings
from topomap.mapping.backend.state import Graph, Linearised, State, geman_mcclure


def solve(problem: Problem, settings: BackendSettings | None = None) -> Solution:
    """Solve poses and calibration jointly by graduated non-convexity (Yang et al. 2020) over the closures.

    The closures' weights are annealed with Geman-McClure and end truncated (in or out). A result whose
    truncated error isn't below the start's is refused: the solution then holds the start. Raises TopomapError
    for an undetermined graph.
    """
    chosen = settings or BackendSettings()
    graph = Graph(problem, chosen.turn_cutoff)
    start = graph.start()
    at_start = graph.linearise(start)
    before = graph.truncated_error(at_start, chosen.cutoff)
    state, at, iterations = _anneal(graph, start, at_start, chosen)
    state, at, more = _settle(graph, state, at, chosen)
    after = graph.truncated_error(at, chosen.cutoff)
    improved = bool(np.isfinite(after) and after < before - 1e-9)
    if not improved:
        state, at = start, at_start
    weights = inliers(graph, at, chosen.cutoff)
    covariance = graph.system(at, weights).covariance()
    return Solution(
        state.poses, state.calibration, covariance, weights, before, after, iterations + more, improved
    )


def inliers(graph: Graph, at: Linearised, cutoff: float) -> FloatArray:
    """Return (M,) 1 for the closures within the cutoff [sigmas], 0 for the others."""
    return (_chi2(graph, at) <= cutoff**2).astype(float)


def _chi2(graph: Graph, at: Linearised) -> FloatArray:
    """The closures' squared errors without their weights: a light one has to fit as well."""
    return at.closures.chi2() / np.maximum(graph.problem.closures.weight, 1e-12)


def _anneal(
    graph: Graph, state: State, at: Linearised, settings: BackendSettings
) -> tuple[State, Linearised, int]:
    """Believe at first what odometry allows, then less and less.

    The cutoff is on the distance in the sum of the closure's covariance and the odometry's along the way: a true
    closure of a long loop may be far off, a false one of a short path mayn't.
    """
    closures, extra = graph.problem.closures, graph.allowance()
    for stage in range(settings.stages):
        if bool((_chi2(graph, at) <= settings.cutoff**2).all()):
            return state, at, stage
        chi2 = closure_chi2(state.poses, closures, extra * settings.shrink ** (-2 * stage))
        state, at, _ = graph.step(state, at, geman_mcclure(chi2, settings.cutoff))
    return state, at, settings.stages


def _settle(
    graph: Graph, state: State, at: Linearised, settings: BackendSettings
) -> tuple[State, Linearised, int]:
    for iteration in range(settings.iterations):
        state, at, move = graph.step(state, at, inliers(graph, at, settings.cutoff))
        if move < settings.tolerance:
            return state, at, iteration + 1
    return state, at, settings.iterations
