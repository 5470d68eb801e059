"""The derivative of every pose by the calibration along the chain, which keeps long chains well conditioned.

In absolute poses every odometry edge pulls at the calibration, and all but the prior's pull cancels again when the
poses are eliminated: after a thousand edges double precision is used up, and the calibration's covariance is noise.
With each pose written as its own step plus what the calibration's step does to the chain up to it, odometry no longer
sees the calibration, and nothing has to cancel.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.optimizer.residuals import Residuals


def calibration_jacobian(odometry: Residuals, poses: FloatArray, anchor: int) -> FloatArray:
    """Return (N, 3, 3) how each pose moves with the calibration while every odometry residual stays as it is.

    odometry: whitened blocks in travel order, each beginning where the last one ended; poses (N, 3); the anchor stays.
    """
    result = np.zeros((len(poses), 3, 3))
    if odometry.by_calibration is not None:
        turned = np.linalg.solve(odometry.by_j, odometry.by_i)
        shifted = np.linalg.solve(odometry.by_j, odometry.by_calibration)
        _along(odometry.i, odometry.j, turned, shifted, result)
    # the whole map turned and shifted back, so that the anchor stays
    lever = np.tile(np.eye(3), (len(poses), 1, 1))
    lever[:, 0, 2], lever[:, 1, 2] = -poses[:, 1], poses[:, 0]
    return np.asarray(result - lever @ np.linalg.solve(lever[anchor], result[anchor]))


def with_calibration(blocks: Residuals, carry: FloatArray) -> Residuals:
    """Return residuals (not odometry's) as functions of the poses' own steps and of the calibration."""
    return blocks._replace(by_calibration=blocks.by_i @ carry[blocks.i] + blocks.by_j @ carry[blocks.j])


@njit(cache=True)
def _along(i: IntArray, j: IntArray, turned: FloatArray, shifted: FloatArray, result: FloatArray) -> None:
    for n in range(len(i)):
        for p in range(3):
            for q in range(3):
                total = -shifted[n, p, q]
                for k in range(3):
                    total -= turned[n, p, k] * result[i[n], k, q]
                result[j[n], p, q] = total
