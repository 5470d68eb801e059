"""Which claims close small loops with one another, compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.uncertainty.small import distance2, moved_by, relative, seen_from, wrapped

LEAST = 1e-6  # variance of a turn [rad^2] that even a robot standing still has


@njit(cache=True)
def _between(
    chain: FloatArray, random: FloatArray, p: int, q: int, heading: float, x: float, y: float, out: FloatArray
) -> None:
    """Add what odometry from place p to q may be off, turned by a heading and seen from x, y [m] behind it."""
    if p == q:
        return
    low, high = min(p, q), max(p, q)
    known = np.empty((3, 3))
    seen_from(random[high] - random[low], chain[p, 2], chain[q, 0], chain[q, 1], known)
    moved_by(known, heading, x, y, out)


@njit(cache=True)
def loop_distance2(
    i: IntArray, j: IntArray, claimed: FloatArray, covariance: FloatArray, blind: BoolArray, chain: FloatArray,
    random: FloatArray, a: int, b: int, turned: float, limit: float,
) -> float:  # fmt: skip
    """Return the squared Mahalanobis distance by which the loop through claims a and b misses of closing.

    turned [rad]: the heading that blind claims are taken to have; beyond the limit only "more" is told.
    """
    xi, yi, hi = relative(chain[i[a]], chain[i[b]])
    xj, yj, hj = relative(chain[j[a]], chain[j[b]])
    unknown = blind[a] or blind[b]
    ha, hb = (turned, turned) if unknown else (claimed[a, 2], claimed[b, 2])
    heading = wrapped(hi + hb - ha - hj)
    spread = np.zeros((3, 3))
    ca, sa = math.cos(ha), math.sin(ha)
    ci, si = math.cos(hi), math.sin(hi)
    ahead_x, ahead_y = ca * xj - sa * yj, sa * xj + ca * yj
    behind_x, behind_y = ci * claimed[b, 0] - si * claimed[b, 1], si * claimed[b, 0] + ci * claimed[b, 1]
    x, y = xi + behind_x - claimed[a, 0] - ahead_x, yi + behind_y - claimed[a, 1] - ahead_y
    own, other = covariance[a].copy(), covariance[b].copy()
    if unknown:
        for part in (own, other):
            part[2, :], part[:, 2] = 0.0, 0.0
    variance = LEAST + own[2, 2] + other[2, 2] + abs(random[i[b], 2, 2] - random[i[a], 2, 2])
    variance += abs(random[j[b], 2, 2] - random[j[a], 2, 2])
    if heading * heading > limit * variance:  # most loops end here
        return np.inf
    moved_by(own, 0.0, ahead_x, ahead_y, spread)
    _between(chain, random, j[a], j[b], ha, 0.0, 0.0, spread)
    _between(chain, random, i[a], i[b], 0.0, behind_x, behind_y, spread)
    moved_by(other, hi, 0.0, 0.0, spread)
    missed, _ = distance2(spread, x, y, heading, unknown)
    return float(missed)


@njit(cache=True)
def short_loops(
    i: IntArray, j: IntArray, claimed: FloatArray, covariance: FloatArray, blind: BoolArray, chain: FloatArray,
    random: FloatArray, first: IntArray, window: int, limit: float, asked: IntArray,
) -> tuple[IntArray, IntArray, FloatArray]:  # fmt: skip
    """Return pairs a, b (P,) of claims whose ends lie within a window of places, and what their loops miss by (P,).

    The claims stand in order of i, then of j; first (N + 1,): where those of each i begin; asked (n,): the a to try.
    Only loops within the limit [squared Mahalanobis distance] are returned.
    """
    room = 4 * len(i) + 16
    pairs, missed, count = np.empty((room, 2), np.int64), np.empty(room), 0
    for a in asked:
        for place in range(i[a], min(i[a] + window + 1, len(chain))):
            begin, end = first[place], first[place + 1]
            for b in range(begin + np.searchsorted(j[begin:end], j[a] - window), end):
                if j[b] > j[a] + window:
                    break
                if b <= a or (i[b] == i[a] and j[b] == j[a]):
                    continue
                chi2 = loop_distance2(i, j, claimed, covariance, blind, chain, random, a, b, 0.0, limit)
                if blind[a] or blind[b]:
                    opposite = loop_distance2(i, j, claimed, covariance, blind, chain, random, a, b, np.pi, limit)
                    chi2 = min(chi2, opposite)
                if chi2 > limit:
                    continue
                if count == len(missed):
                    pairs, missed = np.concatenate((pairs, pairs)), np.concatenate((missed, missed))
                pairs[count, 0], pairs[count, 1], missed[count] = a, b, chi2
                count += 1
    return pairs[:count, 0], pairs[:count, 1], missed[:count]
