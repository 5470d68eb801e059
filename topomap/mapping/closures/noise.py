"""How large a pose graph's noise really is: the files state covariances up to a factor."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri, gammaln

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import loops_of
from topomap.mapping.closures.odds import TAILS, log_chance, mahalanobis
from topomap.mapping.uncertainty.network import PathNetwork
from topomap.mapping.uncertainty.odometry_chain import Chain

LONGEST = 64.0  # a claim's own loop with odometry is at most so long [m]: longer ones rest on odometry's drift
ASKED = 4000  # claims whose loops are heard: enough for a variance to 3 %
STARTS = (1.0, 1e-1, 1e-2, 1e-3, 1e-4)
ROUNDS, FEWEST = 30, 30
STILL = 1e-4  # change of both scales in a round with which a fit has ended
# of the true loops, up to the limit of a claim that fits; more than their mean square where tails are heavy
SHARE = 0.99
WIDER = 30.0  # times the scale of true loops is that of false ones between near places at least
WORST = 1e6  # a loop further off [squared Mahalanobis distance] is false whatever the factor


def variance_factor(claims: Claims, chain: Chain) -> float:
    """Return the factor, at most 1, by which the stated covariances are too large (the variance of unit weight).

    Short loops, through two neighbouring claims and odometry or through one and odometry, miss of closing by the noise
    if they are true and by anything if one is false: a mixture of the two is fitted (expectation and maximisation) from
    several starts. With fewer than 30 true loops the statement stands: 1. The claims stand in order of i, then of j.
    """
    asked = np.unique(np.linspace(0, len(claims) - 1, min(ASKED, len(claims))).astype(np.int64))
    a, _, between = loops_of(claims, chain, asked, WORST)
    short = asked[chain.path(claims.i[asked], claims.j[asked]) <= LONGEST]
    own, determinant = mahalanobis(
        claims[short], chain.poses, PathNetwork.of_chain(chain).errors(*_ends(claims, short))
    )
    chi2 = np.concatenate([between, own])
    if len(chi2) < FEWEST:
        return 1.0
    peaks = np.concatenate([np.log(8 * np.linalg.det(claims.covariance[a])), np.log(determinant)])
    chance = float(log_chance(chain.poses, np.zeros(1, bool))[0])
    fits = [_mixture(chi2, -0.5 * peaks - 1.5 * np.log(2 * np.pi) - chance, start) for start in STARTS]
    # a fit to one loop alone may be likelier than any to all of them
    _, factor, _ = max((fit for fit in fits if fit[2] >= FEWEST), default=(0.0, 1.0, 0.0))
    return min(1.0, factor)


def _ends(claims: Claims, which: IntArray) -> tuple[IntArray, IntArray]:
    return claims.i[which], claims.j[which]


def _mixture(chi2: FloatArray, peak: FloatArray, scale: float) -> tuple[float, float, float]:
    """Return log likelihood, factor and number of true loops; chi2, peak (n,): log density at 0 over an even one.

    True loops have heavy tails (Student's t). A false loop misses by anything, or, as claims speak of near places or
    come in groups, by some metres: a normal with a wider scale of its own.
    """
    order, likelihood = np.argsort(chi2), -np.inf
    shares, wide = np.array([0.4, 0.2, 0.4]), 1e3 * scale
    weights = np.zeros((3, len(chi2)))
    for _ in range(ROUNDS):
        logs = np.stack([_log_t(chi2, peak, scale), peak - 1.5 * np.log(wide) - chi2 / (2 * wide), np.zeros(len(chi2))])
        logs += np.log(shares)[:, None]
        each = np.logaddexp.reduce(logs, axis=0)
        before, likelihood = (scale, wide), float(each.sum())
        weights = np.exp(logs - each)
        shares = np.clip(weights.mean(axis=1), 1e-6, 1 - 1e-6)
        pull = weights[0] * (TAILS + 3) / (TAILS + chi2 / scale)
        scale = max(float(pull @ chi2) / max(3 * float(weights[0].sum()), 1e-12), 1e-12)
        wide = max(float(weights[1] @ chi2) / max(3 * float(weights[1].sum()), 1e-12), WIDER * scale)
        if abs(scale / before[0] - 1) < STILL and abs(wide / before[1] - 1) < STILL:
            break
    total = np.cumsum(weights[0][order])
    share = min(SHARE, 1.0 - 0.5 / max(float(total[-1]), 1.0))  # of a few loops the last one isn't the 99th in 100
    last = min(int(np.searchsorted(total, share * total[-1])), len(order) - 1)
    return likelihood, float(chi2[order][last]) / float(chdtri(3, 1 - share)), float(total[-1])


def _log_t(chi2: FloatArray, peak: FloatArray, scale: float) -> FloatArray:
    """Return (n,) log densities of Student's t over an even one; peak: the normal's at 0."""
    tails = gammaln((TAILS + 3) / 2) - gammaln(TAILS / 2) - 1.5 * np.log(TAILS / 2)
    return np.asarray(peak + tails - 1.5 * np.log(scale) - (TAILS + 3) / 2 * np.log1p(chi2 / (TAILS * scale)))
