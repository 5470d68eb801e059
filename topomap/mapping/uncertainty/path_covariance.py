"""Covariances between places along the best path, which may lead over one closure; for many places at once.

Errors are summed in the map frame about its origin (`Chain`), where those of a way's parts simply add; a way over a
closure is the chain to one end, the closure, and the chain from its other end, taken as independent.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray


@njit(cache=True)
def _add_way(
    total: FloatArray, random: FloatArray, systematic: FloatArray, calibration: FloatArray, i: int, j: int
) -> None:
    """Add the errors (3, 3) of the chain between places i and j."""
    low, high = min(i, j), max(i, j)
    for p in range(3):
        for q in range(3):
            total[p, q] += random[high, p, q] - random[low, p, q]
            for k in range(3):
                by_k = systematic[high, p, k] - systematic[low, p, k]
                for m in range(3):
                    total[p, q] += by_k * calibration[k, m] * (systematic[high, q, m] - systematic[low, q, m])


@njit(cache=True)
def _at(total: FloatArray, x: float, y: float) -> tuple[float, float, float]:
    """Return the variances in x and y and their covariance at a point, of errors about the origin."""
    xt, yt, tt = total[0, 2], total[1, 2], total[2, 2]
    xx = total[0, 0] - 2 * y * xt + y * y * tt
    yy = total[1, 1] + 2 * x * yt + x * x * tt
    xy = total[0, 1] + x * xt - y * yt - x * y * tt
    return xx, yy, xy


@njit(cache=True)
def _along(
    random: FloatArray, systematic: FloatArray, calibration: FloatArray, i: int, j: int, x: float, y: float
) -> tuple[float, float, float]:
    """Return what `_at` returns of the errors that `_add_way` adds, at a fourth of the work."""
    low, high = min(i, j), max(i, j)
    a, b = random[low], random[high]
    xt, yt, tt = b[0, 2] - a[0, 2], b[1, 2] - a[1, 2], b[2, 2] - a[2, 2]
    xx = b[0, 0] - a[0, 0] - 2 * y * xt + y * y * tt
    yy = b[1, 1] - a[1, 1] + 2 * x * yt + x * x * tt
    xy = b[0, 1] - a[0, 1] + x * xt - y * yt - x * y * tt
    p, q = systematic[low], systematic[high]
    t0, t1, t2 = q[2, 0] - p[2, 0], q[2, 1] - p[2, 1], q[2, 2] - p[2, 2]
    u0, u1, u2 = q[0, 0] - p[0, 0] - y * t0, q[0, 1] - p[0, 1] - y * t1, q[0, 2] - p[0, 2] - y * t2
    v0, v1, v2 = q[1, 0] - p[1, 0] + x * t0, q[1, 1] - p[1, 1] + x * t1, q[1, 2] - p[1, 2] + x * t2
    for k in range(3):
        c0, c1, c2 = calibration[0, k], calibration[1, k], calibration[2, k]
        by_u, by_v = u0 * c0 + u1 * c1 + u2 * c2, v0 * c0 + v1 * c1 + v2 * c2
        u, v = (u0, v0) if k == 0 else ((u1, v1) if k == 1 else (u2, v2))
        xx += by_u * u
        yy += by_v * v
        xy += by_u * v
    return xx, yy, xy


@njit(cache=True)
def best_way(
    random: FloatArray, systematic: FloatArray, calibration: FloatArray, i: int, j: int, x: float, y: float,
    ends: IntArray, closures: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the errors (3, 3) between chain places i and j by the way that knows j's position x, y best.

    ends (M, 2): chain places joined by closures (M, 3, 3), these about the origin.
    """
    best, over, way = np.zeros((3, 3)), -1, 0
    xx, yy, _ = _along(random, systematic, calibration, i, j, x, y)
    least = xx + yy
    for m in range(len(ends)):
        own_x, own_y, _ = _at(closures[m], x, y)
        for turn in range(2):
            ax, ay, _ = _along(random, systematic, calibration, i, ends[m, turn], x, y)
            bx, by, _ = _along(random, systematic, calibration, ends[m, 1 - turn], j, x, y)
            total = own_x + own_y + ax + ay + bx + by
            if total < least:
                least, over, way = total, m, turn
    if over < 0:
        _add_way(best, random, systematic, calibration, i, j)
        return best
    best[:] = closures[over]
    _add_way(best, random, systematic, calibration, i, ends[over, way])
    _add_way(best, random, systematic, calibration, ends[over, 1 - way], j)
    return best


@njit(cache=True)
def joined_way(
    random: FloatArray, systematic: FloatArray, calibration: FloatArray, i: int, j: int, ends: IntArray,
    closures: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the errors (3, 3) between chain places i and j by at least one closure after another and the chain.

    ends (M, 2): chain places joined by closures (M, 3, 3), these about the origin and in the order of their second
    ends. Where one stretch lies along another, what each closure tells adds up: a Kalman filter whose state is how the
    two stretches lie to one another, and which both drift apart on the way from closure to closure.
    """
    total = np.zeros((3, 3))
    _add_way(total, random, systematic, calibration, ends[0, 0], ends[0, 1])
    for m in range(len(ends)):
        if m:
            _add_way(total, random, systematic, calibration, ends[m - 1, 0], ends[m, 0])
            _add_way(total, random, systematic, calibration, ends[m - 1, 1], ends[m, 1])
        total = total @ np.linalg.solve(total + closures[m], closures[m])
        total = (total + total.T) / 2
    _add_way(total, random, systematic, calibration, ends[-1, 0], i)
    _add_way(total, random, systematic, calibration, ends[-1, 1], j)
    return total


@njit(cache=True)
def seen_from_all(
    random: FloatArray, systematic: FloatArray, calibration: FloatArray, j: int, x: float, y: float,
    ends: IntArray, closures: FloatArray, spare: float,
) -> FloatArray:  # fmt: skip
    """Return (N, 2, 2) informations of the position x, y of chain place j, seen from every place.

    The errors are those of `best_way`, a closure being used from its first end only; spare [m^2] is added to them.
    """
    result = np.empty((len(random), 2, 2))
    rest = np.empty((len(ends), 3))
    for m in range(len(ends)):
        total = closures[m].copy()
        _add_way(total, random, systematic, calibration, ends[m, 1], j)
        rest[m] = _at(total, x, y)
    for i in range(len(random)):
        xx, yy, xy = _along(random, systematic, calibration, i, j, x, y)
        for m in range(len(ends)):
            ax, ay, axy = _along(random, systematic, calibration, i, ends[m, 0], x, y)
            ax, ay, axy = ax + rest[m, 0], ay + rest[m, 1], axy + rest[m, 2]
            if ax + ay < xx + yy:
                xx, yy, xy = ax, ay, axy
        xx, yy = xx + spare, yy + spare
        area = xx * yy - xy * xy
        result[i, 0, 0], result[i, 1, 1] = yy / area, xx / area
        result[i, 0, 1] = result[i, 1, 0] = -xy / area
    return result


def turned(errors: FloatArray, heading: float, x: float, y: float) -> FloatArray:
    """Return errors (3, 3) about the origin as those at x, y in a frame of that heading."""
    c, s = math.cos(heading), math.sin(heading)
    back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array(
        [[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]]
    )
    return np.asarray(back @ errors @ back.T)
