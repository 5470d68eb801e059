"""The hot loop of pre-integration: many edges of raw increments, one pass."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray

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
            _carry(covariance[e], -rho * dy, rho * dx)
            _add_noise(covariance[e], covariances[k], c, sn, -rho * dy / 2, rho * dx / 2)
            translation[e, 0] += dx
            translation[e, 1] += dy
            turn[e] += t
            forward[e] += f
    return translation, turn, forward, by_rotation, by_bend, covariance


# written out: a matrix product of 3 x 3 costs numba a call into BLAS, five times as much as the sums


@njit(cache=True)
def _carry(p: FloatArray, x: float, y: float) -> None:
    """Replace a symmetric p (3, 3) by F p F^T, F being the identity with the last column x, y, 1."""
    xt, yt, tt = p[0, 2], p[1, 2], p[2, 2]
    p[0, 0] += x * (2 * xt + x * tt)
    p[1, 1] += y * (2 * yt + y * tt)
    p[0, 1] += x * yt + y * xt + x * y * tt
    p[1, 0] = p[0, 1]
    p[0, 2] = p[2, 0] = xt + x * tt
    p[1, 2] = p[2, 1] = yt + y * tt


@njit(cache=True)
def _add_noise(p: FloatArray, q: FloatArray, c: float, s: float, x: float, y: float) -> None:
    """Add G q G^T to p (3, 3), G having the rows (c, -s, x), (s, c, y), (0, 0, 1) and q being symmetric."""
    ax, ay = c * q[0, 0] - s * q[0, 1] + x * q[0, 2], c * q[0, 1] - s * q[1, 1] + x * q[1, 2]
    at = c * q[0, 2] - s * q[1, 2] + x * q[2, 2]
    bx, by = s * q[0, 0] + c * q[0, 1] + y * q[0, 2], s * q[0, 1] + c * q[1, 1] + y * q[1, 2]
    bt = s * q[0, 2] + c * q[1, 2] + y * q[2, 2]
    p[0, 0] += c * ax - s * ay + x * at
    p[0, 1] += s * ax + c * ay + y * at
    p[1, 1] += s * bx + c * by + y * bt
    p[0, 2] += at
    p[1, 2] += bt
    p[2, 2] += q[2, 2]
    p[1, 0], p[2, 0], p[2, 1] = p[0, 1], p[0, 2], p[1, 2]
