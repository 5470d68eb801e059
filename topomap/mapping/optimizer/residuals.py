"""Residuals of the pose graph and their derivatives, whitened, all edges at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.core.records import UNKNOWN_HEADING
from topomap.mapping.odometry.increments import Calibration, Preintegrated
from topomap.mapping.optimizer.problem import Closures

# no odometer does better over an edge: keeps a parked robot's edges from becoming infinitely stiff
FLOOR = np.diag([2e-3, 2e-3, 5e-4]) ** 2


class Residuals(NamedTuple):
    """n whitened residuals of r rows.

    i, j (n,): the poses; by_i, by_j (n, r, 3): derivatives by their x, y [m], heading [rad];
    by_calibration (n, r, 3) or None; residual (n, r).
    """

    i: IntArray
    j: IntArray
    by_i: FloatArray
    by_j: FloatArray
    by_calibration: FloatArray | None
    residual: FloatArray

    def chi2(self) -> FloatArray:
        """Return (n,) squared errors."""
        return np.asarray((self.residual**2).sum(axis=1))

    def among(self, part: BoolArray) -> Residuals:
        """Return some (n,) of the residuals."""
        calibration = None if self.by_calibration is None else self.by_calibration[part]
        return Residuals(self.i[part], self.j[part], self.by_i[part], self.by_j[part], calibration, self.residual[part])

    def weighted(self, weights: FloatArray) -> Residuals:
        """Return the residuals with their squares counted weights (n,) times."""
        root = np.sqrt(weights)
        wide = root[:, None, None]
        calibration = None if self.by_calibration is None else self.by_calibration * wide
        return self._replace(
            by_i=self.by_i * wide, by_j=self.by_j * wide, by_calibration=calibration,
            residual=self.residual * root[:, None],
        )  # fmt: skip

    def with_others(self, others: Residuals, where: BoolArray) -> Residuals:
        """Return the residuals with some (n,) from others of the same poses, which no calibration changes."""
        assert self.by_calibration is not None
        wide = where[:, None, None]
        return self._replace(
            by_i=np.where(wide, others.by_i, self.by_i), by_j=np.where(wide, others.by_j, self.by_j),
            by_calibration=np.where(wide, 0.0, self.by_calibration),
            residual=np.where(where[:, None], others.residual, self.residual),
        )  # fmt: skip


def roots(covariance: FloatArray) -> FloatArray:
    """Return (n, 3, 3) whitening matrices W with W^T W the inverse of covariance (n, 3, 3)."""
    return np.linalg.inv(np.linalg.cholesky(covariance))


def _whiten(whitening: FloatArray, *arrays: FloatArray) -> list[FloatArray]:
    return [np.einsum("nij,nj...->ni...", whitening, a) for a in arrays]


def _relative(poses: FloatArray, i: IntArray, j: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return `i_from_j` (n, 3) and its derivatives (n, 3, 3) by both poses."""
    relative = between(poses[i], poses[j])
    c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
    by_j = np.zeros((len(i), 3, 3))
    by_j[:, 0, 0], by_j[:, 0, 1], by_j[:, 1, 0], by_j[:, 1, 1], by_j[:, 2, 2] = c, s, -s, c, 1.0
    by_i = -by_j
    by_i[:, 0, 2], by_i[:, 1, 2] = relative[:, 1], -relative[:, 0]
    return relative, by_i, by_j


def odometry_residuals(poses: FloatArray, calibration: Calibration, pairs: IntArray, edges: Preintegrated) -> Residuals:
    """Return the odometry edges pairs (n, 2) in raw units.

    They are D R_i^T (t_j - t_i) - p_raw and R turn - turn_raw + C/D forward_raw. In raw units the
    noise doesn't depend on the scales. In true metres every residual would shrink with the distance scale, and a single
    false closure could shrink the whole map.
    """
    d, r = calibration.distance_scale, calibration.rotation_scale
    bend = calibration.curvature / d
    i, j = pairs[:, 0], pairs[:, 1]
    relative, by_i, by_j = _relative(poses, i, j)
    predicted = (edges.turn - bend * edges.forward) / r
    turn = wrap_all(relative[:, 2] - predicted)
    residual = np.column_stack([d * relative[:, :2] - edges.translation, r * turn])
    units = np.array([d, d, r])[None, :, None]
    by_calibration = np.empty((len(i), 3, 3))
    by_calibration[:, :2, 0] = -edges.by_rotation
    by_calibration[:, :2, 1] = -edges.by_bend / d
    by_calibration[:, :2, 2] = d * relative[:, :2] + bend * edges.by_bend
    by_calibration[:, 2, 0] = r * (turn + predicted)
    by_calibration[:, 2, 1] = edges.forward / d
    by_calibration[:, 2, 2] = -bend * edges.forward
    whitening = roots(edges.covariance + FLOOR)
    residual, a, b, c = _whiten(whitening, residual, by_i * units, by_j * units, by_calibration)
    return Residuals(i, j, a, b, c, residual)


