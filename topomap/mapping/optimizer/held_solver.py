"""The robust solve of a pose graph whose odometry has no systematic error to find: poses alone are unknown."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.errors import TopomapError
from topomap.core.geometry import wrap_all
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer.block_cholesky import BlockPattern
from topomap.mapping.optimizer.objective import geman_mcclure
from topomap.mapping.optimizer.pose_network import Links
from topomap.mapping.optimizer.problem import Closures, OdometryEdges
from topomap.mapping.optimizer.residuals import FLOOR
from topomap.mapping.optimizer.settings import OptimizerSettings

ANCHOR = 1e6  # information of the first pose [1/m^2, 1/rad^2]: it has nothing to pull against, so any holds it
HALVINGS = 5  # of a step that makes the error worse
FILLED = 0.8  # of a pattern's edges that others have at least to take it over: a new order takes as long as two steps


class Ended(NamedTuple):
    """Where a solve ended: poses (N, 3), and which closures (M,) are in."""

    poses: FloatArray
    inlier: BoolArray


class HeldSolver:
    """Solves one drive with closures, again and again with others of them."""

    def __init__(self, odometry: OdometryEdges, calibration: Calibration) -> None:
        """Take the drive's odometry from pose 0 on, and the calibration that it is taken to have."""
        edges = odometry.increments.integrate(calibration)
        covariance = edges._replace(covariance=edges.covariance + FLOOR).covariances(calibration)
        seeing = np.zeros(len(odometry), np.bool_)  # across a gap, too, little is known of the heading, but not nothing
        deltas, information = edges.deltas(calibration), np.asarray(np.linalg.inv(covariance), float)
        self.odometry = Links(odometry.i, odometry.j, deltas, information, seeing)
        self._last: _Graph | None = None

    def solve(self, poses: FloatArray, closures: Closures, settings: OptimizerSettings) -> Ended:
        """Return the poses (N, 3) with closures, from others, by graduated non-convexity as `solver.solve` does it.

        Closures end in or out; where they leave more error than the start has, the start is kept. Raises TopomapError.
        """
        graph = self._graph(closures, len(poses))
        before = graph.truncated(poses, settings.cutoff)
        found = poses
        for cutoff in settings.cutoffs:
            chi2 = graph.chi2(found)
            if bool((chi2 <= settings.cutoff**2).all()):
                break
            found, _ = graph.step(found, geman_mcclure(chi2, cutoff))
        for _ in range(settings.iterations):
            found, move = graph.step(found, (graph.chi2(found) <= settings.cutoff**2).astype(float))
            if move < settings.tolerance:
                break
        if not graph.truncated(found, settings.cutoff) < before - 1e-9:
            found = poses
        return Ended(found, graph.chi2(found) <= settings.cutoff**2)

    def fill(self, closures: Closures) -> int:
        """Return how many blocks the factor of a solve with closures has: its time grows faster than they do."""
        return len(self._graph(closures, len(self.odometry.i) + 1).pattern.rows)

    def error(self, poses: FloatArray, closures: Closures) -> float:
        """Return the squared error of odometry and closures at poses (N, 3)."""
        return float(self.odometry.chi2(poses).sum() + Links.of(closures).chi2(poses).sum())

    def log_volume(self, poses: FloatArray, closures: Closures) -> float:
        """Return the log determinant of what odometry and closures know of poses (N, 3), the first one held."""
        graph = self._graph(closures, len(poses))
        return graph.pattern.log_determinant(graph.factor(poses, np.ones(len(closures)))[0])

    def known(self, poses: FloatArray, closures: Closures) -> tuple[FloatArray, FloatArray]:
        """Return what closures miss by (M, 3) in a map solved with them, and how well it knows that (M, 3, 3).

        Both are in the frame of the closure's start, for one without a heading in the map's axes.
        """
        graph, links = self._graph(closures, len(poses)), Links.of(closures)
        inverse = graph.pattern.inverse(graph.factor(poses, np.ones(len(closures)))[0])
        at = graph.pattern.at[len(self.odometry.i) :]
        return links.seen(poses), links.known(graph.pattern, at, poses, inverse)

    def _graph(self, closures: Closures, nodes: int) -> _Graph:
        """Return the network; its pattern is the last one's where that has room and isn't much too large."""
        links, last = Links.of(closures), self._last
        ends, pattern = self.odometry.beside(links), None
        if last is not None and len(ends.i) >= FILLED * len(last.pattern.at):
            pattern = last.pattern.joining(ends.i, ends.j)
        self._last = _Graph(self.odometry, links, closures.weight, pattern or BlockPattern(nodes, ends.i, ends.j))
        return self._last


class _Graph:
    """Odometry and closures as one network of links, and its steps."""

    def __init__(self, odometry: Links, closures: Links, weight: FloatArray, pattern: BlockPattern) -> None:
        self._odometry, self._closures, self._weight = odometry, closures, weight
        self._links = odometry.beside(closures)
        self._firm = np.ones(len(odometry.i))
        self.pattern = pattern

    def chi2(self, poses: FloatArray) -> FloatArray:
        """Return the closures' squared errors (M,) without their weights: a light one has to fit as well."""
        return self._closures.chi2(poses) / np.maximum(self._weight, 1e-12)

    def truncated(self, poses: FloatArray, cutoff: float) -> float:
        """Return the squared error in which a closure costs at most cutoff^2 times its weight."""
        closures = np.minimum(self._closures.chi2(poses), cutoff**2 * self._weight)
        return float(self._odometry.chi2(poses).sum() + closures.sum())

    def factor(self, poses: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the factor of a Gauss-Newton step with closure weights (M,), and its right side (N, 3)."""
        blocks, right = self._links.normal_equations(self.pattern, poses, np.concatenate([self._firm, weights]))
        blocks[self.pattern.first[self.pattern.place[0]]] += ANCHOR * np.eye(3)
        if not self.pattern.factor(blocks):
            raise TopomapError("the pose graph isn't determined: its chain is too soft between two closures")
        return blocks, right

    def step(self, poses: FloatArray, weights: FloatArray) -> tuple[FloatArray, float]:
        """Return the poses after a Gauss-Newton step, halved while that is worse, and its largest move."""
        factor, right = self.factor(poses, weights)
        step = self.pattern.solve(factor, right)
        before, length = self._error(poses, weights), 1.0
        for _ in range(HALVINGS):
            moved = poses + length * step
            moved[:, 2] = wrap_all(moved[:, 2])
            if self._error(moved, weights) <= before * (1 + 1e-9) + 1e-9:
                return moved, float(np.abs(step).max()) * length
            length /= 2
        return poses, 0.0

    def _error(self, poses: FloatArray, weights: FloatArray) -> float:
        return float(self._odometry.chi2(poses).sum() + weights @ self._closures.chi2(poses))
