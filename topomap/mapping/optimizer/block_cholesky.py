"""Sparse Cholesky factors of 3 x 3 blocks, one a pose: what a pose graph in the plane is solved by.

A general sparse solver takes 10 to 30 times as long on such graphs (intel 11 ms by SuperLU, 0.4 ms here; w10000 163 and
16 ms): its columns are short and each step through them costs more than the arithmetic.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from numba import njit
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from topomap.core.arrays import FloatArray, IntArray


class BlockPattern:
    """Which blocks the factor of a graph of N poses has, and the order in which the poses are eliminated.

    place (N,): when each pose is eliminated; first (N + 1,) and rows (B,): the factor's blocks by column, the column's
    own first, then those below in order; at (E,): each edge's block below the diagonal.
    """

    def __init__(self, nodes: int, i: IntArray, j: IntArray) -> None:
        """Take E edges between poses i and j (E,), i not j."""
        ends = np.concatenate([i, j, np.arange(nodes)]), np.concatenate([j, i, np.arange(nodes)])
        net = csc_array(coo_array((np.ones(len(ends[0])), ends), (nodes, nodes)))
        self.place = _least_fill(net)
        upper = csc_array(coo_array((np.ones(len(ends[0])), tuple(self.place[end] for end in ends)), net.shape))
        upper.sort_indices()
        indptr, indices = upper.indptr.astype(np.int64), upper.indices.astype(np.int64)
        self.first, self.rows = _columns(indptr, indices)
        self.at: IntArray = self._blocks_of(i, j)

    def _blocks_of(self, i: IntArray, j: IntArray) -> IntArray:
        """Return where each edge's block stands (E,), -1 where there is none."""
        low, high = np.minimum(self.place[i], self.place[j]), np.maximum(self.place[i], self.place[j])
        return np.asarray(_found(self.first, self.rows, low, high))

    def joining(self, i: IntArray, j: IntArray) -> BlockPattern | None:
        """Return the pattern for other edges (E,) between the same poses; None if it hasn't blocks for all of them."""
        at = self._blocks_of(i, j)
        if (at < 0).any():
            return None
        other = copy(self)
        other.at = at
        return other

    def blocks(self) -> FloatArray:
        """Return empty blocks (B, 3, 3), to be filled with the lower half of a matrix."""
        return np.zeros((len(self.rows), 3, 3))

    def factor(self, blocks: FloatArray) -> bool:
        """Turn the lower half of a matrix (B, 3, 3) into its Cholesky factor; False if it isn't positive definite."""
        return bool(_factor(self.first, self.rows, blocks))

    def solve(self, factor: FloatArray, right: FloatArray) -> FloatArray:
        """Return the solution (N, 3) for a right side (N, 3), both by pose."""
        found = np.empty_like(right)
        found[self.place] = right
        _solve(self.first, self.rows, factor, found)
        return np.asarray(found[self.place])

    def inverse(self, factor: FloatArray) -> FloatArray:
        """Return those blocks (B, 3, 3) of the matrix's inverse that the factor has."""
        found = np.zeros_like(factor)
        _inverse(self.first, self.rows, factor, found)
        return found

    def log_determinant(self, factor: FloatArray) -> float:
        """Return the log of the matrix's determinant."""
        own = factor[self.first[:-1]]
        return 2.0 * float(np.log(np.diagonal(own, axis1=1, axis2=2)).sum())


