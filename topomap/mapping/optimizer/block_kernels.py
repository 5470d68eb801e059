"""The arithmetic of sparse Cholesky factors of 3 x 3 blocks, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray


@njit(cache=True)
def columns(indptr: IntArray, indices: IntArray) -> tuple[IntArray, IntArray]:
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
def found_blocks(first: IntArray, rows: IntArray, column: IntArray, row: IntArray) -> IntArray:
    found = np.empty(len(column), np.int64)
    for n in range(len(column)):
        begin = first[column[n]]
        found[n] = begin + np.searchsorted(rows[begin : first[column[n] + 1]], row[n])
        if found[n] == first[column[n] + 1] or rows[found[n]] != row[n]:
            found[n] = -1
    return found


@njit(cache=True)
def factor(first: IntArray, rows: IntArray, blocks: FloatArray) -> bool:
    for k in range(len(first) - 1):
        begin, end = first[k], first[k + 1]
        if not _root(blocks[begin]):
            return False
        for p in range(begin + 1, end):
            _divided(blocks[p], blocks[begin])
        for p in range(begin + 1, end):
            q, own = first[rows[p]], _values(blocks, p)
            for s in range(p, end):
                while rows[q] != rows[s]:
                    q += 1
                _subtract(blocks, q, s, own)
    return True


Block = tuple[float, float, float, float, float, float, float, float, float]


@njit(cache=True, inline="always")
def _values(blocks: FloatArray, p: int) -> Block:
    """Return the nine values of a block, row by row, to be held in registers."""
    a, b, c = blocks[p, 0], blocks[p, 1], blocks[p, 2]
    return a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]


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
def _subtract(blocks: FloatArray, q: int, s: int, p: Block) -> None:
    """Subtract block s times another one transposed, by its values, from block q."""
    for r in range(3):
        x, y, z = blocks[s, r, 0], blocks[s, r, 1], blocks[s, r, 2]
        blocks[q, r, 0] -= x * p[0] + y * p[1] + z * p[2]
        blocks[q, r, 1] -= x * p[3] + y * p[4] + z * p[5]
        blocks[q, r, 2] -= x * p[6] + y * p[7] + z * p[8]


@njit(cache=True)
def solve(first: IntArray, rows: IntArray, factor: FloatArray, x: FloatArray) -> None:
    n = len(first) - 1
    for k in range(n):
        own = first[k]
        a = x[k, 0] / factor[own, 0, 0]
        b = (x[k, 1] - factor[own, 1, 0] * a) / factor[own, 1, 1]
        c = (x[k, 2] - factor[own, 2, 0] * a - factor[own, 2, 1] * b) / factor[own, 2, 2]
        x[k, 0], x[k, 1], x[k, 2] = a, b, c
        for p in range(own + 1, first[k + 1]):
            row = rows[p]
            for r in range(3):
                x[row, r] = x[row, r] - factor[p, r, 0] * a - factor[p, r, 1] * b - factor[p, r, 2] * c
    for k in range(n - 1, -1, -1):
        own = first[k]
        a, b, c = x[k, 0], x[k, 1], x[k, 2]
        for p in range(own + 1, first[k + 1]):
            for r in range(3):
                below = x[rows[p], r]
                a -= factor[p, r, 0] * below
                b -= factor[p, r, 1] * below
                c -= factor[p, r, 2] * below
        c /= factor[own, 2, 2]
        b = (b - factor[own, 2, 1] * c) / factor[own, 1, 1]
        a = (a - factor[own, 1, 0] * b - factor[own, 2, 0] * c) / factor[own, 0, 0]
        x[k, 0], x[k, 1], x[k, 2] = a, b, c


@njit(cache=True)
def inverse(first: IntArray, rows: IntArray, factor: FloatArray, z: FloatArray) -> None:
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
                _add_across(work, s - begin, z, q, factor, p)
                if s > p:
                    _add_turned(work, p - begin, z, q, factor, s)
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
def _add_across(out: FloatArray, o: int, a: FloatArray, p: int, b: FloatArray, q: int) -> None:
    """Add block p of a times block q of b to block o of out."""
    for r in range(3):
        x, y, z = a[p, r, 0], a[p, r, 1], a[p, r, 2]
        for c in range(3):
            out[o, r, c] = out[o, r, c] + x * b[q, 0, c] + y * b[q, 1, c] + z * b[q, 2, c]


@njit(cache=True)
def _add_turned(out: FloatArray, o: int, a: FloatArray, p: int, b: FloatArray, q: int) -> None:
    """Add block p of a transposed times block q of b to block o of out."""
    for r in range(3):
        x, y, z = a[p, 0, r], a[p, 1, r], a[p, 2, r]
        for c in range(3):
            out[o, r, c] = out[o, r, c] + x * b[q, 0, c] + y * b[q, 1, c] + z * b[q, 2, c]


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
