"""How probable it is that false loops fit the finished map, as any two of its places may lie near one another."""

from __future__ import annotations

import numpy as np
from scipy.special import bdtrc

from topomap.core.arrays import FloatArray
from topomap.mapping.closures.odds import SPREAD

PAIRS = 20_000


def probability(stood: int, heard: int, poses: FloatArray, travelled: FloatArray, near: float, apart: float) -> float:
    """Return the probability that of `heard` loops between any two places `stood` or more stand.

    poses (S, 3) with the way to each, travelled (S,) [m]; a loop stands that joins places nearer than `near` [m];
    places have at least `apart` [m] of way between them.
    """
    if stood == 0:
        return 1.0
    drawn = np.arange(1, PAIRS + 1)[:, None] * SPREAD % 1.0 * travelled[-1]
    a, b = np.searchsorted(travelled, drawn).T
    told = np.abs(travelled[a] - travelled[b]) >= apart
    gap = np.hypot(*(poses[a, :2] - poses[b, :2])[told].T)
    share = max(float((gap <= near).sum()), 1.0) / max(len(gap), 1)
    return float(bdtrc(stood - 1, heard, share))
