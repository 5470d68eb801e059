"""What the back end solved, as plain relative poses with covariances: what any other pose graph optimiser reads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.core.records import UNKNOWN_HEADING
from topomap.mapping.optimizer.gauss_newton import WEIGHTLESS
from topomap.mapping.optimizer.objective import Objective
from topomap.mapping.optimizer.problem import Problem
from topomap.mapping.optimizer.residuals import FLOOR
from topomap.mapping.optimizer.settings import OptimizerSettings

# sigma [m, rad] of what an edge doesn't say: its information is 1e-9 or less of odometry's over such a stretch, yet a
# matrix that holds both is still inverted in double precision
UNSAID = 1e3


class RelativeEdges(NamedTuple):
    """E edges `i_from_j`: i, j (E,), relative (E, 3), covariance (E, 3, 3) of x, y [m], heading [rad] in i's frame."""

    i: IntArray
    j: IntArray
    relative: FloatArray
    covariance: FloatArray

    def some(self, part: BoolArray) -> RelativeEdges:
        """Return those of the edges that part (E,) chooses."""
        return RelativeEdges(self.i[part], self.j[part], self.relative[part], self.covariance[part])


def relative_edges(problem: Problem, settings: OptimizerSettings | None = None) -> RelativeEdges:
    """Return all edges at the problem's poses and calibration, which must be solved, so that both keep their optimum.

    First odometry in travel order, a turn that was measured over the same edge joined with it: both say something of
    the same relative pose, so that their informations add up. Then the turns over several edges, of unknown position,
    and the closures. What a turn that fits badly counts less, and a closure's weight, is in the covariances.
    """
    graph = Objective(problem, (settings or OptimizerSettings()).turn_cutoff)
    odometry, turns, closures = _odometry(problem), _turns(problem, graph), _closures(problem)
    pairs = {pair: row for row, pair in enumerate(zip(odometry.i.tolist(), odometry.j.tolist(), strict=True))}
    rows = np.array([pairs.get(pair, -1) for pair in zip(turns.i.tolist(), turns.j.tolist(), strict=True)], np.int64)
    beside = rows >= 0
    joined = _joined(odometry, rows[beside], turns.some(beside))
    parts = (joined, turns.some(~beside), closures)
    return RelativeEdges(
        np.concatenate([part.i for part in parts]),
        np.concatenate([part.j for part in parts]),
        np.concatenate([part.relative for part in parts]),
        np.concatenate([part.covariance for part in parts]),
    )


def _odometry(problem: Problem) -> RelativeEdges:
    calibration = problem.calibration
    edges = problem.odometry.increments.integrate(calibration)
    firm = edges._replace(covariance=edges.covariance + FLOOR)
    return RelativeEdges(
        problem.odometry.i, problem.odometry.j, edges.deltas(calibration), firm.covariances(calibration)
    )


def _turns(problem: Problem, graph: Objective) -> RelativeEdges:
    """Return the turns that count; their positions are the map's own, which says nothing and pulls nowhere."""
    pairs = np.array([(t.i, t.j) for t in problem.turns], np.int64).reshape(-1, 2)
    measured = np.array([(t.turn, t.sigma) for t in problem.turns]).reshape(-1, 2)
    weights = graph.turn_weights(graph.linearise(graph.start()))
    used = weights > WEIGHTLESS
    i, j = pairs[used].T
    relative = between(problem.poses[i], problem.poses[j])
    relative[:, 2] = measured[used, 0]
    covariance = np.tile(np.diag([UNSAID, UNSAID, 0.0]) ** 2, (len(i), 1, 1))
    covariance[:, 2, 2] = measured[used, 1] ** 2 / weights[used]
    return RelativeEdges(i, j, relative, covariance)


def _closures(problem: Problem) -> RelativeEdges:
    """Return the closures; one without a heading gets the map's own, and one sigma both ways as the residual has."""
    closures = problem.closures
    relative = closures.relative.copy()
    covariance = closures.covariance / closures.weight[:, None, None]
    blind = closures.covariance[:, 2, 2] > UNKNOWN_HEADING
    relative[blind, 2] = between(problem.poses[closures.i], problem.poses[closures.j])[blind, 2]
    spread = (covariance[blind, 0, 0] + covariance[blind, 1, 1]) / 2
    covariance[blind] = np.array([np.diag([s, s, UNSAID**2]) for s in spread]).reshape(-1, 3, 3)
    return RelativeEdges(closures.i, closures.j, relative, covariance)


def _joined(odometry: RelativeEdges, rows: IntArray, turns: RelativeEdges) -> RelativeEdges:
    """Return odometry with turns over some of its edges, rows (T,), joined: informations add up, means by these."""
    relative, covariance = odometry.relative.copy(), odometry.covariance.copy()
    for row, turn, variance in zip(rows.tolist(), turns.relative[:, 2], turns.covariance[:, 2, 2], strict=True):
        gain = covariance[row, :, 2] / (covariance[row, 2, 2] + variance)
        relative[row] += gain * wrap_all(turn - relative[row, 2])
        covariance[row] -= np.outer(gain, covariance[row, 2])
    relative[:, 2] = wrap_all(relative[:, 2])
    return RelativeEdges(odometry.i, odometry.j, relative, covariance)
