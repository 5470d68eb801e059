"""The robust solve: closures re-weighted from wide to narrow, odometry believed, never worse than before."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.errors import TopomapError
from topomap.mapping.optimizer.gauss_newton import GaussNewton
from topomap.mapping.optimizer.gnc import Schedule, Weighing
from topomap.mapping.optimizer.objective import Linearised, Objective, State
from topomap.mapping.optimizer.problem import Problem, Solution
from topomap.mapping.optimizer.settings import OptimizerSettings
from topomap.mapping.optimizer.slices import Slices, drained

End = tuple[State, Linearised, int]
"""Where a way ended, and after how many steps."""


def solve(problem: Problem, settings: OptimizerSettings | None = None) -> Solution:
    """Solve poses and calibration jointly by graduated non-convexity (Yang et al. 2020) over the closures.

    The closures' weights are annealed with Geman-McClure and end truncated (in or out). A result whose truncated
    error isn't below the start's is refused: the solution then holds the start. So is one in which most closures are
    out and those that are in don't support one another: a single one that fits among many that don't fits by chance.
    Raises TopomapError for an undetermined graph.
    """
    return drained(solving(problem, settings))


def solving(
    problem: Problem, settings: OptimizerSettings | None = None, doubted: BoolArray | None = None
) -> Slices[Solution]:
    """Do what `solve` does, at most one Gauss-Newton step a slice, of a large graph a part of one.

    Whoever has other work does it in between.

    doubted (M,): closures that were out when the start was found. Where all others fit the start nothing is annealed.
    """
    chosen = settings or OptimizerSettings()
    newton = GaussNewton(graph := Objective(problem, chosen.turn_cutoff))
    yield
    start = graph.start()
    at_start = graph.linearise(start)
    before = graph.truncated_error(at_start, chosen.cutoff)
    state, at, iterations = yield from _best(newton, start, at_start, chosen, doubted)
    yield from newton.pause()
    after = graph.truncated_error(at, chosen.cutoff)
    improved = bool(np.isfinite(after) and after < before - 1e-9) and _credible(graph, at, chosen)
    if not improved:
        state, at = start, at_start
    yield
    weights = inliers(graph, at, chosen.cutoff)
    covariance = graph.held
    if covariance is None:
        system = yield from newton.building(at, weights)
        yield from newton.pause()
        covariance = system.covariance()
    return Solution(state.poses, state.calibration, covariance, weights, before, after, iterations, improved)


def inliers(graph: Objective, at: Linearised, cutoff: float) -> FloatArray:
    """Return (M,) 1 for the closures within the cutoff [sigmas], 0 for the others."""
    return (_chi2(graph, at) <= cutoff**2).astype(float)


def _credible(graph: Objective, at: Linearised, settings: OptimizerSettings) -> bool:
    believed = inliers(graph, at, settings.cutoff)
    if len(believed) == 0 or believed.mean() >= 0.5:
        return True
    return bool((Schedule(graph, settings).agreement(believed > 0) > 0).any())


def _chi2(graph: Objective, at: Linearised) -> FloatArray:
    """The closures' squared errors without their weights: a light one has to fit as well."""
    return at.closures.chi2() / np.maximum(graph.problem.closures.weight, 1e-12)


def _best(
    newton: GaussNewton, start: State, at: Linearised, settings: OptimizerSettings, doubted: BoolArray | None
) -> Slices[End]:
    """Return the better end of two ways: all that odometry allows, or first those that support one another."""
    graph = newton.graph
    fitting = inliers(graph, at, settings.cutoff) > 0
    if bool((fitting if doubted is None else fitting | doubted).all()):
        return (yield from _settle(newton, start, at, settings, 0))
    yield
    schedule = Schedule(graph, settings)
    if settings.cutoffs:
        return (yield from _end(newton, start, at, schedule.narrowing(), settings))
    first = yield from _end(newton, start, at, schedule.allowed(), settings)
    supported = schedule.supported()
    if supported is None or bool(inliers(graph, first[1], settings.cutoff).all()):
        return first
    second = yield from _end(newton, start, at, supported, settings)
    errors = [graph.truncated_error(end[1], settings.cutoff) for end in (first, second)]
    state, there, _ = second if errors[1] < errors[0] else first
    return state, there, first[2] + second[2]


def _end(
    newton: GaussNewton, start: State, at: Linearised, schedule: Weighing, settings: OptimizerSettings
) -> Slices[End]:
    try:
        state, there, steps = yield from _anneal(newton, start, at, schedule, settings.cutoff)
        return (yield from _settle(newton, state, there, settings, steps))
    except TopomapError:
        # closures faded to almost nothing leave a long chain too soft for double precision: this way leads nowhere.
        # A graph that was never determined is refused later, when its covariance is asked for at the start
        return start, at, 0


def _anneal(newton: GaussNewton, state: State, at: Linearised, schedule: Weighing, cutoff: float) -> Slices[End]:
    """Follow the schedule until every closure fits or it ends."""
    steps = 0
    for weigh in schedule:
        if bool(inliers(newton.graph, at, cutoff).all()):
            break
        yield
        state, at, _ = yield from newton.stepping(state, at, weigh(state.poses))
        steps += 1
    return state, at, steps


def _settle(newton: GaussNewton, state: State, at: Linearised, settings: OptimizerSettings, done: int) -> Slices[End]:
    for iteration in range(settings.iterations):
        yield
        state, at, move = yield from newton.stepping(state, at, inliers(newton.graph, at, settings.cutoff))
        if move < settings.tolerance:
            return state, at, done + iteration + 1
    return state, at, done + settings.iterations
