"""The linear system of one step, a Gaussian factor graph that gtsam eliminates."""

from __future__ import annotations

import gtsam
import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.errors import TopomapError
from topomap.mapping.optimizer.elimination import STRETCH, Condensed
from topomap.mapping.optimizer.residuals import Residuals

ANCHOR_SIGMA = 1e-3  # [m, rad] the anchor's residual is zero at the solution, so this only sets the conditioning


class LinearSystem:
    """Whitened residuals linear in N poses (keys 0..N-1) and one calibration vector (key N).

    gtsam eliminates the poses that the chain keeps; those it leaves out are found from them.
    """

    def __init__(self, nodes: int, anchor: int, chain: Condensed | None) -> None:
        self._nodes, self._chain = nodes, chain
        self._graph = gtsam.GaussianFactorGraph()
        self._units = [gtsam.noiseModel.Unit.Create(rows) for rows in range(1, STRETCH + 1)]
        self._ordering: gtsam.Ordering | None = None
        self._net: gtsam.GaussianBayesNet | None = None
        self._keys = np.arange(nodes) if chain is None else np.setdiff1d(np.arange(nodes), chain.left_out())
        self._prior(anchor, np.eye(3) / ANCHOR_SIGMA, np.zeros(3))
        for blocks in () if chain is None else chain.blocks():
            self.add(blocks)

    def _prior(self, key: int, root: FloatArray, residual: FloatArray) -> None:
        self._graph.add(gtsam.JacobianFactor(key, root, -residual, self._units[2]))

    def add_calibration_prior(self, residual: FloatArray, sigmas: FloatArray) -> None:
        """Add the prior on the calibration: residual (3,) from its mean, sigmas (3,)."""
        self._prior(self._nodes, np.diag(1 / sigmas), residual / sigmas)

    def add(self, blocks: Residuals) -> None:
        """Add every residual."""
        model, add, factor = self._units[blocks.residual.shape[1] - 1], self._graph.add, gtsam.JacobianFactor
        rows = zip(blocks.i.tolist(), blocks.by_i, blocks.j.tolist(), blocks.by_j, -blocks.residual, strict=True)
        if blocks.by_calibration is None:
            for i, a, j, b, r in rows:
                add(factor(i, a, j, b, r, model))
            return
        for (i, a, j, b, r), c in zip(rows, blocks.by_calibration, strict=True):
            add(factor(i, a, j, b, self._nodes, c, r, model))

    def solve(self) -> tuple[FloatArray, FloatArray]:
        """Return the step of poses (N, 3) and calibration (3,); raises TopomapError if undetermined."""
        poses = np.zeros((self._nodes, 3))
        try:
            step = self.eliminated().optimize()
            poses[self._keys] = [step.at(key) for key in self._keys.tolist()]
        except (RuntimeError, IndexError) as error:
            raise TopomapError(f"the pose graph isn't determined: {_first_line(error)}") from error
        calibration = np.asarray(step.at(self._nodes))
        if self._chain is not None:
            self._chain.fill(poses, calibration)
        if not np.isfinite(poses).all():
            raise TopomapError("the pose graph isn't determined: its chain is too soft between two closures")
        return poses, calibration

    def covariance(self) -> FloatArray:
        """Return the marginal covariance (3, 3) of the calibration, which is eliminated last."""
        net = self.eliminated()
        root = np.asarray(net.at(net.size() - 1).R())
        return np.asarray(np.linalg.inv(root.T @ root))

    def order(self, known: gtsam.Ordering | None = None) -> gtsam.Ordering:
        """Return the order in which the poses are eliminated; known: that of a system of the same structure."""
        if self._ordering is None:
            # every odometry edge knows the calibration: eliminated before the poses it would join them all
            last = [self._nodes]
            self._ordering = known or gtsam.Ordering.ColamdConstrainedLastGaussianFactorGraph(self._graph, last)
        return self._ordering

    def eliminated(self) -> gtsam.GaussianBayesNet:
        """Return the poses' equations, each in those eliminated after it; raises TopomapError if undetermined."""
        # one pose at a time: gtsam takes cliques of several poses at the soft end of a long chain for undetermined
        if self._net is None:
            try:
                self._net = self._graph.eliminateSequential(self.order())
            except RuntimeError as error:
                raise TopomapError(f"the pose graph isn't determined: {_first_line(error)}") from error
        return self._net


def _first_line(error: Exception) -> str:
    return next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)
