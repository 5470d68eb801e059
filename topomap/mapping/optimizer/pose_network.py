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
def _missed(
    start: FloatArray, end: FloatArray, claimed: FloatArray, blind: bool, out: FloatArray, by_i: FloatArray,
    by_j: FloatArray,
) -> None:  # fmt: skip
    """Write what a link misses by (3,) and its derivatives (3, 3) by both poses.

    In the frame of the start; without a heading in the map's axes, so that it turns nothing by being linearised.
    """
    c, s = np.cos(start[2]), np.sin(start[2])
    x, y = end[0] - start[0], end[1] - start[1]
    by_i[:], by_j[:] = 0.0, 0.0
    if blind:
        ahead_x, ahead_y = c * claimed[0] - s * claimed[1], s * claimed[0] + c * claimed[1]
        out[0], out[1], out[2] = x - ahead_x, y - ahead_y, 0.0
        by_j[0, 0] = by_j[1, 1] = by_j[2, 2] = 1.0
        by_i[0, 0] = by_i[1, 1] = by_i[2, 2] = -1.0
        by_i[0, 2], by_i[1, 2] = ahead_y, -ahead_x
        return
    along, across = c * x + s * y, c * y - s * x
    out[0], out[1] = along - claimed[0], across - claimed[1]
    out[2] = wrapped(end[2] - start[2] - claimed[2])
    by_j[0, 0], by_j[0, 1], by_j[1, 0], by_j[1, 1], by_j[2, 2] = c, s, -s, c, 1.0
    by_i[0, 0], by_i[0, 1], by_i[1, 0], by_i[1, 1], by_i[2, 2] = -c, -s, s, -c, -1.0
    by_i[0, 2], by_i[1, 2] = across, -along


@njit(cache=True)
def _chi2(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray
) -> FloatArray:
    result = np.zeros(len(i))
    missed, by_i, by_j = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(i)):
        _missed(poses[i[n]], poses[j[n]], relative[n], blind[n], missed, by_i, by_j)
        for r in range(3):
            for c in range(3):
                result[n] += missed[r] * information[n, r, c] * missed[c]
    return result


@njit(cache=True)
def _all_missed(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray
) -> FloatArray:
    result, by_i, by_j = np.zeros((len(i), 3)), np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(i)):
        _missed(poses[i[n]], poses[j[n]], relative[n], blind[n], result[n], by_i, by_j)
    return result


@njit(cache=True)
def _known(
    i: IntArray, j: IntArray, relative: FloatArray, information: FloatArray, blind: BoolArray, poses: FloatArray,
    place: IntArray, first: IntArray, at: IntArray, inverse: FloatArray,
) -> FloatArray:  # fmt: skip
    result = np.zeros((len(i), 3, 3))
    missed, by_i, by_j = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(i)):
        _missed(poses[i[n]], poses[j[n]], relative[n], blind[n], missed, by_i, by_j)
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
    missed, by_i, by_j = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    left_i, left_j = np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(i)):
        if weights[n] <= 0.0:
            continue
        _missed(poses[i[n]], poses[j[n]], relative[n], blind[n], missed, by_i, by_j)
        _across(by_i, information[n], weights[n], left_i)
        _across(by_j, information[n], weights[n], left_j)
        _add(left_i, by_i, blocks[first[place[i[n]]]])
        _add(left_j, by_j, blocks[first[place[j[n]]]])
        if place[i[n]] > place[j[n]]:
            _add(left_i, by_j, blocks[at[n]])
        else:
            _add(left_j, by_i, blocks[at[n]])
        for r in range(3):
            for c in range(3):
                right[i[n], r] -= left_i[r, c] * missed[c]
                right[j[n], r] -= left_j[r, c] * missed[c]


@njit(cache=True)
def _across(derivative: FloatArray, information: FloatArray, weight: float, out: FloatArray) -> None:
    """Write derivative^T information weight."""
    for r in range(3):
        for c in range(3):
            out[r, c] = 0.0
            for k in range(3):
                out[r, c] += weight * derivative[k, r] * information[k, c]


@njit(cache=True)
def _add(left: FloatArray, derivative: FloatArray, block: FloatArray) -> None:
    for r in range(3):
        for c in range(3):
            for k in range(3):
                block[r, c] += left[r, k] * derivative[k, c]
