"""Elimination of the nodes that no closure touches: gtsam solves for the others only.

Making a factor costs Python more than gtsam needs to eliminate it, and most nodes of a long route are only joined to
their neighbours. Each stretch between two nodes that are kept becomes one factor, exactly (by QR), and the
nodes left out follow by back substitution.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.optimizer.residuals import Residuals

EDGE = 5  # rows of an edge: three of odometry and two single ones, as a seen turn
STRETCH = 9  # rows of a stretch: as many as the unknowns it joins
COLUMNS = 10  # start, end, calibration, right side


class Condensed(NamedTuple):
    """A chain of N nodes with S stretches between the nodes that are kept.

    chain (N,): node ids in travel order; kept (S + 1,): places in the chain; rows (S, 9, 10): the stretches' equations
    in start, end, calibration and right side, single edges' five rows first; inner (N, 3, 13): the equations of the
    nodes left out, in the node, the stretch's start, the next node, calibration and right side.
    """

    chain: IntArray
    kept: IntArray
    rows: FloatArray
    inner: FloatArray

    def blocks(self) -> tuple[Residuals, Residuals]:
        """Return the stretches of a single edge and those of several, as residuals."""
        single = np.diff(self.kept) == 1
        return self._blocks(single, EDGE), self._blocks(~single, STRETCH)

    def left_out(self) -> IntArray:
        """Return the ids of the nodes left out."""
        out = np.ones(len(self.chain), bool)
        out[self.kept] = False
        return self.chain[out]

    def _blocks(self, which: BoolArray, height: int) -> Residuals:
        rows = self.rows[which, :height]
        i, j = self.chain[self.kept[:-1][which]], self.chain[self.kept[1:][which]]
        return Residuals(i, j, rows[:, :, :3], rows[:, :, 3:6], rows[:, :, 6:9], -rows[:, :, 9])

    def fill(self, steps: FloatArray, calibration: FloatArray) -> None:
        """Set the steps (N, 3) of the nodes left out from those of the kept ones and the calibration's (3,)."""
        along = steps[self.chain]
        _back(self.kept, self.inner, along, calibration)
        steps[self.chain] = along


def condense(chain: IntArray, odometry: Residuals, single: list[Residuals], keep: BoolArray) -> Condensed:
    """Return the chain (N,) with the nodes of keep (N,), by place in the chain, and both its ends.

    odometry: N - 1 whitened residuals along the chain, without calibration; single: for every row beside odometry's
    (two at most) residuals of one row that join neighbours of the chain, at most one an edge.
    """
    edges = np.zeros((len(odometry.i), EDGE, COLUMNS))
    edges[:, :3, :3], edges[:, :3, 3:6], edges[:, :3, 9] = odometry.by_i, odometry.by_j, -odometry.residual
    place = np.zeros(int(chain.max()) + 1, np.int64)
    place[chain] = np.arange(len(chain))
    for row, blocks in enumerate(single, 3):
        at = place[blocks.i]
        edges[at, row, :3], edges[at, row, 3:6] = blocks.by_i[:, 0], blocks.by_j[:, 0]
        edges[at, row, 9] = -blocks.residual[:, 0]
        if blocks.by_calibration is not None:
            edges[at, row, 6:9] = blocks.by_calibration[:, 0]
    ends = keep.copy()
    ends[[0, -1]] = True
    kept = np.flatnonzero(ends)
    rows, inner = np.zeros((len(kept) - 1, STRETCH, COLUMNS)), np.zeros((len(chain), 3, 13))
    _along(edges, kept, rows, inner)
    return Condensed(chain, kept, rows, inner)


@njit(cache=True)
def _along(edges: FloatArray, kept: IntArray, rows: FloatArray, inner: FloatArray) -> None:
    work = np.zeros((STRETCH + EDGE, 13))
    for s in range(len(kept) - 1):
        rows[s, :EDGE] = edges[kept[s]]
        for place in range(kept[s] + 1, kept[s + 1]):
            _stack(rows[s], edges[place], work)
            _triangular(work)
            inner[place] = work[:3]
            rows[s] = work[3:12, 3:]


@njit(cache=True)
def _stack(stretch: FloatArray, edge: FloatArray, work: FloatArray) -> None:
    """Write a stretch and the edge after it into work: the node between, start, end, calibration, right side."""
    work[:] = 0.0
    work[:STRETCH, :3] = stretch[:, 3:6]
    work[:STRETCH, 3:6] = stretch[:, :3]
    work[STRETCH:, :3] = edge[:, :3]
    work[STRETCH:, 6:9] = edge[:, 3:6]
    work[:STRETCH, 9:] = stretch[:, 6:]
    work[STRETCH:, 9:] = edge[:, 6:]


@njit(cache=True)
def _triangular(a: FloatArray) -> None:
    """Make a upper triangular up to its last column by Householder reflections."""
    n, m = a.shape
    for k in range(m - 1):
        norm = 0.0
        for i in range(k, n):
            norm += a[i, k] ** 2
        norm = np.sqrt(norm)
        if norm == 0.0:
            continue
        alpha = -norm if a[k, k] > 0 else norm
        first = a[k, k] - alpha
        scale = -1.0 / (alpha * first)  # two over the squared length of the reflection's normal
        for j in range(k + 1, m):
            dot = first * a[k, j]
            for i in range(k + 1, n):
                dot += a[i, k] * a[i, j]
            dot *= scale
            a[k, j] -= dot * first
            for i in range(k + 1, n):
                a[i, j] -= dot * a[i, k]
        a[k, k] = alpha
        for i in range(k + 1, n):
            a[i, k] = 0.0


@njit(cache=True)
def _back(kept: IntArray, inner: FloatArray, steps: FloatArray, calibration: FloatArray) -> None:
    for s in range(len(kept) - 1):
        for place in range(kept[s + 1] - 1, kept[s], -1):
            a = inner[place]
            for row in range(2, -1, -1):
                total = a[row, 12]
                for k in range(3):
                    total -= a[row, 3 + k] * steps[kept[s], k] + a[row, 6 + k] * steps[place + 1, k]
                    total -= a[row, 9 + k] * calibration[k]
                for k in range(row + 1, 3):
                    total -= a[row, k] * steps[place, k]
                steps[place, row] = total / a[row, row]
