"""Relative poses between N poses, linearised and summed up into the normal equations, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.records import UNKNOWN_HEADING
from topomap.mapping.optimizer.block_cholesky import BlockPattern
from topomap.mapping.optimizer.problem import Closures
from topomap.mapping.uncertainty.small import wrapped


class Links(NamedTuple):
    """E measured relative poses `i_from_j`: i, j (E,), relative (E, 3), information (E, 3, 3); blind (E,): nothing is
    measured of the heading, and the position has the same information both ways.
    """

    i: IntArray
    j: IntArray
    relative: FloatArray
    information: FloatArray
    blind: BoolArray

    @staticmethod
    def of(closures: Closures) -> Links:
        """Return closures with their weights as links."""
        blind = closures.covariance[:, 2, 2] > UNKNOWN_HEADING
        information = np.asarray(np.linalg.inv(closures.covariance), float)
        even = 2.0 / (closures.covariance[blind, 0, 0] + closures.covariance[blind, 1, 1])
        information[blind] = np.diag([1.0, 1.0, 0.0]) * even[:, None, None]
        information *= closures.weight[:, None, None]
        return Links(closures.i, closures.j, closures.relative, information, blind)

    def beside(self, other: Links) -> Links:
        """Return these links and others behind them."""
        return Links(*(np.concatenate(parts) for parts in zip(self, other, strict=True)))

    def chi2(self, poses: FloatArray) -> FloatArray:
        """Return what each misses by (E,), squared and in sigmas, in a map of poses (N, 3)."""
        return np.asarray(_chi2(*self, poses))

    def seen(self, poses: FloatArray) -> FloatArray:
        """Return what each misses by (E, 3), in the frame of its start; for blind ones in the map's axes."""
        return np.asarray(_all_missed(*self, poses))

    def known(self, pattern: BlockPattern, at: IntArray, poses: FloatArray, inverse: FloatArray) -> FloatArray:
        """Return (E, 3, 3) how well a map knows what they measure; at (E,): where their blocks stand in the inverse."""
        return np.asarray(_known(*self, poses, pattern.place, pattern.first, at, inverse))

    def normal_equations(
        self, pattern: BlockPattern, poses: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the lower half of the matrix (B, 3, 3) and the right side (N, 3) of a Gauss-Newton step."""
        blocks, right = pattern.blocks(), np.zeros_like(poses)
        _sum_up(*self, poses, weights, pattern.place, pattern.first, pattern.at, blocks, right)
        return blocks, right


@njit(cache=True)
def _linear(
    i: int, j: int, relative: FloatArray, blind: bool, poses: FloatArray
) -> tuple[float, float, float, float, float, float, float]:
    """Return what a link misses by, x, y and heading, and its derivatives by both poses, as c, s, u, v.

    The one by the end is the turn [[c, s, 0], [-s, c, 0], [0, 0, 1]], that by the start the same with a minus and with
    u, v in its last column. In the frame of the start; without a heading in the map's axes, so that it turns nothing by
    being linearised.
    """
    c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
    x, y = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
    if blind:
        ahead_x, ahead_y = c * relative[0] - s * relative[1], s * relative[0] + c * relative[1]
        return x - ahead_x, y - ahead_y, 0.0, 1.0, 0.0, ahead_y, -ahead_x
    along, across = c * x + s * y, c * y - s * x
    heading = wrapped(poses[j, 2] - poses[i, 2] - relative[2])
    return along - relative[0], across - relative[1], heading, c, s, across, -along


@njit(cache=True)
def _missed(
    i: int, j: int, relative: FloatArray, blind: bool, poses: FloatArray, out: FloatArray, by_i: FloatArray,
    by_j: FloatArray,
) -> None:  # fmt: skip
    """Write what a link misses by (3,) and its derivatives (3, 3) by both poses."""
    out[0], out[1], out[2], c, s, u, v = _linear(i, j, relative, blind, poses)
    by_j[:] = 0.0
    by_j[0, 0], by_j[0, 1], by_j[1, 0], by_j[1, 1], by_j[2, 2] = c, s, -s, c, 1.0
    by_i[:] = -by_j
    by_i[0, 2], by_i[1, 2] = u, v


@njit(cache=True)
def _chi2(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray
) -> FloatArray:
    result = np.zeros(len(i))
    for n in range(len(i)):
        x, y, heading = _linear(i[n], j[n], relative[n], blind[n], poses)[:3]
        total = 0.0
        for r, own in enumerate((x, y, heading)):
            total += own * information[n, r, 0] * x
            total += own * information[n, r, 1] * y
            total += own * information[n, r, 2] * heading
        result[n] = total
    return result


@njit(cache=True)
def _all_missed(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray
) -> FloatArray:
    result, by_i, by_j = np.zeros((len(i), 3)), np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(i)):
        _missed(i[n], j[n], relative[n], blind[n], poses, result[n], by_i, by_j)
    return result


@njit(cache=True)
def _known(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray,
    place: IntArray, first: IntArray, at: IntArray, inverse: FloatArray,
) -> FloatArray:  # fmt: skip
    result = np.zeros((len(i), 3, 3))
    missed, by_i, by_j = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(i)):
        _missed(i[n], j[n], relative[n], blind[n], poses, missed, by_i, by_j)
        across = inverse[at[n]] if place[i[n]] > place[j[n]] else inverse[at[n]].T
        both = by_i @ np.ascontiguousarray(across) @ by_j.T
        own = by_i @ inverse[first[place[i[n]]]] @ by_i.T + by_j @ inverse[first[place[j[n]]]] @ by_j.T
        result[n] = own + both + both.T
    return result


@njit(cache=True)
def _sum_up(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray,
    weights: FloatArray, place: IntArray, first: IntArray, at: IntArray, blocks: FloatArray, right: FloatArray,
) -> None:  # fmt: skip
    for n in range(len(i)):
        weight = weights[n]
        if weight <= 0.0:
            continue
        x, y, heading, c, s, u, v = _linear(i[n], j[n], relative[n], blind[n], poses)
        own_i, own_j, below = first[place[i[n]]], first[place[j[n]]], place[i[n]] > place[j[n]]
        # rows of derivative^T information, in which those of the start are the end's with a minus but for the last one
        for r, (p, q, t) in enumerate(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))):
            a0, a1, a2 = _row(information, n, weight * p, weight * q, weight * t)
            b0, b1, b2 = -a0, -a1, -a2
            if r == 2:
                b0, b1, b2 = _row(information, n, weight * u, weight * v, -weight)
            _add(blocks, own_i, r, b0, b1, b2, -c, -s, u, v, -1.0)
            _add(blocks, own_j, r, a0, a1, a2, c, s, 0.0, 0.0, 1.0)
            if below:
                _add(blocks, at[n], r, b0, b1, b2, c, s, 0.0, 0.0, 1.0)
            else:
                _add(blocks, at[n], r, a0, a1, a2, -c, -s, u, v, -1.0)
            right[i[n], r] = right[i[n], r] - b0 * x - b1 * y - b2 * heading
            right[j[n], r] = right[j[n], r] - a0 * x - a1 * y - a2 * heading


@njit(cache=True)
def _row(information: FloatArray, n: int, p: float, q: float, t: float) -> tuple[float, float, float]:
    """Return p, q, t times the n-th information."""
    a = p * information[n, 0, 0] + q * information[n, 1, 0] + t * information[n, 2, 0]
    b = p * information[n, 0, 1] + q * information[n, 1, 1] + t * information[n, 2, 1]
    return a, b, p * information[n, 0, 2] + q * information[n, 1, 2] + t * information[n, 2, 2]


@njit(cache=True)
def _add(
    blocks: FloatArray, b: int, r: int, x: float, y: float, z: float, c: float, s: float, u: float, v: float, t: float
) -> None:
    """Add x, y, z times [[c, s, u], [-s, c, v], [0, 0, t]] to a row of a block."""
    blocks[b, r, 0] = blocks[b, r, 0] + x * c - y * s
    blocks[b, r, 1] = blocks[b, r, 1] + x * s + y * c
    blocks[b, r, 2] = blocks[b, r, 2] + x * u + y * v + z * t
