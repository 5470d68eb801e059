"""gtsam's own optimisers on a pose graph with fixed odometry errors, to compare with."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import gtsam
import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.optimizer.problem import Closures
from topomap.mapping.optimizer.residuals import closure_chi2
from topomap.mapping.pose_graph import PoseGraph

ANCHOR_SIGMA = 1e-3
INLIER = 3.4  # sigmas: 99 % at 3 dof, as in OptimizerSettings

Wrap = Callable[[gtsam.noiseModel.Base], gtsam.noiseModel.Base]


class Built(NamedTuple):
    """A pose graph as gtsam's factors, odometry first behind the anchor, and dead reckoning as its start."""

    factors: gtsam.NonlinearFactorGraph
    start: gtsam.Values


class Found(NamedTuple):
    """What a peer found: its values, and weights (M,) of the closures if it gives any."""

    values: gtsam.Values
    weights: FloatArray | None


class Peer(NamedTuple):
    """An optimiser of gtsam: what is done to the closures' noise, and the optimisation itself."""

    wrap: Wrap
    solve: Callable[[Built, int], Found]

    def build(self, graph: PoseGraph) -> Built:
        """Return the graph as the peer takes it."""
        return Built(_factors(graph, self.wrap), _values(graph.dead_reckoning()))


def inliers(graph: PoseGraph, found: Found) -> tuple[FloatArray, BoolArray]:
    """Return the poses (N, 3) that a peer found, and which closures (M,) it takes for true."""
    poses = _poses(found.values, graph.nodes)
    if found.weights is not None:
        return poses, found.weights > 0.5
    closures = Closures(graph.i, graph.j, graph.relative, graph.covariance, np.ones(len(graph.i)))
    return poses, closure_chi2(poses, closures, np.zeros((3, 3))) <= INLIER**2


def optimum(graph: PoseGraph) -> FloatArray:
    """Return the poses (N, 3) that fit best when every closure is true, from a linear start (LAGO)."""
    start = gtsam.lago.initialize(_factors(graph, _diagonal, _diagonal))
    return _poses(gtsam.LevenbergMarquardtOptimizer(_factors(graph, _as_stated), start).optimize(), graph.nodes)


def _as_stated(model: gtsam.noiseModel.Base) -> gtsam.noiseModel.Base:
    return model


def _diagonal(model: gtsam.noiseModel.Base) -> gtsam.noiseModel.Base:
    """Return the sigmas alone: what LAGO understands."""
    return gtsam.noiseModel.Diagonal.Sigmas(model.sigmas())


def _huber(model: gtsam.noiseModel.Base) -> gtsam.noiseModel.Base:
    return gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Huber.Create(1.345), model)


def _dcs(model: gtsam.noiseModel.Base) -> gtsam.noiseModel.Base:
    return gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.DCS.Create(1.0), model)


def _levenberg_marquardt(built: Built, _: int) -> Found:
    return Found(gtsam.LevenbergMarquardtOptimizer(*built).optimize(), None)


def _gnc(built: Built, nodes: int) -> Found:
    """Truncated least squares at 99 %, odometry as known inliers."""
    parameters = gtsam.GncLMParams(gtsam.LevenbergMarquardtParams())
    parameters.setLossType(gtsam.GncLossType.TLS)
    parameters.setKnownInliers(list(range(nodes)))
    optimizer = gtsam.GncLMOptimizer(*built, parameters)
    optimizer.setInlierCostThresholdsAtProbability(0.99)
    values = optimizer.optimize()
    return Found(values, np.asarray(optimizer.getWeights())[nodes:])


PEERS = {
    "DCS": Peer(_dcs, _levenberg_marquardt),  # dynamic covariance scaling (Agarwal et al. 2013, phi = 1)
    "GNC": Peer(_as_stated, _gnc),
    "Huber": Peer(_huber, _levenberg_marquardt),
    "Levenberg-Marquardt": Peer(_as_stated, _levenberg_marquardt),
}


def _factors(graph: PoseGraph, wrap: Wrap, firm: Wrap = _as_stated) -> gtsam.NonlinearFactorGraph:
    """Return the anchor, odometry with its noise as `firm` makes it, closures with theirs as `wrap` does."""
    factors = gtsam.NonlinearFactorGraph()
    factors.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, ANCHOR_SIGMA)))
    steps = np.arange(graph.nodes - 1)
    _add(factors, steps, steps + 1, graph.odometry, graph.odometry_covariance, firm)
    _add(factors, graph.i, graph.j, graph.relative, graph.covariance, wrap)
    return factors


def _add(
    factors: gtsam.NonlinearFactorGraph, i: IntArray, j: IntArray, relative: FloatArray, covariance: FloatArray,
    wrap: Wrap,
) -> None:  # fmt: skip
    """Add edges with their noise turned into the frame of the edge's end, where gtsam measures it."""
    to_end = np.zeros_like(covariance)
    c, s = np.cos(relative[:, 2]), np.sin(relative[:, 2])
    to_end[:, 0, 0], to_end[:, 0, 1], to_end[:, 1, 0], to_end[:, 1, 1], to_end[:, 2, 2] = c, s, -s, c, 1.0
    spread = to_end @ covariance @ to_end.transpose(0, 2, 1)
    for a, b, row, noise in zip(i.tolist(), j.tolist(), relative, spread, strict=True):
        model = wrap(gtsam.noiseModel.Gaussian.Covariance(noise))
        factors.add(gtsam.BetweenFactorPose2(a, b, gtsam.Pose2(*row), model))


def _values(poses: FloatArray) -> gtsam.Values:
    values = gtsam.Values()
    for k, row in enumerate(poses):
        values.insert(k, gtsam.Pose2(*row))
    return values


def _poses(values: gtsam.Values, nodes: int) -> FloatArray:
    poses = [values.atPose2(k) for k in range(nodes)]
    return np.array([(p.x(), p.y(), p.theta()) for p in poses])
