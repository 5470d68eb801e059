"""Covariances of plane poses (3 x 3) in compiled loops: moved, measured against, without a call into a library."""

from __future__ import annotations

import math

from numba import njit

from topomap.core.arrays import FloatArray

TAU = 2.0 * math.pi


@njit(cache=True)
def seen_from(errors: FloatArray, heading: float, x: float, y: float, out: FloatArray) -> None:
    """Write errors (3, 3) about the map's origin to out (3, 3), as those of the point x, y in a frame of that heading.

    It is J errors J^T with J = rotation(-heading) lever(x, y), as in `Chain.covariance`.
    """
    c, s, tt = math.cos(heading), math.sin(heading), errors[2, 2]
    xx = errors[0, 0] - 2 * y * errors[0, 2] + y * y * tt
    yy = errors[1, 1] + 2 * x * errors[1, 2] + x * x * tt
    xy = errors[0, 1] + x * errors[0, 2] - y * errors[1, 2] - x * y * tt
    xt, yt = errors[0, 2] - y * tt, errors[1, 2] + x * tt
    out[0, 0] = c * c * xx + 2 * c * s * xy + s * s * yy
    out[1, 1] = s * s * xx - 2 * c * s * xy + c * c * yy
    out[0, 1] = out[1, 0] = c * s * (yy - xx) + (c * c - s * s) * xy
    out[0, 2] = out[2, 0] = c * xt + s * yt
    out[1, 2] = out[2, 1] = c * yt - s * xt
    out[2, 2] = tt


@njit(cache=True)
def moved_by(errors: FloatArray, heading: float, x: float, y: float, out: FloatArray) -> None:
    """Add errors (3, 3) of a pose to out, seen through a turn [rad] and then a lever x, y [m] behind it.

    It is J errors J^T with J = lever(x, y) rotation(heading): what a composition makes of one of its factors' errors.
    """
    c, s = math.cos(heading), math.sin(heading)
    r00 = c * errors[0, 0] - s * errors[1, 0]
    r01 = c * errors[0, 1] - s * errors[1, 1]
    r02 = c * errors[0, 2] - s * errors[1, 2]
    r10 = s * errors[0, 0] + c * errors[1, 0]
    r11 = s * errors[0, 1] + c * errors[1, 1]
    r12 = s * errors[0, 2] + c * errors[1, 2]
    xx, xy, yy = c * r00 - s * r01, s * r00 + c * r01, s * r10 + c * r11
    xt, yt, tt = r02, r12, errors[2, 2]
    out[0, 0] += xx - 2 * y * xt + y * y * tt
    out[1, 1] += yy + 2 * x * yt + x * x * tt
    both = xy + x * xt - y * yt - x * y * tt
    out[0, 1] += both
    out[1, 0] += both
    out[0, 2] += xt - y * tt
    out[2, 0] += xt - y * tt
    out[1, 2] += yt + x * tt
    out[2, 1] += yt + x * tt
    out[2, 2] += tt


@njit(cache=True)
def distance2(s: FloatArray, x: float, y: float, heading: float, blind: bool) -> tuple[float, float]:
    """Return the squared Mahalanobis distance of an error by covariance s (3, 3), and the covariance's determinant.

    blind: the heading doesn't count; the determinant is then that of the position's (2, 2) [m^4].
    """
    a, b, d = s[0, 0], s[0, 1], s[1, 1]
    flat = a * d - b * b
    if blind:
        return (d * x * x - 2 * b * x * y + a * y * y) / flat, flat
    p, q, t = s[0, 2], s[1, 2], s[2, 2]
    m00, m01, m02 = d * t - q * q, p * q - b * t, b * q - d * p
    m11, m12 = a * t - p * p, b * p - a * q
    det = a * m00 + b * m01 + p * m02
    total = m00 * x * x + m11 * y * y + flat * heading * heading
    total += 2 * (m01 * x * y + m02 * x * heading + m12 * y * heading)
    return total / det, det


@njit(cache=True)
def wrapped(angle: float) -> float:
    """Return the same angle in [-pi, pi) [rad]."""
    turned = angle + math.pi
    if 0.0 <= turned < TAU:  # nearly always, and a remainder takes as long as all the rest of a squared error
        return turned - math.pi
    return turned % TAU - math.pi


@njit(cache=True)
def relative(a: FloatArray, b: FloatArray) -> tuple[float, float, float]:
    """Return x, y and heading of pose b (3,) in the frame of pose a (3,), the heading not wrapped."""
    c, s = math.cos(a[2]), math.sin(a[2])
    x, y = b[0] - a[0], b[1] - a[1]
    return c * x + s * y, c * y - s * x, b[2] - a[2]
