"""The linear system of one step: normal equations over poses and calibration, solved by elimination."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from topomap.errors import TopomapError
from topomap.geometry import FloatArray
from topomap.mapping.backend.blocks import Blocks
from topomap.mapping.backend.problem import IntArray
from topomap.mapping.backend.sparse import BoolArray, Factor, Pattern

ANCHOR_SIGMA = 1e-3  # [m, rad] the anchor's residual is zero at the solution, so this only sets the conditioning


class LinearSystem:
    """Normal equations over N poses and one calibration vector, which stands in the border.

    The edges' poses must be given to the pattern in the order in which they are added.
    """

    def __init__(self, pattern: Pattern, anchor: int) -> None:
        nodes = len(pattern.order)
        self._pattern, self._edges = pattern, 0
        self._diagonal, self._off = np.zeros((nodes, 3, 3)), np.zeros((pattern.blocks, 3, 3))
        self._right = np.zeros((nodes, 3, 4))  # of the poses: the gradient, and their border with the calibration
        self._corner, self._gradient = np.zeros((3, 3)), np.zeros(3)
        self._diagonal[anchor] += np.eye(3) / ANCHOR_SIGMA**2
        self._factor: Factor | None = None

    def add_calibration_prior(self, residual: FloatArray, sigmas: FloatArray) -> None:
        """Add the prior on the calibration: residual (3,) from its mean, sigmas (3,)."""
        self._corner += np.diag(1 / sigmas**2)
        self._gradient += residual / sigmas**2

    def add(self, blocks: Blocks, weights: FloatArray | None = None) -> None:
        """Add every residual, its square counted weights (n,) times."""
        weighed = np.ones(len(blocks.i)) if weights is None else weights
        part = slice(self._edges, self._edges + len(blocks.i))
        slot, swapped = self._pattern.slot[part], self._pattern.swapped[part]
        self._edges += len(blocks.i)
        _accumulate(
            blocks.i, blocks.j, blocks.by_i, blocks.by_j, blocks.residual, weighed, slot, swapped,
            self._diagonal, self._off, self._right,
        )  # fmt: skip
        if blocks.by_calibration is not None:
            _border(
                blocks.i, blocks.j, blocks.by_i, blocks.by_j, blocks.by_calibration, blocks.residual, weighed,
                self._right, self._corner, self._gradient,
            )  # fmt: skip

    def solve(self) -> tuple[FloatArray, FloatArray]:
        """Return the step of poses (N, 3) and calibration (3,); raises TopomapError if undetermined."""
        solved = self._eliminated().solve(self._right)
        border = self._right[:, :, 1:].reshape(-1, 3)
        corner = self._corner - border.T @ solved[:, :, 1:].reshape(-1, 3)
        gradient = self._gradient - border.T @ solved[:, :, 0].reshape(-1)
        calibration = -np.linalg.solve(corner, gradient)
        poses = -solved[:, :, 0] - solved[:, :, 1:] @ calibration
        if not (np.isfinite(poses).all() and np.isfinite(calibration).all()):
            raise TopomapError("the pose graph isn't determined: the step is infinite")
        return poses, np.asarray(calibration, float)

    def _eliminated(self) -> Factor:
        if self._factor is None:
            self._factor = self._pattern.factorise(self._diagonal, self._off)
        if self._factor is None:
            raise TopomapError("the pose graph isn't determined: a node hangs on nothing")
        return self._factor

    def covariance(self) -> FloatArray:
        """Return the marginal covariance (3, 3) of the calibration."""
        return self.marginals(())[1]

    def marginals(self, nodes: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return the marginal covariances (n, 3, 3) of these poses and (3, 3) of the calibration."""
        solved = self._eliminated().solve(np.ascontiguousarray(self._right[:, :, 1:]))
        border = self._right[:, :, 1:].reshape(-1, 3)
        calibration = np.linalg.inv(self._corner - border.T @ solved.reshape(-1, 3))
        poses = [self._conditional(k) + solved[k] @ calibration @ solved[k].T for k in nodes]
        return np.array(poses, float).reshape(-1, 3, 3), np.asarray(calibration, float)

    def _conditional(self, node: int) -> FloatArray:
        """Return the covariance (3, 3) of a pose with the calibration given."""
        unit = np.zeros((len(self._right), 3, 3))
        unit[node] = np.eye(3)
        return np.asarray(self._eliminated().solve(unit)[node])


@njit(cache=True)
def _accumulate(
    i: IntArray, j: IntArray, by_i: FloatArray, by_j: FloatArray, residual: FloatArray, weights: FloatArray,
    slot: IntArray, swapped: BoolArray, diagonal: FloatArray, off: FloatArray, right: FloatArray,
) -> None:  # fmt: skip
    for n in range(len(i)):
        a, b, w, s = i[n], j[n], weights[n], slot[n]
        for k in range(residual.shape[1]):
            for p in range(3):
                x, y = w * by_i[n, k, p], w * by_j[n, k, p]
                right[a, p, 0] += x * residual[n, k]
                right[b, p, 0] += y * residual[n, k]
                for q in range(3):
                    diagonal[a, p, q] += x * by_i[n, k, q]
                    diagonal[b, p, q] += y * by_j[n, k, q]
                    if swapped[n]:
                        off[s, p, q] += y * by_i[n, k, q]
                    else:
                        off[s, p, q] += x * by_j[n, k, q]


@njit(cache=True)
def _border(
    i: IntArray, j: IntArray, by_i: FloatArray, by_j: FloatArray, by_calibration: FloatArray, residual: FloatArray,
    weights: FloatArray, right: FloatArray, corner: FloatArray, gradient: FloatArray,
) -> None:  # fmt: skip
    for n in range(len(i)):
        a, b, w = i[n], j[n], weights[n]
        for k in range(residual.shape[1]):
            for p in range(3):
                z = w * by_calibration[n, k, p]
                gradient[p] += z * residual[n, k]
                for q in range(3):
                    corner[p, q] += z * by_calibration[n, k, q]
                    right[a, q, 1 + p] += z * by_i[n, k, q]
                    right[b, q, 1 + p] += z * by_j[n, k, q]
