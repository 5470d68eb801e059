"""The linear system of one step, solved by gtsam."""

from __future__ import annotations

from collections.abc import Sequence

import gtsam
import numpy as np

from topomap.errors import TopomapError
from topomap.geometry import FloatArray
from topomap.mapping.backend.blocks import Blocks

ANCHOR_SIGMA = 1e-3  # [m, rad] the anchor's residual is zero at the solution, so this only sets the conditioning


class LinearSystem:
    """A gtsam Gaussian factor graph over N poses and one calibration vector (key N)."""

    def __init__(self, poses: int, anchor: int) -> None:
        self._poses = poses
        self._graph = gtsam.GaussianFactorGraph()
        self._units = [gtsam.noiseModel.Unit.Create(rows) for rows in range(1, 4)]
        self._prior(anchor, np.eye(3) / ANCHOR_SIGMA, np.zeros(3))

    def _prior(self, key: int, root: FloatArray, residual: FloatArray) -> None:
        self._graph.add(gtsam.JacobianFactor(key, root, -residual, self._units[2]))

    def add_calibration_prior(self, residual: FloatArray, sigmas: FloatArray) -> None:
        """Add the prior on the calibration: residual (3,) from its mean, sigmas (3,)."""
        self._prior(self._poses, np.diag(1 / sigmas), residual / sigmas)

    def add(self, blocks: Blocks) -> None:
        """Add every residual."""
        model, add, factor = self._units[blocks.residual.shape[1] - 1], self._graph.add, gtsam.JacobianFactor
        rows = zip(blocks.i.tolist(), blocks.by_i, blocks.j.tolist(), blocks.by_j, -blocks.residual, strict=True)
        if blocks.by_calibration is None:
            for i, a, j, b, r in rows:
                add(factor(i, a, j, b, r, model))
            return
        for (i, a, j, b, r), c in zip(rows, blocks.by_calibration, strict=True):
            add(factor(i, a, j, b, self._poses, c, r, model))

    def solve(self) -> tuple[FloatArray, FloatArray]:
        """Return the step of poses (N, 3) and calibration (3,); raises TopomapError if undetermined."""
        try:
            step = self._graph.optimize()
            poses = np.array([step.at(key) for key in range(self._poses)])
        except (RuntimeError, IndexError) as error:
            raise TopomapError(f"the pose graph isn't determined: {_first_line(error)}") from error
        return poses, np.asarray(step.at(self._poses))

    def covariance(self) -> FloatArray:
        """Return the marginal covariance (3, 3) of the calibration."""
        return self.marginals(())[1]

    def marginals(self, nodes: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return the marginal covariances (n, 3, 3) of these poses and (3, 3) of the calibration."""
        tree = self._graph.eliminateMultifrontal()
        poses = np.array([tree.marginalCovariance(node) for node in nodes]).reshape(-1, 3, 3)
        return poses, np.asarray(tree.marginalCovariance(self._poses))


def _first_line(error: Exception) -> str:
    return next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)
