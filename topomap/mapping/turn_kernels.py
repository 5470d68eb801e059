"""The hot loops of fitting lines through measured turns: numpy's own numbers, in one pass each."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray


@njit(cache=True)
def middle_size(values: FloatArray) -> float:
    """Return the median of the sizes of values (n,), of which none is NaN."""
    return float(np.median(np.abs(values)))


@njit(cache=True)
def reweighted(
    left: FloatArray, values: FloatArray, design: FloatArray, scatter: float
) -> tuple[FloatArray, FloatArray]:
    """Return the rows of a design (n, m), and values (n,), times Cauchy's squared weights of what is left (n,)."""
    count, terms = design.shape
    weighed, told = np.empty((count, terms)), np.empty(count)
    wide = 2.0 * scatter
    for k in range(count):
        weight = left[k] / wide
        weight = 1.0 + weight * weight
        weight = 1.0 / (weight * weight)
        told[k] = weight * values[k]
        for term in range(terms):
            weighed[k, term] = design[k, term] * weight
    return weighed, told
