"""The finished map: every claim weighed by it, what strains it taken out, each closure tested beside the others."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.evidence import apart_from_others, log_odds_beside_others
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.prevalence import GATE
from topomap.mapping.closures.strain import strained
from topomap.mapping.closures.working_map import CLOSING, FEW, LIKELY, SEVERAL, SURE, UNLIKELY, WorkingMap
from topomap.mapping.uncertainty.network import PathNetwork
from topomap.mapping.uncertainty.odometry_chain import carried_to_origin

FALSE = 3e-4  # share of false ones that the finished map's closures may hold by their odds
DOUBT = 1e-3  # share of false ones among closures tested beside the others up to which lone ones stand
SEARCHED = 500  # closures that stand up to which what the map knows of them is searched path by path
SETTLINGS = 6  # at most: solve, take out what strains the map, solve
SETTLED = 1e-3  # share of new closures with which the finished map is no longer solved anew


def settle(working: WorkingMap) -> None:
    """Weigh every claim by the map and solve with the likely ones until nothing strains it."""
    if not len(working.standing):
        return
    suspected = np.zeros(len(working.clusters), bool)
    tense = ~suspected
    for turn in range(SETTLINGS):
        working.told(0.7 + 0.3 * turn / SETTLINGS, f"{len(working.standing)} closures, settling")
        before, likely = len(working.standing), _likely(working, suspected)
        if not tense.any() and np.array_equal(likely, working.standing):
            break  # the map was solved with these, all of them fit and none strains it
        if not before:  # all were taken out: what comes back has as far to pull as at first
            working.pull(likely)
        working.solve(likely, CLOSING)
        tense = _strained(working) & ~suspected
        if turn == SETTLINGS - 1 or (not tense.any() and len(working.standing) <= before * (1 + SETTLED)):
            break
        if tense.any():
            suspected = suspected | tense
            working.solve(working.standing[~tense[working.clusters.label[working.standing]]], CLOSING)


def confirm(working: WorkingMap) -> None:
    """Take out, the weakest first, what the others that stand don't make likely: what stands vouches for itself.

    Then, closure by closure, what they put elsewhere: one of a cluster may be false though the others are true.
    """
    while len(working.standing):
        ones = working.ones()
        label = working.clusters.label[ones]
        odds = log_odds_beside_others(working.drive, working.map, working.claims[ones], working.prior_odds(ones))
        weak = doubtful(odds, working.clusters.size[label])
        if not len(weak):
            break
        # a quarter of them at a time: with the weakest out the others may be stronger
        out = label[weak[np.argsort(odds[weak], kind="stable")[: 1 + len(weak) // 4]]]
        _withdraw(working, np.isin(working.clusters.label[working.standing], out))
    for _ in range(SETTLINGS):
        if not len(working.standing):
            return
        apart = apart_from_others(working.drive, working.map.poses, working.claims[working.standing])
        if not apart.any():
            return
        _withdraw(working, apart)


def _withdraw(working: WorkingMap, gone: BoolArray) -> None:
    """Take out some of the claims that stand (n,)."""
    working.odds[working.standing[gone]] = np.minimum(working.odds[working.standing[gone]], LIKELY)
    working.solve(working.standing[~gone], CLOSING)


def doubtful(odds: FloatArray, size: IntArray) -> IntArray:
    """Return which of n clusters of some size (n,) are to be doubted, lone ones sooner than several that agree."""
    order = np.argsort(-odds, kind="stable")
    closures = size[order]
    share = np.cumsum(closures * expit(-odds[order])) / np.cumsum(closures)
    return np.asarray(order[((share > DOUBT) & (closures < SEVERAL)) | (odds[order] < LIKELY)])


def undecided(working: WorkingMap) -> int:
    """Return how many clusters don't stand though the map, as it is settled, doesn't make them unlikely."""
    label = working.clusters.label
    left = np.zeros(len(working.clusters), bool)
    left[label[working.odds > -UNLIKELY]] = True
    left[label[working.standing]] = False
    return int((left & working.allowed).sum())


def _strained(working: WorkingMap) -> BoolArray:
    """Return which clusters (K,) strain the map."""
    return strained(working.map.poses, working.claims, working.clusters.label, working.standing, working.network())


def _likely(working: WorkingMap, suspected: BoolArray) -> IntArray:
    """Return all claims that the map makes likely; suspected clusters (K,) come back as they once came in."""
    network, label, claims = working.network(), working.clusters.label, working.claims
    errors, member = beside_standing(working, network)
    others = np.flatnonzero(~member & working.allowed[label])
    if len(np.unique(working.clusters.own[others])) > FEW:
        own = claims[others]
        chi2, _ = mahalanobis(own, working.map.poses, network.upper_bounds(own.i, own.j))
        others = others[chi2 <= 2 * GATE]
    errors[others] = beside_representatives(working, network, others)
    near = np.union1d(others, np.flatnonzero(member))
    working.odds[:] = -np.inf
    working.weigh(near, errors[near], UNLIKELY)
    odds = working.odds
    best = near[np.argsort(-odds[near], kind="stable")]
    best = best[odds[best] >= UNLIKELY]
    false = np.cumsum(expit(-odds[best])) / np.arange(1, len(best) + 1)
    back = suspected[label[best]] & (working.clusters.size[label[best]] >= SEVERAL)
    return np.sort(best[(false <= FALSE) | (odds[best] >= np.where(back, LIKELY, SURE))])


def _known(working: WorkingMap, network: PathNetwork, anchors: IntArray) -> FloatArray:
    """Return errors (n, 3, 3) about the origin between the places of standing claims (n,).

    Of many they are read from the solve, where all paths count: a search for the best path of each took most of the
    time on w10000, with 10,000 of them.
    """
    own = working.claims[anchors]
    if len(anchors) <= SEARCHED or not working.drive.held or own.blind.any():
        return network.errors(own.i, own.j)
    poses = working.map.poses
    _, known = working.drive.solver.known(poses, own.closures())
    carry = carried_to_origin(poses[own.i], poses[own.j])
    return np.asarray(carry @ known @ carry.transpose(0, 2, 1))


def beside_standing(working: WorkingMap, network: PathNetwork) -> tuple[FloatArray, BoolArray]:
    """Return errors (M, 3, 3) about the origin for members of standing clusters, and which claims (M,) these are.

    A member's path leads over the closure of the same cluster beside it: no search is needed for each of thousands.
    """
    claims, standing, cell = working.claims, working.standing, working.clusters.cell
    cells, first = np.unique(cell[standing], return_index=True)
    anchors = standing[first]
    place = np.minimum(np.searchsorted(cells, cell), max(len(cells) - 1, 0))
    member = cells[place] == cell if len(cells) else np.zeros(len(claims), bool)
    errors = np.zeros((len(claims), 3, 3))
    known = _known(working, network, anchors)
    own, beside = np.flatnonzero(member), anchors[place[member]]
    errors[own] = known[place[own]] + _between(claims, network, own, beside)
    return errors, member


def beside_representatives(working: WorkingMap, network: PathNetwork, which: IntArray) -> FloatArray:
    """Return errors (n, 3, 3) about the origin between the places of claims (n,), which don't stand.

    A search for each cell's representative; the path of one beside it is that one's and the ways there.
    """
    beside = working.clusters.own[which]
    asked, place = np.unique(beside, return_inverse=True)
    found = network.errors(working.claims.i[asked], working.claims.j[asked])
    return np.asarray(found[place] + _between(working.claims, network, which, beside))


def _between(claims: Claims, network: PathNetwork, which: IntArray, beside: IntArray) -> FloatArray:
    """Return errors (n, 3, 3) of odometry from the places of claims (n,) to those of others (n,) beside them."""
    there = network.along(claims.i[which], claims.i[beside])
    return np.asarray(there + network.along(claims.j[which], claims.j[beside]))
