"""The hot loop of pre-integration: many edges of raw increments, one pass."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topomap.geometry import FloatArray

IntArray = NDArray[np.int64]
Accumulated = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


@njit(cache=True)
def accumulate(deltas: FloatArray, covariances: FloatArray, starts: IntArray, rho: float, bend: float) -> Accumulated:
    """Integrate E edges in raw units with headings rho * (turn - bend * forward).

    deltas (K, 3), covariances (K, 3, 3), starts (E + 1,), rho = 1/rotation scale, bend [rad/m as read].
    Returns translation (E, 2), turn (E,), forward (E,), derivatives of the translation by log rotation
    scale (E, 2) and bend (E, 2), covariance (E, 3, 3) of translation and raw turn.
    """
    n = len(starts) - 1
    translation, by_rotation, by_bend = np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((n, 2))
    turn, forward, covariance = np.zeros(n), np.zeros(n), np.zeros((n, 3, 3))
    before, noise = np.eye(3), np.eye(3)
    for e in range(n):
        for k in range(starts[e], starts[e + 1]):
            f, s, t = deltas[k, 0], deltas[k, 1], deltas[k, 2]
            phi = rho * (turn[e] + t / 2 - bend * (forward[e] + f / 2))
            c, sn = math.cos(phi), math.sin(phi)
            dx, dy = c * f - sn * s, sn * f + c * s
            by_rotation[e, 0] += phi * dy
            by_rotation[e, 1] -= phi * dx
            along = rho * (forward[e] + f / 2)
            by_bend[e, 0] += along * dy
            by_bend[e, 1] -= along * dx
            before[0, 2], before[1, 2] = -rho * dy, rho * dx
            noise[0, 0], noise[0, 1], noise[1, 0], noise[1, 1] = c, -sn, sn, c
            noise[0, 2], noise[1, 2] = -rho * dy / 2, rho * dx / 2
            covariance[e] = before @ covariance[e] @ before.T + noise @ covariances[k] @ noise.T
            translation[e, 0] += dx
            translation[e, 1] += dy
            turn[e] += t
            forward[e] += f
    return translation, turn, forward, by_rotation, by_bend, covariance
