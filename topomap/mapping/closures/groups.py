"""Closures that the map can't tell alone, believed together: groups whose members make one another credible."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.optimizer import Closures
from topomap.mapping.uncertainty.agreement import loops_between
from topomap.mapping.uncertainty.paths import Paths

NEARBY = 100  # nodes to either side at which the ends of a false closure may lie: odometry knows their places well
BEST = 0.5  # share of the clearest group's log odds with which others are believed along with it
FURTHEST = 25.0  # chi-squared beyond which a density is none


class Bar(NamedTuple):
    """What a group must pass: log odds in all, those with which a member is joined to another, and the chi-squared
    within which their loop closes.
    """

    whole: float
    joined: float
    loop: float


def credible_groups(
    closures: Closures, odds: FloatArray, poses: FloatArray, paths: Paths, known: float, bar: Bar
) -> BoolArray:
    """Return which of some closures (n,) are credible together.

    odds (n,): logs of each by the map alone; poses (N, 3) and paths: the map's; known [rad]: how well the headings of
    two closures' ends must be known from one another. A group's log odds are those of the loops of a spanning tree and
    the map's for one of its members. The clearest comes first: others may contradict it.
    """
    size = len(closures)
    a, b, told = log_odds_of_pairs(closures, poses, paths, known, bar)
    net = coo_array((told, (a, b)), (size, size)).tocsr()
    _, group = connected_components(net, directed=False)
    tree = minimum_spanning_tree(-net).tocoo()
    total = np.full(size, -np.inf)
    np.maximum.at(total, group, odds)
    total += np.bincount(group[tree.row], -tree.data, size)
    total[np.bincount(group, minlength=size) < 2] = -np.inf
    good = (total >= bar.whole) & (total >= BEST * total.max(initial=0.0))
    return np.asarray(good[group])


def log_odds_of_pairs(
    c: Closures, poses: FloatArray, paths: Paths, known: float, bar: Bar
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return those pairs a, b (P,) that the bar joins, and logs (P,) of how much likelier b claims what it does if both
    are true than if b's ends are any nodes nearby, over the number of closures as near that might have agreed with a.
    """
    a, b, rank, known_i, known_j = paths.near(c.i, c.j, known)
    gap, spread = loops_between(c.relative, c.covariance, (c.i, c.j), poses, a, b, known_i, known_j)
    inverse = np.linalg.inv(spread)
    chi2 = (gap * (inverse @ gap[:, :, None])[:, :, 0]).sum(axis=1)
    ends = np.column_stack([c.i[a], c.j[a], c.i[b], c.j[b]])
    few = np.where(chi2 <= bar.loop, np.exp(-chi2 / 2 - bar.joined) / rank, 0.0)
    share = _share(poses, ends, c.relative[a], c.relative[b], inverse, np.sqrt(FURTHEST * spread[:, 0, 0]), few)
    joined = share < few
    told = bar.joined + np.log(few[joined] / share[joined])
    return a[joined], b[joined], told


@njit(cache=True)
def _share(
    poses: FloatArray,
    ends: IntArray,
    told: FloatArray,
    claim: FloatArray,
    inverse: FloatArray,
    reach: FloatArray,
    few: FloatArray,
) -> FloatArray:
    """Return (P,) what of its peak density b's claim reaches on average if its ends are any nodes near b's.

    ends (P, 4): i and j of a, i and j of b; told, claim (P, 3): what a and b claim; inverse (P, 3, 3): of the gap's
    covariance; reach (P,): how far along x it goes [m]; few (P,): a share beyond which no more needs to be known.
    """
    share = np.ones(len(ends))
    for n in range(len(ends)):
        low, high = max(0, ends[n, 2] - NEARBY), min(len(poses), ends[n, 2] + NEARBY + 1)
        first, last = max(0, ends[n, 3] - NEARBY), min(len(poses), ends[n, 3] + NEARBY + 1)
        count = (high - low) * (last - first)
        if few[n] * count < np.exp(-FURTHEST / 2):  # its own place alone is too much
            continue
        claimed, stand = np.empty((high - low, 3)), np.empty((last - first, 3))
        for k in range(high - low):  # where b, with another i, would have j, seen from a's i
            claimed[k] = _composed(_between(poses[ends[n, 0]], poses[low + k]), claim[n])
        for k in range(last - first):  # where a has the other j
            stand[k] = _composed(told[n], _between(poses[ends[n, 1]], poses[first + k]))
        stand = stand[np.argsort(stand[:, 0])]
        share[n] = _density(claimed, stand, inverse[n], reach[n], few[n] * count) / count
    return share


@njit(cache=True)
def _density(claimed: FloatArray, stand: FloatArray, q: FloatArray, reach: float, enough: float) -> float:
    """Return the summed share of the peak density over all pairs of claimed (n, 3) and true poses (m, 3), the latter in
    order of x, up to so much as is enough.
    """
    total = 0.0
    for k in range(len(claimed)):
        for m in range(np.searchsorted(stand[:, 0], claimed[k, 0] - reach), len(stand)):
            if stand[m, 0] > claimed[k, 0] + reach:
                break
            x, y = claimed[k, 0] - stand[m, 0], claimed[k, 1] - stand[m, 1]
            h = (claimed[k, 2] - stand[m, 2] + np.pi) % (2 * np.pi) - np.pi
            chi2 = q[0, 0] * x * x + q[1, 1] * y * y + q[2, 2] * h * h
            chi2 += 2 * (q[0, 1] * x * y + q[0, 2] * x * h + q[1, 2] * y * h)
            if chi2 < FURTHEST:
                total += np.exp(-0.5 * chi2)
        if total > enough:
            break
    return total


@njit(cache=True)
def _between(a: FloatArray, b: FloatArray) -> FloatArray:
    x, y, c, s = b[0] - a[0], b[1] - a[1], np.cos(a[2]), np.sin(a[2])
    return np.array([c * x + s * y, c * y - s * x, b[2] - a[2]])


@njit(cache=True)
def _composed(a: FloatArray, b: FloatArray) -> FloatArray:
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])
