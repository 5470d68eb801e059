"""How often claims are true, told by those that odometry refuses: these are false, and others are like them."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.uncertainty.network import PathNetwork

GATE = 30.0  # squared Mahalanobis distance of a claim that odometry alone can't explain: 1 true one in 700,000
SIZES = np.array([2, 3, 5, 8, 13, 21])  # sizes at which clusters begin to be of another kind: alone, a pair, some, many
SAMPLE = 20_000  # claims with ends of others, drawn once and the same way each time
# claims of a kind, true and false, before any is seen: where odometry refuses none, there is no sign of false ones
BEFORE = (1.0, 0.1)
MOST = 0.95  # of the false ones that odometry allows at most; nearer to 1 those refused tell nothing of the others


def allowed_by_chance(claims: Claims, poses: FloatArray, odometry: PathNetwork) -> float:
    """Return the share of false claims that odometry allows: of claims with the ends of others."""
    if len(claims) < 2:
        return 0.0
    rng = np.random.default_rng(0)
    ends = rng.choice(len(claims), min(len(claims), SAMPLE), replace=False)
    told = rng.permutation(ends)
    mixed = Claims.of(claims.i[ends], claims.j[ends], claims.relative[told], claims.covariance[told])
    chi2, _ = mahalanobis(mixed, poses, odometry.errors(mixed.i, mixed.j))
    return float(min((chi2 <= GATE).mean(), MOST))


def log_prevalence(size: IntArray, allowed: BoolArray, by_chance: float) -> FloatArray:
    """Return (K,) logs of how many clusters like each are true for one that is false.

    size (K,): claims in a cluster; allowed (K,): whether odometry allows it; by_chance: the share of false ones that it
    allows. Of each kind of cluster those refused are counted; so many more false ones are among those allowed. Groups
    of false claims that agree with one another, as look-alike corridors make them, so lose what agreement is worth.
    """
    kind = np.digitize(size, SIZES)
    kept = np.bincount(kind[allowed], minlength=len(SIZES) + 1)
    refused = np.bincount(kind[~allowed], minlength=len(SIZES) + 1)
    false = refused / (1.0 - by_chance)
    true = np.maximum(kept - by_chance * false, 0.0)
    return np.asarray(np.log((true + BEFORE[0]) / (false + BEFORE[1]))[kind])
