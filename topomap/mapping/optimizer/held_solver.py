"""The robust solve of a pose graph whose odometry has no systematic error to find: poses alone are unknown."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
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
# products of blocks an edge up to which a pattern is taken over anyway, as a step with it then takes a fraction of what
# a new order does: 10 on intel, 25 on manhattan, each with all its true closures
LIGHT = 40
KEPT = 3  # networks that are kept: closures that stand, one a cluster of them and none are asked for in turn


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
        self._kept: list[_Graph] = []  # the newest first, as the patterns
        self._patterns: list[BlockPattern] = []

    def solve(self, poses: FloatArray, closures: Closures, settings: OptimizerSettings) -> Ended:
        """Return the poses (N, 3) with closures, from others, by graduated non-convexity as `solver.solve` does it.

        Closures end in or out; where they leave more error than the start has, the start is kept. Raises TopomapError.
        """
        graph = self._graph(closures, len(poses))
        if graph.ended is None or graph.ended.start is not poses or graph.ended.settings != settings:
            graph.ended = _Ending(poses, settings, self._solved(graph, poses, settings))
        return graph.ended.end

    def _solved(self, graph: _Graph, poses: FloatArray, settings: OptimizerSettings) -> Ended:
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
        return self._graph(closures, len(poses)).error(poses)

    def log_volume(self, poses: FloatArray, closures: Closures) -> float:
        """Return the log determinant of what odometry and closures know of poses (N, 3), the first one held."""
        graph = self._graph(closures, len(poses))
        return graph.pattern.log_determinant(graph.factor(poses, np.ones(len(closures)))[0])

    def known(self, poses: FloatArray, closures: Closures) -> tuple[FloatArray, FloatArray]:
        """Return what closures miss by (M, 3) in a map solved with them, and how well it knows that (M, 3, 3).

        Both are in the frame of the closure's start, for one without a heading in the map's axes.
        """
        graph = self._graph(closures, len(poses))
        inverse = graph.pattern.inverse(graph.factor(poses, np.ones(len(closures)))[0])
        at = graph.pattern.at[len(self.odometry.i) :]
        return graph.links.seen(poses), graph.links.known(graph.pattern, at, poses, inverse)

    def _graph(self, closures: Closures, nodes: int) -> _Graph:
        """Return the network of odometry and closures: one that is kept, or a new one."""
        found = next((graph for graph in self._kept if graph.closures.same(closures)), None)
        if found is None:
            found = self._new(closures, nodes)
        self._kept = [found, *(graph for graph in self._kept if graph is not found)][:KEPT]
        return found

    def _new(self, closures: Closures, nodes: int) -> _Graph:
        """Return a new network."""
        links = Links.of(closures)
        ends = self.odometry.beside(links)
        return _Graph(self.odometry, closures, links, self._pattern(ends.i, ends.j, nodes))

    def _pattern(self, i: IntArray, j: IntArray, nodes: int) -> BlockPattern:
        """Return a pattern with edges i, j (E,): one that is kept where it has room and isn't much too large."""
        for kept in self._patterns:
            if len(i) >= FILLED * len(kept.at) or kept.products <= LIGHT * len(i):
                pattern = kept.joining(i, j)
                if pattern is not None:
                    return pattern
        self._patterns = [BlockPattern(nodes, i, j), *self._patterns][:KEPT]
        return self._patterns[0]


class _Ending(NamedTuple):
    """Where a solve from poses (N, 3) ended."""

    start: FloatArray
    settings: OptimizerSettings
    end: Ended


class _Errors(NamedTuple):
    """Squared errors at poses (N, 3): odometry's sum and the closures' (M,)."""

    poses: FloatArray
    odometry: float
    closures: FloatArray


class _Graph:
    """Odometry and closures as one network of links, its steps, and where the last solve of it ended."""

    def __init__(self, odometry: Links, closures: Closures, links: Links, pattern: BlockPattern) -> None:
        self._odometry, self._weight = odometry, closures.weight
        self._links = odometry.beside(links)
        self._firm = np.ones(len(odometry.i))
        self._at: _Errors | None = None
        self.closures, self.links, self.pattern = closures, links, pattern
        self.ended: _Ending | None = None

    def _errors(self, poses: FloatArray) -> _Errors:
        """Return the squared errors at poses (N, 3), which are asked for several times a step."""
        if self._at is None or self._at.poses is not poses:
            self._at = _Errors(poses, float(self._odometry.chi2(poses).sum()), self.links.chi2(poses))
        return self._at

    def chi2(self, poses: FloatArray) -> FloatArray:
        """Return the closures' squared errors (M,) without their weights: a light one has to fit as well."""
        return self._errors(poses).closures / np.maximum(self._weight, 1e-12)

    def error(self, poses: FloatArray) -> float:
        """Return the squared error of odometry and closures."""
        at = self._errors(poses)
        return at.odometry + float(at.closures.sum())

    def truncated(self, poses: FloatArray, cutoff: float) -> float:
        """Return the squared error in which a closure costs at most cutoff^2 times its weight."""
        at = self._errors(poses)
        return at.odometry + float(np.minimum(at.closures, cutoff**2 * self._weight).sum())

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
        before, length = self._weighed(poses, weights), 1.0
        for _ in range(HALVINGS):
            moved = poses + length * step
            moved[:, 2] = wrap_all(moved[:, 2])
            if self._weighed(moved, weights) <= before * (1 + 1e-9) + 1e-9:
                return moved, float(np.abs(step).max()) * length
            length /= 2
        return poses, 0.0

    def _weighed(self, poses: FloatArray, weights: FloatArray) -> float:
        at = self._errors(poses)
        return at.odometry + float(weights @ at.closures)
