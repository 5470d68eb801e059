"""How much likelier a closure is if true than if it joins any two places of the map."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.optimizer import Closures

PAIRS = 2000
SPREAD = np.array([0.7548776662466927, 0.5698402909980532])  # evenly over a square whatever the number (Roberts' R2)
FALSE_DISTANCE, FALSE_ROTATION = 1.0, np.radians(20.0)  # what a false closure misses by, one of them at least [m, rad]
NEAREST = 10  # nodes between the two of a pair at least


def log_odds(chi2: FloatArray, spread: FloatArray, volume: float) -> FloatArray:
    """Return (n,) logs of the claim's density by the map over an even one.

    chi2 (n,): squared error by spread (n, 3, 3), the covariance of claim and map; volume [m^2 rad]: of all claims.
    """
    peak = np.log(volume) - 1.5 * np.log(2 * np.pi) - 0.5 * np.linalg.slogdet(spread)[1]
    return np.asarray(peak - chi2 / 2)


def crowding(poses: FloatArray, closures: Closures, spread: FloatArray, volume: float) -> FloatArray:
    """Return (n,) how many times likelier than evenly spread two of poses (N, 3) that aren't the claimed place stand as
    closures (n,) claim.

    Where places lie on a lattice, or near one another, a false claim fits more often than its share of the volume. Two
    that stand within 0.5 m and 10 degrees of the claim make it true.
    """
    drawn = (np.outer(np.arange(1, PAIRS + 1), SPREAD) % 1.0 * len(poses)).astype(np.int64)
    low, high = drawn.min(axis=1), drawn.max(axis=1)
    apart = high - low >= NEAREST
    stand = between(poses[low[apart]], poses[high[apart]])
    rows = zip(closures.relative, spread, strict=True)
    density = [_density(stand, claim, around, volume) for claim, around in rows] if len(stand) else []
    return np.maximum(1.0, np.array(density)) if density else np.ones(len(closures))


def _density(stand: FloatArray, claim: FloatArray, spread: FloatArray, volume: float) -> float:
    gap, count = stand - claim, len(stand)
    gap[:, 2] = wrap_all(gap[:, 2])
    gap = gap[(np.hypot(gap[:, 0], gap[:, 1]) > FALSE_DISTANCE / 2) | (np.abs(gap[:, 2]) > FALSE_ROTATION / 2)]
    chi2 = (gap * np.linalg.solve(spread, gap.T).T).sum(axis=1)
    return float(np.exp(log_odds(chi2, spread[None], volume)).sum() / count)
