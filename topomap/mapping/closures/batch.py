"""All claims about a drive at once: weigh what is claimed, solve with what is likely, test what stands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, ClosureTest, Knowledge
from topomap.mapping.closures.clusters import STRIDE, Clusters, clusters_of
from topomap.mapping.closures.drive import Drive, MapState
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.evidence import log_evidence, log_odds_beside_others
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.placing import placed
from topomap.mapping.closures.prevalence import GATE, allowed_by_chance, log_prevalence
from topomap.mapping.closures.strain import strained
from topomap.mapping.optimizer import OptimizerSettings
from topomap.mapping.uncertainty.network import PathNetwork

SURE = float(np.log(1000.0))  # log odds from which a lone claim bends the growing map, and any is an inlier of the last
SEVERAL = 3  # claims that agree with one another ...
LIKELY = float(
    np.log(20.0)
)  # ... may bend the growing map sooner: what is false among them strains it and is taken out
POSSIBLE = float(np.log(5.0))  # ... and where nothing is so likely, sooner still: else a map without a start stays one
FALSE = 3e-4  # share of false ones that the finished map's closures may hold by their odds
UNLIKELY = float(np.log(20.0))  # log odds below which none is taken whatever the others are
FEW = 500  # claims whose best paths are found at once; of more, only those that a quick upper bound leaves
TRIES = 3  # times a cluster that didn't fit the solve is taken up again
ROUNDS = 60  # of admitting and solving at most: each brings new clusters, or it ends
SETTLINGS = 6  # of the finished map at most: solve, take out what strains it, solve
SETTLED = 1e-3  # share of new closures with which the finished map is no longer solved anew
# new closures may pull the map far: begin with cutoffs that let all of them pull
GROWING = OptimizerSettings(cutoffs=(1e3, 10.0), iterations=2, tolerance=0.02)
# 6 sigmas: the noise's scale is that of 99 % of the closures, and real ones have heavy tails
CLOSING = OptimizerSettings(cutoffs=(20.0, 6.0), cutoff=6.0, iterations=10, tolerance=1e-4)
# from odometry on: cutoffs so wide and steps so many that of two claims that differ the one that others agree with wins
AT_ONCE = OptimizerSettings(cutoffs=(30.0,) * 4 + (10.0,) * 3, cutoff=6.0, iterations=4, tolerance=0.02)
DENSE = 40  # blocks a pose in a factor: 5 on intel, 7 on manhattan, 15 on w10000 with all their true closures
MOSTLY = 0.5  # share of true claims from which on it is quicker to begin with all at once

Told = Callable[[float, str], None]


def quiet(_share: float, _doing: str) -> None:
    """Tell nobody how far the work is."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """What became of M claims: the map, which are inliers (M,), their log odds (M,) and why, in plain words (M,).

    kept: which of several solutions the map is, and why.
    """

    state: MapState
    inlier: BoolArray
    log_odds: FloatArray
    reason: tuple[str, ...]
    kept: str


class Batch:
    """Judges all claims about a drive.

    Claims of neighbouring places that agree are one piece of evidence, a cluster. Those that odometry can't explain are
    refused, and tell how often such claims are true. Round by round the likely ones are let in and the map is solved;
    so it knows its places better and can tell more of the others. At the end every claim is weighed by the finished
    map, and what strains it is taken out, weighed once more without itself, and stays out if it isn't likely then.
    """

    def __init__(self, drive: Drive, claims: Claims, tests: Sequence[ClosureTest] = TESTS, told: Told = quiet) -> None:
        """Take a drive and claims in order of i, then of j; told: hears the share done and what is being done."""
        self._drive, self._claims, self._told = drive, claims, told
        self._engine = ClosureEngine(tests)
        self._map = drive.start()
        chain = drive.chain(self._map)
        self._clusters: Clusters = clusters_of(claims, chain)
        self._odds = np.full(len(claims), -np.inf)
        self._standing = np.zeros(0, np.int64)
        self._tries = np.zeros(len(self._clusters), np.int64)
        self._sift(PathNetwork.of_chain(chain))

    def run(self) -> Judgement:
        """Return the verdicts on all claims, by a map that grows from the likeliest on."""
        self.grow()
        return self.judgement(self.settle())

    def grow(self) -> None:
        """Let in what is likely, round by round."""
        for round_ in range(ROUNDS):
            self._told(0.1 + 0.6 * round_ / (round_ + 5.0), f"{len(self._standing)} closures")
            new = self._likely(self._open())
            if not len(new):
                break
            self._admit(new)

    def pull_all(self) -> None:
        """Solve with all that odometry allows, from odometry on, with cutoffs that leave out what doesn't fit."""
        self._told(0.5, f"{len(self._all_allowed())} closures at once")
        self._solve(self._all_allowed(), AT_ONCE)

    @property
    def pulls_quickly(self) -> bool:
        """Whether a solve with all that odometry allows is quick: many that join any places make its factor dense."""
        own = self._claims[self._all_allowed()]
        nodes = len(self._map.poses)
        return len(own) <= nodes and self._drive.solver.fill(own.closures()) <= DENSE * nodes

    def _all_allowed(self) -> IntArray:
        some = self._clusters.representatives
        return np.asarray(some[self._allowed[self._clusters.label[some]]])

    def again(self) -> Batch:
        """Return the same, to be begun anew."""
        other = copy(self)
        other._map = self._drive.start()
        other._odds, other._standing = np.full(len(self._claims), -np.inf), np.zeros(0, np.int64)
        other._tries = np.zeros(len(self._clusters), np.int64)
        return other

    def judgement(self, inlier: BoolArray) -> Judgement:
        """Return the verdicts, of which inlier (M,) says who is in."""
        if not inlier.any():
            self._map = self._drive.start()
        self._told(1.0, f"{int(inlier.sum())} closures")
        kept = (
            f"{int(inlier.sum())} of {len(inlier)} closures are likely"
            if inlier.any()
            else "odometry: nothing is likely"
        )
        return Judgement(self._map, inlier, self._odds, self._reasons(inlier), kept)

    def _sift(self, odometry: PathNetwork) -> None:
        """Refuse the clusters that odometry can't explain, and learn from them how often claims are true."""
        own = self._claims[self._clusters.representatives]
        chi2, _ = mahalanobis(own, self._map.poses, odometry.errors(own.i, own.j))
        self._allowed = np.zeros(len(self._clusters), bool)
        self._allowed[self._clusters.label[self._clusters.representatives[chi2 <= GATE]]] = True
        by_chance = allowed_by_chance(own, self._map.poses, odometry)
        self._prevalence = log_prevalence(self._clusters.size, self._allowed, by_chance)

    def _open(self) -> IntArray:
        """Return the representatives of clusters that aren't decided yet."""
        label = self._clusters.label
        decided = ~self._allowed | (self._tries >= TRIES)
        decided[label[self._standing]] = True
        some = self._clusters.representatives
        return np.asarray(some[~decided[label[some]]])

    def _network(self) -> PathNetwork:
        own = self._claims[self._standing]
        chain = self._drive.chain(self._map)
        return PathNetwork(chain, own.i, own.j, own.covariance, self._clusters.label[self._standing])

    def _likely(self, which: IntArray) -> IntArray:
        """Return those of some claims that the map, as it stands without them, makes likely."""
        network = self._network()
        own = self._claims[which]
        near = which
        if len(which) > FEW:
            chi2, _ = mahalanobis(own, self._map.poses, network.upper_bounds(own.i, own.j))
            near = which[chi2 <= GATE]
            self._odds[which[chi2 > GATE]] = -np.inf
            own = self._claims[near]
        self._weigh(near, network.errors(own.i, own.j), POSSIBLE)
        odds, several = self._odds[near], self._clusters.size[self._clusters.label[near]] >= SEVERAL
        likely = odds >= np.where(several, LIKELY, SURE)
        return np.asarray(near[likely] if likely.any() else near[several & (odds >= POSSIBLE)])

    def _weigh(self, which: IntArray, errors: FloatArray, bar: float) -> None:
        """Set the log odds of some claims by one test after the other; below the bar the last ones aren't asked."""
        label = self._clusters.label[which]
        size, prior = self._clusters.size[label], self._prior()[label]
        knowledge = Knowledge(self._map.poses, errors, size, prior, np.ones(len(which)))
        self._odds[which] = self._engine.weigh(self._claims[which], knowledge, bar).log_odds

    def _prior(self) -> FloatArray:
        """Return (K,) log prior odds: who agrees with a cluster that stands is as likely as it is."""
        prior = self._prevalence.copy()
        stand = np.unique(self._clusters.label[self._standing])
        prior[stand] = np.maximum(prior[stand], LIKELY)
        return prior

    def _admit(self, new: IntArray) -> None:
        """Solve with new closures; those that don't fit beside the others stay out."""
        label = self._clusters.label
        chosen = np.zeros(len(self._clusters), bool)
        chosen[label[new]] = chosen[label[self._standing]] = True
        some = self._clusters.representatives
        self._pull(some[chosen[label[some]]])
        chosen[label[self._standing]] = False
        self._tries[chosen] += 1

    def _solve(self, which: IntArray, settings: OptimizerSettings) -> None:
        self._map, inlier = self._drive.solve(self._map, self._claims[which], settings)
        self._standing = which[inlier]

    def settle(self) -> BoolArray:
        """Weigh every claim by the map and solve with the likely ones until nothing strains it; return these (M,)."""
        if not len(self._standing):
            return np.zeros(len(self._claims), bool)
        suspected = np.zeros(len(self._clusters), bool)
        for turn in range(SETTLINGS):
            self._told(0.7 + 0.3 * turn / SETTLINGS, f"{len(self._standing)} closures, settling")
            before, likely = len(self._standing), self._likely_of_all(suspected)
            if not before:  # all were taken out: what comes back has as far to pull as at first
                self._pull(likely)
            self._solve(likely, CLOSING)
            tense = self._strained() & ~suspected
            if turn == SETTLINGS - 1 or (not tense.any() and len(self._standing) <= before * (1 + SETTLED)):
                break
            if tense.any():
                suspected = suspected | tense
                self._solve(self._standing[~tense[self._clusters.label[self._standing]]], CLOSING)
        return np.asarray(np.isin(np.arange(len(self._claims)), self._standing))

    def confirm(self) -> BoolArray:
        """Take out, the weakest first, what the others that stand don't make likely; return what stands (M,)."""
        while len(self._standing):
            odds, label = self._beside_others()
            weak = np.flatnonzero(odds < LIKELY)
            if not len(weak):
                break
            out = weak[np.argsort(odds[weak], kind="stable")[: 1 + len(weak) // 4]]
            left = self._standing[~np.isin(self._clusters.label[self._standing], label[out])]
            self._odds[self._standing] = np.minimum(self._odds[self._standing], LIKELY)
            self._standing = left
            self._solve(left, CLOSING)
        return np.asarray(np.isin(np.arange(len(self._claims)), self._standing))

    def _ones(self) -> IntArray:
        """Return a standing claim of each cluster that stands."""
        _, first = np.unique(self._clusters.label[self._standing], return_index=True)
        return np.asarray(self._standing[np.sort(first)])

    def _beside_others(self) -> tuple[FloatArray, IntArray]:
        """Return each standing cluster's log odds by the others, and which it is."""
        ones = self._ones()
        label = self._clusters.label[ones]
        return log_odds_beside_others(self._drive, self._map, self._claims[ones], self._prevalence[label]), label

    def evidence(self) -> float:
        """Return the log odds of what stands, all together, against nothing being true."""
        ones = self._ones()
        return log_evidence(self._drive, self._map, self._claims[ones], self._prevalence[self._clusters.label[ones]])

    def undecided(self) -> int:
        """Return how many clusters don't stand though the map, as it is settled, doesn't make them unlikely."""
        label = self._clusters.label
        open_ = np.zeros(len(self._clusters), bool)
        open_[label[self._odds > -UNLIKELY]] = True
        open_[label[self._standing]] = False
        return int((open_ & self._allowed).sum())

    @property
    def standing_clusters(self) -> int:
        """How many clusters stand."""
        return len(np.unique(self._clusters.label[self._standing]))

    @property
    def mostly_true(self) -> bool:
        """Whether of the claims that odometry allows most are true, as those that it refuses tell."""
        expected = expit(self._prevalence[self._allowed])
        return bool(expected.sum() >= MOSTLY * max(len(expected), 1))

    def _pull(self, closures: IntArray) -> None:
        """Begin a solve with closures that the map may stand far from."""
        own = self._claims[closures]
        self._map = replace(self._map, poses=placed(self._map.poses, self._drive.chain(self._map), own))
        self._solve(closures, GROWING)

    def _strained(self) -> BoolArray:
        """Return which clusters (K,) strain the map."""
        label = self._clusters.label
        return strained(self._map.poses, self._claims, label, self._standing, self._network())

    def _likely_of_all(self, suspected: BoolArray) -> IntArray:
        """Return all claims that the map makes likely; suspected clusters (K,) come back as they once came in."""
        network, label = self._network(), self._clusters.label
        errors, member = self._beside_standing(network)
        others = np.flatnonzero(~member & self._allowed[label])
        if len(others) > FEW:
            own = self._claims[others]
            chi2, _ = mahalanobis(own, self._map.poses, network.upper_bounds(own.i, own.j))
            others = others[chi2 <= 2 * GATE]
        errors[others] = network.errors(self._claims.i[others], self._claims.j[others])
        near = np.union1d(others, np.flatnonzero(member))
        self._odds[:] = -np.inf
        self._weigh(near, errors[near], UNLIKELY)
        best = near[np.argsort(-self._odds[near], kind="stable")]
        best = best[self._odds[best] >= UNLIKELY]
        false = np.cumsum(expit(-self._odds[best])) / np.arange(1, len(best) + 1)
        back = suspected[label[best]] & (self._clusters.size[label[best]] >= SEVERAL)
        return np.sort(best[(false <= FALSE) | (self._odds[best] >= np.where(back, LIKELY, SURE))])

    def _beside_standing(self, network: PathNetwork) -> tuple[FloatArray, BoolArray]:
        """Return errors (M, 3, 3) about the origin for members of standing clusters, and which claims (M,) these are.

        A member's path leads over the closure of the same cluster beside it: no search is needed for each of thousands.
        """
        claims, standing = self._claims, self._standing
        cell = self._clusters.label * (len(self._map.poses) // STRIDE + 1) + claims.i // STRIDE
        cells, first = np.unique(cell[standing], return_index=True)
        anchors = standing[first]
        place = np.minimum(np.searchsorted(cells, cell), max(len(cells) - 1, 0))
        member = cells[place] == cell if len(cells) else np.zeros(len(claims), bool)
        errors = np.zeros((len(claims), 3, 3))
        known = network.errors(claims.i[anchors], claims.j[anchors])
        own, beside = np.flatnonzero(member), anchors[place[member]]
        errors[own] = known[place[own]] + network.along(claims.i[own], claims.i[beside])
        errors[own] += network.along(claims.j[own], claims.j[beside])
        return errors, member

    def _reasons(self, inlier: BoolArray) -> tuple[str, ...]:
        """Return why each claim is in or out."""
        allowed = self._allowed[self._clusters.label]
        words = np.where(inlier, "fits the map with all other closures", "the map makes it unlikely")
        words = np.where(~inlier & (self._odds >= SURE), "likely, but the map can't fit it beside the others", words)
        return tuple(np.where(allowed, words, "odometry contradicts it").tolist())
