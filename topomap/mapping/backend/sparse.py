"""A sparse symmetric system of 3 x 3 blocks: its pattern once, its L D L^T as often as numbers change.

The elimination tree and the up-looking factorisation are those of Davis, Direct Methods for Sparse Linear Systems
(SIAM 2006), ch. 4. Assembly and factorisation together take a tenth of what a graph of Python-made factors takes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from topomap.geometry import FloatArray
from topomap.mapping.backend.problem import IntArray

BoolArray = NDArray[np.bool_]
SMALLEST_PIVOT = 1e-12  # of its diagonal element: below, the system is taken as undetermined


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """Which of N nodes share an edge, and how to eliminate them with little fill.

    order (N,): the nodes in order of elimination; slot, swapped (E,): for each edge its off-diagonal block and
    whether that block stands for (j, i); rows, columns: the upper triangle as compressed columns, scalar by scalar;
    source: where in the blocks each of its numbers lies; parent (3N,), starts (3N + 1,): elimination tree and columns
    of the factor.
    """

    order: IntArray
    blocks: int
    slot: IntArray
    swapped: BoolArray
    rows: IntArray
    columns: IntArray
    source: IntArray
    parent: IntArray
    starts: IntArray

    @staticmethod
    def of(nodes: int, i: IntArray, j: IntArray) -> Pattern:
        """Return the pattern of edges i, j (E,) among nodes."""
        order = _ordering(nodes, i, j)
        place = np.empty(nodes, np.int64)
        place[order] = np.arange(nodes)
        a, b = place[i], place[j]
        low, high = np.minimum(a, b), np.maximum(a, b)
        pairs, slot = np.unique(high * nodes + low, return_inverse=True)
        rows, columns, source = _scalars(nodes, pairs % nodes, pairs // nodes)
        parent, counts = _symbolic(rows, columns)
        starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        return Pattern(order, len(pairs), slot.reshape(-1), a > b, rows, columns, source, parent, starts)

    def factorise(self, diagonal: FloatArray, off: FloatArray) -> Factor | None:
        """Factorise blocks diagonal (N, 3, 3) by node and off (P, 3, 3) by slot; None if not positive definite."""
        values = np.concatenate([diagonal[self.order].reshape(-1), off.reshape(-1)])[self.source]
        rows, numbers, pivots, good = _numeric(self.rows, self.columns, values, self.parent, self.starts)
        return Factor(self, rows, numbers, pivots) if good else None


@dataclass(frozen=True, slots=True, eq=False)
class Factor:
    """L (unit lower, by columns) and D of a pattern's system."""

    pattern: Pattern
    rows: IntArray
    numbers: FloatArray
    pivots: FloatArray

    def solve(self, right: FloatArray) -> FloatArray:
        """Return (N, 3, r) the solutions for right sides (N, 3, r)."""
        order = self.pattern.order
        solved = right[order].reshape(3 * len(order), -1)
        _substitute(self.pattern.starts, self.rows, self.numbers, self.pivots, solved)
        result = np.empty_like(right)
        result[order] = solved.reshape(right.shape)
        return result


def _ordering(nodes: int, i: IntArray, j: IntArray) -> IntArray:
    """Return the nodes in an order of least degree (SuperLU's, of a matrix with ones for edges)."""
    every = np.arange(nodes)
    rows, columns = np.concatenate([i, j, every]), np.concatenate([j, i, every])
    degree = np.bincount(rows, minlength=nodes).astype(float) + 1.0
    weights = np.concatenate([np.full(2 * len(i), -1.0), degree])
    matrix = coo_matrix((weights, (rows, columns)), shape=(nodes, nodes)).tocsc()
    factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.asarray(np.argsort(factor.perm_c), np.int64)


def _scalars(nodes: int, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return rows, column starts and sources of the upper triangle; blocks (low, high) stand in order of high."""
    k, row, column = np.indices((len(low), 3, 3)).reshape(3, -1)
    d, above, right = np.indices((nodes, 3, 3)).reshape(3, -1)
    upper = above <= right
    rows = np.concatenate([3 * low[k] + row, (3 * d + above)[upper]])
    columns = np.concatenate([3 * high[k] + column, (3 * d + right)[upper]])
    source = np.concatenate([9 * nodes + np.arange(len(k)), np.flatnonzero(upper)])
    order = np.lexsort((rows, columns))
    starts = np.concatenate([[0], np.cumsum(np.bincount(columns, minlength=3 * nodes))])
    return rows[order].astype(np.int64), starts.astype(np.int64), source[order].astype(np.int64)


@njit(cache=True)
def _symbolic(rows: IntArray, columns: IntArray) -> tuple[IntArray, IntArray]:
    n = len(columns) - 1
    parent, counts, seen = np.full(n, -1), np.zeros(n, np.int64), np.full(n, -1)
    for k in range(n):
        seen[k] = k
        for p in range(columns[k], columns[k + 1]):
            i = rows[p]
            while i < k and seen[i] != k:
                if parent[i] < 0:
                    parent[i] = k
                counts[i] += 1
                seen[i] = k
                i = parent[i]
    return parent, counts


@njit(cache=True)
def _numeric(
    rows: IntArray, columns: IntArray, values: FloatArray, parent: IntArray, starts: IntArray
) -> tuple[IntArray, FloatArray, FloatArray, bool]:
    n = len(columns) - 1
    l_rows, l_numbers, pivots = np.zeros(starts[n], np.int64), np.zeros(starts[n]), np.zeros(n)
    filled, seen, stack, work = starts[:n].copy(), np.full(n, -1), np.zeros(n, np.int64), np.zeros(n)
    for k in range(n):
        top, diagonal = n, 0.0
        seen[k] = k
        for p in range(columns[k], columns[k + 1]):
            i = rows[p]
            if i == k:
                diagonal += values[p]
                continue
            work[i] += values[p]
            length = 0
            while seen[i] != k:
                stack[length] = i
                length += 1
                seen[i] = k
                i = parent[i]
            while length > 0:
                top -= 1
                length -= 1
                stack[top] = stack[length]
        pivot = diagonal
        for t in range(top, n):
            i = stack[t]
            y = work[i]
            work[i] = 0.0
            for p in range(starts[i], filled[i]):
                work[l_rows[p]] -= l_numbers[p] * y
            share = y / pivots[i]
            pivot -= share * y
            l_rows[filled[i]], l_numbers[filled[i]] = k, share
            filled[i] += 1
        if not pivot > SMALLEST_PIVOT * diagonal:
            return l_rows, l_numbers, pivots, False
        pivots[k] = pivot
    return l_rows, l_numbers, pivots, True


@njit(cache=True)
def _substitute(starts: IntArray, rows: IntArray, numbers: FloatArray, pivots: FloatArray, x: FloatArray) -> None:
    n, r = x.shape
    for k in range(n):
        for p in range(starts[k], starts[k + 1]):
            for c in range(r):
                x[rows[p], c] -= numbers[p] * x[k, c]
    for k in range(n - 1, -1, -1):
        for c in range(r):
            x[k, c] /= pivots[k]
        for p in range(starts[k], starts[k + 1]):
            for c in range(r):
                x[k, c] -= numbers[p] * x[rows[p], c]