def _least_fill(net: csc_array) -> IntArray:
    """Return when each node is eliminated (N,) by SuperLU's minimum degree, from one number a node."""
    firm = net.copy()
    firm.data[:] = -1.0
    firm.setdiag(np.diff(net.indptr) + 1.0)
    factor = splu(firm, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.asarray(factor.perm_c, np.int64)


@njit(cache=True)
def _columns(indptr: IntArray, indices: IntArray) -> tuple[IntArray, IntArray]:
    """Return first and rows of the factor's columns, from the matrix's (by the elimination tree, Liu 1990)."""
    n = len(indptr) - 1
    parent, flag, count = np.full(n, -1), np.full(n, -1), np.ones(n, np.int64)
    for k in range(n):
        flag[k] = k
        for i in indices[indptr[k] : indptr[k + 1]]:
            while i < k and flag[i] != k:
                if parent[i] == -1:
                    parent[i] = k
                count[i] += 1
                flag[i] = k
                i = parent[i]
    first = np.zeros(n + 1, np.int64)
    first[1:] = np.cumsum(count)
    rows, fill = np.empty(first[n], np.int64), first[:n].copy()
    flag[:] = -1
    for k in range(n):
        rows[first[k]] = k
        fill[k] += 1
        flag[k] = k
        for i in indices[indptr[k] : indptr[k + 1]]:
            while i < k and flag[i] != k:
                rows[fill[i]] = k
                fill[i] += 1
                flag[i] = k
                i = parent[i]
    return first, rows


@njit(cache=True)
def _found(first: IntArray, rows: IntArray, column: IntArray, row: IntArray) -> IntArray:
    found = np.empty(len(column), np.int64)
    for n in range(len(column)):
        begin = first[column[n]]
        found[n] = begin + np.searchsorted(rows[begin : first[column[n] + 1]], row[n])
        if found[n] == first[column[n] + 1] or rows[found[n]] != row[n]:
            found[n] = -1
    return found


@njit(cache=True)
def _factor(first: IntArray, rows: IntArray, blocks: FloatArray) -> bool:
    for k in range(len(first) - 1):
        begin, end = first[k], first[k + 1]
        if not _root(blocks[begin]):
            return False
        for p in range(begin + 1, end):
            _divided(blocks[p], blocks[begin])
        for p in range(begin + 1, end):
            q = first[rows[p]]
            for s in range(p, end):
                while rows[q] != rows[s]:
                    q += 1
                _subtract(blocks, q, s, p)
    return True


@njit(cache=True)
def _root(a: FloatArray) -> bool:
    """Turn a block (3, 3) into its Cholesky factor."""
    for c in range(3):
        for k in range(c):
            a[c, c] -= a[c, k] ** 2
        if not a[c, c] > 0.0:
            return False
        a[c, c] = np.sqrt(a[c, c])
        for r in range(c + 1, 3):
            for k in range(c):
                a[r, c] -= a[r, k] * a[c, k]
            a[r, c] /= a[c, c]
            a[c, r] = 0.0
    return True


@njit(cache=True)
def _divided(b: FloatArray, root: FloatArray) -> None:
    """Multiply a block by the inverse of root^T from the right."""
    for r in range(3):
        b[r, 0] /= root[0, 0]
        b[r, 1] = (b[r, 1] - b[r, 0] * root[1, 0]) / root[1, 1]
        b[r, 2] = (b[r, 2] - b[r, 0] * root[2, 0] - b[r, 1] * root[2, 1]) / root[2, 2]


@njit(cache=True, inline="always")
def _subtract(blocks: FloatArray, q: int, s: int, p: int) -> None:
    """Subtract block s times block p transposed from block q."""
    for r in range(3):
        x, y, z = blocks[s, r, 0], blocks[s, r, 1], blocks[s, r, 2]
        blocks[q, r, 0] -= x * blocks[p, 0, 0] + y * blocks[p, 0, 1] + z * blocks[p, 0, 2]
        blocks[q, r, 1] -= x * blocks[p, 1, 0] + y * blocks[p, 1, 1] + z * blocks[p, 1, 2]
        blocks[q, r, 2] -= x * blocks[p, 2, 0] + y * blocks[p, 2, 1] + z * blocks[p, 2, 2]


@njit(cache=True)
def _solve(first: IntArray, rows: IntArray, factor: FloatArray, x: FloatArray) -> None:
    n = len(first) - 1
    for k in range(n):
        own = factor[first[k]]
        for r in range(3):
            for c in range(r):
                x[k, r] -= own[r, c] * x[k, c]
            x[k, r] /= own[r, r]
        for p in range(first[k] + 1, first[k + 1]):
            for r in range(3):
                for c in range(3):
                    x[rows[p], r] -= factor[p, r, c] * x[k, c]
    for k in range(n - 1, -1, -1):
        own = factor[first[k]]
        for p in range(first[k] + 1, first[k + 1]):
            for r in range(3):
                for c in range(3):
                    x[k, c] -= factor[p, r, c] * x[rows[p], r]
        for r in range(2, -1, -1):
            for c in range(r + 1, 3):
                x[k, r] -= own[c, r] * x[k, c]
            x[k, r] /= own[r, r]


@njit(cache=True)
def _inverse(first: IntArray, rows: IntArray, factor: FloatArray, z: FloatArray) -> None:
    """Fill the inverse's blocks from the last column to the first (Takahashi et al. 1973)."""
    n = len(first) - 1
    longest = 0
    for k in range(n):
        longest = max(longest, first[k + 1] - first[k])
    work, root = np.zeros((longest, 3, 3)), np.zeros((3, 3))
    for k in range(n - 1, -1, -1):
        begin, end = first[k], first[k + 1]
        work[: end - begin] = 0.0
        for p in range(begin + 1, end):
            q = first[rows[p]]
            for s in range(p, end):
                while rows[q] != rows[s]:
                    q += 1
                _add_product(work[s - begin], z[q], factor[p], False)
                if s > p:
                    _add_product(work[p - begin], z[q], factor[s], True)
        _inverted(factor[begin], root)
        own = z[begin]
        own[:] = root
        for p in range(begin + 1, end):
            _add_product(z[p], -work[p - begin], root, False)
            _add_product(own, -factor[p], z[p], True)
        work[0] = 0.0
        _add_product(work[0], root, own, True)
        own[:] = work[0]


@njit(cache=True)
def _add_product(out: FloatArray, a: FloatArray, b: FloatArray, turned: bool) -> None:
    """Add a b, or a^T b, to out."""
    for r in range(3):
        for c in range(3):
            for k in range(3):
                out[r, c] += (a[k, r] if turned else a[r, k]) * b[k, c]


@njit(cache=True)
def _inverted(root: FloatArray, out: FloatArray) -> None:
    """Write the inverse of a lower triangular block."""
    out[:] = 0.0
    for c in range(3):
        out[c, c] = 1.0 / root[c, c]
        for r in range(c + 1, 3):
            total = 0.0
            for k in range(c, r):
                total += root[r, k] * out[k, c]
            out[r, c] = -total / root[r, r]