def closure_residuals(poses: FloatArray, closures: Closures) -> Residuals:
    """Return the closures R_i^T (t_j - t_i) - p, turn - claimed turn, each times the root of its weight.

    Where the heading isn't known the residual is t_j - t_i - R_i p in the map frame with one sigma both ways,
    so that such a closure
    constrains no heading, not even through the linearisation.
    """
    relative, by_i, by_j = _relative(poses, closures.i, closures.j)
    residual = relative - closures.relative
    residual[:, 2] = wrap_all(residual[:, 2])
    blind = closures.covariance[:, 2, 2] > UNKNOWN_HEADING
    whitening = np.empty_like(closures.covariance)
    whitening[~blind] = roots(closures.covariance[~blind])
    variance = closures.covariance[blind]
    sigma = np.sqrt((variance[:, 0, 0] + variance[:, 1, 1]) / 2)
    whitening[blind] = np.diag([1.0, 1.0, 0.0]) / sigma[:, None, None]
    _free_heading(poses, closures, blind, residual, by_i, by_j)
    whitening *= np.sqrt(closures.weight)[:, None, None]
    residual, a, b = _whiten(whitening, residual, by_i, by_j)
    return Residuals(closures.i, closures.j, a, b, None, residual)


def closure_chi2(poses: FloatArray, closures: Closures, extra: FloatArray) -> FloatArray:
    """Return (n,) squared Mahalanobis distances of closures whose covariances are widened by (n, 3, 3)."""
    residual = between(poses[closures.i], poses[closures.j]) - closures.relative
    residual[:, 2] = wrap_all(residual[:, 2])
    residual[closures.covariance[:, 2, 2] > UNKNOWN_HEADING, 2] = 0.0
    solved = np.linalg.solve(closures.covariance + extra, residual[:, :, None])[:, :, 0]
    return np.asarray((residual * solved).sum(axis=1))


def _free_heading(
    poses: FloatArray, closures: Closures, blind: BoolArray,
    residual: FloatArray, by_i: FloatArray, by_j: FloatArray,
) -> None:  # fmt: skip
    """Replace the rows of closures without a heading by residuals in the map frame."""
    i, j = closures.i[blind], closures.j[blind]
    c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
    p = closures.relative[blind]
    qx, qy = c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]
    residual[blind, :2] = poses[j, :2] - poses[i, :2] - np.column_stack([qx, qy])
    by_j[blind] = np.eye(3)
    rows = np.broadcast_to(-np.eye(3), (len(i), 3, 3)).copy()
    rows[:, 0, 2], rows[:, 1, 2] = qy, -qx
    by_i[blind] = rows


def turn_residuals(poses: FloatArray, i: IntArray, j: IntArray, turn: FloatArray, sigma: FloatArray) -> Residuals:
    """Return the measured turns (n,) [rad] with sigma (n,) as residuals of one row."""
    residual = wrap_all(poses[j, 2] - poses[i, 2] - turn) / sigma
    by_j = np.zeros((len(i), 1, 3))
    by_j[:, 0, 2] = 1 / sigma
    return Residuals(i, j, -by_j, by_j, None, residual[:, None])


def axis_residuals(poses: FloatArray, i: IntArray, j: IntArray, sigma: FloatArray) -> Residuals:
    """Return how far the headings of i are off the nearest building axis, in sigmas (n,), as residuals of one row.

    The direction of the axes is where the headings are densest, not their mean: a robot that stands across the corridor
    doesn't turn the building.
    """
    headings = poses[i, 2]
    off = _to_axis(headings, _axis(headings, sigma)) / sigma
    by_i = np.zeros((len(i), 1, 3))
    by_i[:, 0, 2] = 1 / sigma
    return Residuals(i, j, by_i, np.zeros_like(by_i), None, off[:, None])


def _to_axis(headings: FloatArray, axis: float) -> FloatArray:
    return wrap_all(4 * (headings - axis)) / 4


def _axis(headings: FloatArray, sigma: FloatArray) -> float:
    """Return the direction [rad] that most headings (n,) lie near, modulo a right angle."""
    if not len(headings):
        return 0.0
    grid = np.arange(90) * (np.pi / 180)
    near = np.exp(-0.5 * (wrap_all(4 * (headings[None, :] - grid[:, None])) / (4 * 2 * sigma)) ** 2).sum(axis=1)
    axis = float(grid[int(np.argmax(near))])
    for _ in range(5):
        off = _to_axis(headings, axis)
        weight = np.exp(-0.5 * (off / (2 * sigma)) ** 2)
        axis += float((weight * off).sum() / weight.sum())
    return axis
