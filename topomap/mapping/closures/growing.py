"""How closures come into a map: the likeliest first, round by round, or all that odometry allows at once."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from topomap.core.arrays import IntArray
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.prevalence import GATE
from topomap.mapping.closures.working_map import FEW, LIKELY, SEVERAL, SURE, WorkingMap
from topomap.mapping.optimizer import OptimizerSettings

POSSIBLE = float(np.log(5.0))  # where nothing is likely, several that agree come in sooner: else there is no start
TRIES = 3  # times a cluster that didn't fit the solve is taken up again
ROUNDS = 60  # of admitting and solving at most: each brings new clusters, or it ends
# from odometry on: cutoffs so wide and steps so many that of two claims that differ the one that others agree with wins
AT_ONCE = OptimizerSettings(cutoffs=(30.0,) * 4 + (10.0,) * 3, cutoff=6.0, iterations=4, tolerance=0.02)
MOSTLY = 0.5  # share of true claims from which on it is quicker to begin with all at once
DENSE = 40  # blocks a pose in a factor: 5 on intel, 7 on manhattan, 15 on w10000 with all their true closures


def grow(working: WorkingMap) -> None:
    """Let in what is likely, round by round: with each the map knows its places better and can tell more of others."""
    tries = np.zeros(len(working.clusters), np.int64)
    for round_ in range(ROUNDS):
        working.told(0.1 + 0.6 * round_ / (round_ + 5.0), f"{len(working.standing)} closures")
        new = _likely(working, _open(working, tries))
        if not len(new):
            break
        _admit(working, new, tries)


def pull_all(working: WorkingMap) -> None:
    """Solve with all that odometry allows, from odometry on, with cutoffs that leave out what doesn't fit."""
    every = working.all_allowed()
    working.told(0.5, f"{len(every)} closures at once")
    working.solve(every, AT_ONCE)


def pulls_quickly(working: WorkingMap) -> bool:
    """Whether a solve with all that odometry allows is quick: many that join any places make its factor dense."""
    own, nodes = working.claims[working.all_allowed()], len(working.map.poses)
    return len(own) <= nodes and working.drive.solver.fill(own.closures()) <= DENSE * nodes


def mostly_true(working: WorkingMap) -> bool:
    """Whether of the clusters that odometry allows most are true, as those that it refuses tell."""
    expected = expit(working.prevalence[working.allowed])
    return bool(expected.sum() >= MOSTLY * max(len(expected), 1))


def _open(working: WorkingMap, tries: IntArray) -> IntArray:
    """Return the representatives of clusters that aren't decided yet."""
    label = working.clusters.label
    decided = ~working.allowed | (tries >= TRIES)
    decided[label[working.standing]] = True
    some = working.clusters.representatives
    return np.asarray(some[~decided[label[some]]])


def _likely(working: WorkingMap, which: IntArray) -> IntArray:
    """Return those of some claims that the map, as it stands without them, makes likely."""
    network = working.network()
    own, near = working.claims[which], which
    if len(which) > FEW:
        chi2, _ = mahalanobis(own, working.map.poses, network.upper_bounds(own.i, own.j))
        near = which[chi2 <= GATE]
        working.odds[which[chi2 > GATE]] = -np.inf
        own = working.claims[near]
    working.weigh(near, network.errors(own.i, own.j), POSSIBLE)
    odds, several = working.odds[near], working.clusters.size[working.clusters.label[near]] >= SEVERAL
    likely = odds >= np.where(several, LIKELY, SURE)
    return np.asarray(near[likely] if likely.any() else near[several & (odds >= POSSIBLE)])


def _admit(working: WorkingMap, new: IntArray, tries: IntArray) -> None:
    """Solve with new closures; those that don't fit beside the others stay out."""
    label = working.clusters.label
    chosen = np.zeros(len(working.clusters), bool)
    chosen[label[new]] = chosen[label[working.standing]] = True
    some = working.clusters.representatives
    working.pull(some[chosen[label[some]]])
    chosen[label[working.standing]] = False
    tries[chosen] += 1
