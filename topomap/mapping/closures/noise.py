"""How large a pose graph's noise really is: the files state covariances up to a factor."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.special import chdtri, fdtri

from topomap.core.arrays import FloatArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import loops_of
from topomap.mapping.closures.odds import TAILS, log_chance, mahalanobis
from topomap.mapping.closures.prevalence import GATE
from topomap.mapping.uncertainty.network import PathNetwork
from topomap.mapping.uncertainty.odometry_chain import Chain

LONGEST = 64.0  # a claim's own loop with odometry is at most so long [m]: longer ones rest on odometry's drift
ASKED = 4000  # claims whose loops are heard: enough for a variance to 3 %
STARTS = (1.0, 1e-1, 1e-2, 1e-3, 1e-4)
FIRST, ROUNDS = 10, 30  # rounds from every start, and from the best of them on
FEWEST = 30
# degrees of freedom of true loops: real ones have heavy tails, which are found from further off, or lighter ones
HEAVY, LIGHTER = TAILS, (8.0, 16.0, 64.0)
STILL = 1e-4  # change of both scales in a round with which a fit has ended
# of the true loops, up to the limit of a claim that fits; more than their mean square where tails are heavy
SHARE = 0.99
WIDER = 30.0  # times the scale of true loops is that of false ones between near places at least
LOGGED = 256  # factors of a likelihood whose logarithm is taken at once
WORST = 1e6  # a loop further off [squared Mahalanobis distance] is false whatever the factor


def variance_factor(claims: Claims, chain: Chain) -> float:
    """Return the factor, at most 1, by which the stated covariances are too large (the variance of unit weight).

    Short loops, through two neighbouring claims and odometry or through one and odometry, miss of closing by the noise
    if they are true and by anything if one is false: a mixture of the two is fitted (expectation and maximisation) from
    several starts. Claims that odometry refuses as it is stated are false whatever the factor, and aren't heard. With
    fewer than 30 true loops the statement stands: 1. The claims stand in order of i, then of j.
    """
    odometry = PathNetwork.of_chain(chain)
    claims = claims[mahalanobis(claims, chain.poses, odometry.errors(claims.i, claims.j))[0] <= GATE]
    asked = np.unique(np.linspace(0, len(claims) - 1, min(ASKED, len(claims))).astype(np.int64))
    a, _, between = loops_of(claims, chain, asked, WORST)
    short = claims[asked[chain.path(claims.i[asked], claims.j[asked]) <= LONGEST]]
    own, determinant = mahalanobis(short, chain.poses, odometry.errors(short.i, short.j))
    chi2 = np.concatenate([between, own])
    if len(chi2) < FEWEST:
        return 1.0
    peaks = np.concatenate([np.log(8 * np.linalg.det(claims.covariance[a])), np.log(determinant)])
    chance = float(log_chance(chain.poses, np.zeros(1, bool))[0])
    fit = _mixture(chi2, -0.5 * peaks - 1.5 * np.log(2 * np.pi) - chance)
    return 1.0 if fit is None else min(1.0, fit.factor())


class _Fit(NamedTuple):
    """A mixture: its log likelihood, the scales of true and of false loops between near places, the shares (3,) of
    true, near and any loops, the number of true ones, and their degrees of freedom.
    """

    likelihood: float
    scale: float
    wide: float
    shares: FloatArray
    true: float
    tails: float

    def factor(self) -> float:
        """Return what the covariances have to be multiplied by for the largest of the true loops to be usual."""
        share = min(SHARE, 1.0 - 0.5 / max(self.true, 1.0))  # of a few loops the last isn't the 99th in 100
        return self.scale * 3 * float(fdtri(3, self.tails, share)) / float(chdtri(3, 1 - share))


def _mixture(chi2: FloatArray, peak: FloatArray) -> _Fit | None:
    """Return the likeliest mixture with enough true loops; chi2, peak (n,): log density at 0 over an even one.

    True loops have tails as heavy as it takes (Student's t). A false loop misses by anything, or, as claims speak of
    near places or come in groups, by some metres: a normal with a wider scale of its own.
    """
    even = np.array([0.4, 0.2, 0.4])
    fits = [_Fit(*_fitted(chi2, peak, start, 1e3 * start, even, HEAVY, FIRST)) for start in STARTS]
    # a fit to one loop alone may be likelier than any to all of them
    best = max((fit for fit in fits if fit.true >= FEWEST), key=lambda fit: fit.likelihood, default=None)
    if best is None:
        return None
    heavy = _Fit(*_fitted(chi2, peak, best.scale, best.wide, best.shares, HEAVY, ROUNDS))
    ended = [_Fit(*_fitted(chi2, peak, heavy.scale, heavy.wide, heavy.shares, tails, ROUNDS)) for tails in LIGHTER]
    return max([heavy, *ended], key=lambda fit: fit.likelihood)


@njit(cache=True)
def _fitted(
    chi2: FloatArray, peak: FloatArray, scale: float, wide: float, shares: FloatArray, tails: float, rounds: int
) -> tuple[float, float, float, FloatArray, float, float]:
    """Fit by expectation and maximisation; see `_Fit`."""
    constant = math.lgamma((tails + 3) / 2) - math.lgamma(tails / 2) - 1.5 * math.log(tails / 2)
    likelihood, sums = 0.0, np.zeros(3)
    for _ in range(rounds):
        own, near = constant - 1.5 * math.log(scale), -1.5 * math.log(wide)
        log = np.log(shares)
        likelihood, pulled, pulled_near, product = 0.0, 0.0, 0.0, 1.0
        sums[:] = 0.0
        for n in range(len(chi2)):
            a = log[0] + peak[n] + own - (tails + 3) / 2 * math.log1p(chi2[n] / (tails * scale))
            b = log[1] + peak[n] + near - chi2[n] / (2 * wide)
            most = max(a, b, log[2])
            ea = 1.0 if a == most else math.exp(a - most)
            eb = 1.0 if b == most else math.exp(b - most)
            ec = 1.0 if log[2] == most else math.exp(log[2] - most)
            each = ea + eb + ec
            likelihood += most
            product *= each  # at most 3, of which so many are a number still
            if n % LOGGED == 0:
                likelihood += math.log(product)
                product = 1.0
            sums[0] += ea / each
            sums[1] += eb / each
            sums[2] += ec / each
            pulled += ea / each * (tails + 3) / (tails + chi2[n] / scale) * chi2[n]
            pulled_near += eb / each * chi2[n]
        likelihood += math.log(product)
        before, before_wide = scale, wide
        shares = np.minimum(np.maximum(sums / len(chi2), 1e-6), 1 - 1e-6)
        scale = max(pulled / max(3 * sums[0], 1e-12), 1e-12)
        wide = max(pulled_near / max(3 * sums[1], 1e-12), WIDER * scale)
        if abs(scale / before - 1) < STILL and abs(wide / before_wide - 1) < STILL:
            break
    return likelihood, scale, wide, shares, float(sums[0]), tails
