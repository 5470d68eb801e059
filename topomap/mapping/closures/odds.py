"""How much likelier a claim is if true than if it joins any two places of the map."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.special import gammaln

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.evidence import FALSE_DISTANCE, FALSE_ROTATION
from topomap.core.geometry import between
from topomap.mapping.closures.claims import Claims
from topomap.mapping.uncertainty.small import distance2, relative, seen_from, wrapped

PAIRS = 2000  # of places, drawn evenly, whose relative poses show how places are crowded
SPREAD = np.array([0.7548776662466927, 0.5698402909980532])  # evenly over a square whatever the number (Roberts' R2)
NEAREST = 10  # places between the two of a pair at least
FURTHEST = 50.0  # squared Mahalanobis distance beyond which a pair counts for nothing
TAILS = 4.0  # degrees of freedom of the density of true claims: real closures miss by 5 sigmas one time in 300


def mahalanobis(claims: Claims, poses: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (n,) squared distances of claims from a map with poses (N, 3), and the determinants of their covariances.

    errors (n, 3, 3): of the map between the claims' places, about the origin.
    """
    args = (claims.i, claims.j, claims.relative, claims.covariance, claims.blind, np.ascontiguousarray(poses), errors)
    found = _mahalanobis(*args)
    return np.asarray(found[0]), np.asarray(found[1])


def relative_covariances(claims: Claims, poses: FloatArray, errors: FloatArray) -> FloatArray:
    """Return covariances (n, 3, 3) of `i_from_j` by a map with poses (N, 3); errors (n, 3, 3) as above."""
    found = np.empty((len(claims), 3, 3))
    for n, (i, j) in enumerate(zip(claims.i.tolist(), claims.j.tolist(), strict=True)):
        seen_from(errors[n], poses[i, 2], poses[j, 0], poses[j, 1], found[n])
    return found


@njit(cache=True)
def _mahalanobis(
    i: FloatArray, j: FloatArray, claimed: FloatArray, covariance: FloatArray, blind: BoolArray, poses: FloatArray,
    errors: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    chi2, determinant = np.empty(len(i)), np.empty(len(i))
    spread = np.empty((3, 3))
    for n in range(len(i)):
        seen_from(errors[n], poses[i[n], 2], poses[j[n], 0], poses[j[n], 1], spread)
        spread += covariance[n]
        x, y, heading = relative(poses[i[n]], poses[j[n]])
        x, y, heading = x - claimed[n, 0], y - claimed[n, 1], wrapped(heading - claimed[n, 2])
        chi2[n], determinant[n] = distance2(spread, x, y, heading, blind[n])
    return chi2, determinant


def log_density(chi2: FloatArray, determinant: FloatArray, blind: BoolArray) -> FloatArray:
    """Return (n,) log densities of true claims [1 / (m^2 rad), blind ones 1 / m^2]: Student's t with heavy tails."""
    d = np.where(blind, 2.0, 3.0)
    peak = gammaln((TAILS + d) / 2) - gammaln(TAILS / 2) - d / 2 * np.log(TAILS * np.pi) - 0.5 * np.log(determinant)
    return np.asarray(peak - (TAILS + d) / 2 * np.log1p(chi2 / TAILS))


def log_chance(poses: FloatArray, blind: BoolArray) -> FloatArray:
    """Return (n,) log densities of false claims if they are even over the drive's area and all headings."""
    width, height = np.maximum(np.ptp(poses[:, :2], axis=0), 1.0)
    return np.asarray(-np.log(width * height * np.where(blind, 1.0, 2 * np.pi)))


def log_crowding(claims: Claims, poses: FloatArray, errors: FloatArray) -> FloatArray:
    """Return (n,) logs of how many times likelier than even a false claim is to fit here, at least 0.

    Where places lie on a lattice, or near one another, a false claim fits more often than its share of the area: pairs
    of poses (N, 3) that stand as the claim says, but aren't the claimed place, tell how often. Those within 0.5 m and
    10 degrees of it would make it true.
    """
    drawn = (np.outer(np.arange(1, PAIRS + 1), SPREAD) % 1.0 * len(poses)).astype(np.int64)
    low, high = drawn.min(axis=1), drawn.max(axis=1)
    apart = high - low >= NEAREST
    if not apart.any() or not len(claims):
        return np.zeros(len(claims))
    stand = between(poses[low[apart]], poses[high[apart]])
    stand = stand[np.argsort(stand[:, 0], kind="stable")]  # those near a claim then lie side by side
    args = (claims.i, claims.j, claims.relative, claims.covariance, claims.blind)
    density = _density(*args, np.ascontiguousarray(poses), errors, stand)
    even = log_chance(poses, claims.blind)
    return np.asarray(np.maximum(0.0, np.log(np.maximum(density, 1e-300)) - even))


@njit(cache=True)
def _density(
    i: FloatArray, j: FloatArray, claimed: FloatArray, covariance: FloatArray, blind: BoolArray, poses: FloatArray,
    errors: FloatArray, stand: FloatArray,
) -> FloatArray:  # fmt: skip
    total = np.zeros(len(i))
    spread, ahead = np.empty((3, 3)), stand[:, 0].copy()
    for n in range(len(i)):
        seen_from(errors[n], poses[i[n], 2], poses[j[n], 0], poses[j[n], 1], spread)
        spread += covariance[n]
        determinant = distance2(spread, 0.0, 0.0, 0.0, blind[n])[1]
        reach = FURTHEST * (spread[0, 0] + spread[1, 1])
        for k in range(np.searchsorted(ahead, claimed[n, 0] - math.sqrt(reach)), len(stand)):
            x, y = stand[k, 0] - claimed[n, 0], stand[k, 1] - claimed[n, 1]
            if x * x + y * y > reach:
                if x > 0.0 and x * x > reach:
                    break
                continue
            heading = wrapped(stand[k, 2] - claimed[n, 2])
            near = math.hypot(x, y) <= FALSE_DISTANCE / 2
            if near and (blind[n] or abs(heading) <= FALSE_ROTATION / 2):
                continue
            chi2 = distance2(spread, x, y, heading, blind[n])[0]
            if chi2 < FURTHEST:
                total[n] += math.exp(-chi2 / 2)
        norm = 2 * math.pi if blind[n] else (2 * math.pi) ** 1.5
        total[n] /= len(stand) * norm * math.sqrt(determinant)
    return total
