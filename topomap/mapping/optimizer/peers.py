"""gtsam's own optimisers on a pose graph with fixed odometry errors, to compare with."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import gtsam
import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import compose
from topomap.mapping.optimizer.problem import Closures

ANCHOR_SIGMA = 1e-3
BELIEVED = 3.4  # sigmas: 99 % at 3 dof, as in OptimizerSettings


class PeerResult(NamedTuple):
    """What a peer found: poses (N, 3), and which closures (M,) are inliers to it."""

    poses: FloatArray
    believed: BoolArray


def levenberg_marquardt(odometry: FloatArray, covariance: FloatArray, closures: Closures) -> PeerResult:
    """Optimise as if every closure were true; odometry (N - 1, 3), covariance (N - 1, 3, 3), both `i_from_next`."""
    return _optimised(odometry, covariance, closures, lambda model: model)


def huber(odometry: FloatArray, covariance: FloatArray, closures: Closures) -> PeerResult:
    """Optimise with Huber's kernel (k = 1.345) over the closures."""
    kernel = gtsam.noiseModel.mEstimator.Huber.Create(1.345)
    return _optimised(odometry, covariance, closures, lambda model: gtsam.noiseModel.Robust.Create(kernel, model))


def dcs(odometry: FloatArray, covariance: FloatArray, closures: Closures) -> PeerResult:
    """Optimise with dynamic covariance scaling (Agarwal et al. 2013, phi = 1) over the closures."""
    kernel = gtsam.noiseModel.mEstimator.DCS.Create(1.0)
    return _optimised(odometry, covariance, closures, lambda model: gtsam.noiseModel.Robust.Create(kernel, model))


def gnc(odometry: FloatArray, covariance: FloatArray, closures: Closures) -> PeerResult:
    """Optimise with GncLMOptimizer (truncated least squares, 99 %), odometry as known inliers."""
    graph, start = _graph(odometry, covariance, closures, lambda model: model), _start(odometry)
    parameters = gtsam.GncLMParams(gtsam.LevenbergMarquardtParams())
    parameters.setLossType(gtsam.GncLossType.TLS)
    parameters.setKnownInliers(list(range(len(odometry) + 1)))
    optimizer = gtsam.GncLMOptimizer(graph, start, parameters)
    optimizer.setInlierCostThresholdsAtProbability(0.99)
    values = optimizer.optimize()
    weights = np.asarray(optimizer.getWeights())[len(odometry) + 1 :]
    return PeerResult(_poses(values, len(odometry) + 1), weights > 0.5)


PEERS: dict[str, Callable[[FloatArray, FloatArray, Closures], PeerResult]] = {
    "Levenberg-Marquardt": levenberg_marquardt,
    "Huber": huber,
    "DCS": dcs,
    "GNC": gnc,
}


def optimum(odometry: FloatArray, covariance: FloatArray, closures: Closures) -> FloatArray:
    """Return the poses (N, 3) that fit best when every closure is true, from a linear start (LAGO)."""
    graph = _graph(odometry, covariance, closures, lambda model: model)
    start = gtsam.lago.initialize(_graph(odometry, covariance, closures, _diagonal))
    values = gtsam.LevenbergMarquardtOptimizer(graph, start).optimize()
    return _poses(values, len(odometry) + 1)


def _diagonal(model: gtsam.noiseModel.Base) -> gtsam.noiseModel.Base:
    """Return the sigmas alone: what LAGO understands."""
    return gtsam.noiseModel.Diagonal.Sigmas(model.sigmas())


def _optimised(
    odometry: FloatArray,
    covariance: FloatArray,
    closures: Closures,
    wrap: Callable[[gtsam.noiseModel.Base], gtsam.noiseModel.Base],
) -> PeerResult:
    graph = _graph(odometry, covariance, closures, wrap)
    values = gtsam.LevenbergMarquardtOptimizer(graph, _start(odometry)).optimize()
    plain = _graph(odometry, covariance, closures, lambda model: model)
    first = len(odometry) + 1
    chi2 = np.array([2 * plain.at(k).error(values) for k in range(first, first + len(closures))])
    return PeerResult(_poses(values, first), chi2 <= BELIEVED**2)


def _graph(
    odometry: FloatArray,
    covariance: FloatArray,
    closures: Closures,
    wrap: Callable[[gtsam.noiseModel.Base], gtsam.noiseModel.Base],
) -> gtsam.NonlinearFactorGraph:
    graph = gtsam.NonlinearFactorGraph()
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, ANCHOR_SIGMA)))
    for k, (row, spread) in enumerate(zip(odometry, covariance, strict=True)):
        model = _model(row, spread)
        firm = _diagonal(model) if wrap is _diagonal else model
        graph.add(gtsam.BetweenFactorPose2(k, k + 1, gtsam.Pose2(*row), firm))
    edges = zip(closures.i.tolist(), closures.j.tolist(), closures.relative, closures.covariance, strict=True)
    for i, j, row, spread in edges:
        graph.add(gtsam.BetweenFactorPose2(i, j, gtsam.Pose2(*row), wrap(_model(row, spread))))
    return graph


def _model(relative: FloatArray, covariance: FloatArray) -> gtsam.noiseModel.Gaussian:
    """Return the noise in the frame of the edge's end, where gtsam measures it."""
    c, s = np.cos(relative[2]), np.sin(relative[2])
    back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return gtsam.noiseModel.Gaussian.Covariance(back @ covariance @ back.T)


def _start(odometry: FloatArray) -> gtsam.Values:
    values, pose = gtsam.Values(), np.zeros(3)
    values.insert(0, gtsam.Pose2(*pose))
    for k, row in enumerate(odometry, start=1):
        pose = compose(pose, row)
        values.insert(k, gtsam.Pose2(*pose))
    return values


def _poses(values: gtsam.Values, nodes: int) -> FloatArray:
    poses = [values.atPose2(k) for k in range(nodes)]
    return np.array([(p.x(), p.y(), p.theta()) for p in poses])
