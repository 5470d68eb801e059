"""The linear system of one step, a Gaussian factor graph that gtsam eliminates."""

from __future__ import annotations

import gtsam
import numpy as np

from topomap.errors import TopomapError
from topomap.geometry import FloatArray
from topomap.mapping.backend.blocks import Blocks

ANCHOR_SIGMA = 1e-3  # [m, rad] the anchor's residual is zero at the solution, so this only sets the conditioning


class LinearSystem:
    """Whitened residuals linear in N poses (keys 0..N-1) and one calibration vector (key N)."""

    def __init__(self, nodes: int, anchor: int) -> None:
        self._nodes = nodes
        self._graph = gtsam.GaussianFactorGraph()
        self._units = [gtsam.noiseModel.Unit.Create(rows) for rows in range(1, 4)]
        self._net: gtsam.GaussianBayesNet | None = None
        self._prior(anchor, np.eye(3) / ANCHOR_SIGMA, np.zeros(3))

    def _prior(self, key: int, root: FloatArray, residual: FloatArray) -> None:
        self._graph.add(gtsam.JacobianFactor(key, root, -residual, self._units[2]))

    def add_calibration_prior(self, residual: FloatArray, sigmas: FloatArray) -> None:
        """Add the prior on the calibration: residual (3,) from its mean, sigmas (3,)."""
        self._prior(self._nodes, np.diag(1 / sigmas), residual / sigmas)

    def add(self, blocks: Blocks, weights: FloatArray | None = None) -> None:
        """Add every residual, its square counted weights (n,) times."""
        root = np.ones(len(blocks.i)) if weights is None else np.sqrt(weights)
        by_i, by_j = blocks.by_i * root[:, None, None], blocks.by_j * root[:, None, None]
        model, add, factor = self._units[blocks.residual.shape[1] - 1], self._graph.add, gtsam.JacobianFactor
        right = -blocks.residual * root[:, None]
        rows = zip(blocks.i.tolist(), by_i, blocks.j.tolist(), by_j, right, strict=True)
        if blocks.by_calibration is None:
            for i, a, j, b, r in rows:
                add(factor(i, a, j, b, r, model))
            return
        by_calibration = blocks.by_calibration * root[:, None, None]
        for (i, a, j, b, r), c in zip(rows, by_calibration, strict=True):
            add(factor(i, a, j, b, self._nodes, c, r, model))

    def solve(self) -> tuple[FloatArray, FloatArray]:
        """Return the step of poses (N, 3) and calibration (3,); raises TopomapError if undetermined."""
        try:
            step = self._eliminated().optimize()
            poses = np.array([step.at(key) for key in range(self._nodes)])
        except (RuntimeError, IndexError) as error:
            raise TopomapError(f"the pose graph isn't determined: {_first_line(error)}") from error
        return poses, np.asarray(step.at(self._nodes))

    def covariance(self) -> FloatArray:
        """Return the marginal covariance (3, 3) of the calibration, which is eliminated last."""
        try:
            net = self._eliminated()
        except RuntimeError as error:
            raise TopomapError(f"the pose graph isn't determined: {_first_line(error)}") from error
        root = np.asarray(net.at(net.size() - 1).R())
        return np.asarray(np.linalg.inv(root.T @ root))

    def _eliminated(self) -> gtsam.GaussianBayesNet:
        # one pose at a time: gtsam takes cliques of several poses at the soft end of a long chain for undetermined
        if self._net is None:
            self._net = self._graph.eliminateSequential(self._order())
        return self._net

    def _order(self) -> gtsam.Ordering:
        # every odometry edge knows the calibration: eliminated before the poses it would join them all
        return gtsam.Ordering.ColamdConstrainedLastGaussianFactorGraph(self._graph, [self._nodes])


def _first_line(error: Exception) -> str:
    return next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)
