"""The map that a batch of claims is judged by while it is made: what stands, and what that makes of the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import ClosureTest, Knowledge
from topomap.mapping.closures.clusters import Clusters, clusters_of
from topomap.mapping.closures.drive import Drive, MapState
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.placing import placed
from topomap.mapping.closures.prevalence import GATE, allowed_by_chance, log_prevalence
from topomap.mapping.optimizer import OptimizerSettings
from topomap.mapping.uncertainty.network import PathNetwork

SURE = float(np.log(1000.0))  # log odds from which a lone claim bends the growing map, and any is an inlier of the last
SEVERAL = 3  # claims that agree with one another ...
# ... may bend the growing map sooner: what is false among them strains it and is taken out
LIKELY = float(np.log(20.0))
UNLIKELY = float(np.log(20.0))  # log odds below which none is taken whatever the others are
# paths that are searched at once; of more, only those that a bound leaves, which takes as long as some 3000 of them
FEW = 2000
# new closures may pull the map far: begin with cutoffs that let all of them pull
GROWING = OptimizerSettings(cutoffs=(1e3, 10.0), iterations=2, tolerance=0.02)
# 6 sigmas: the noise's scale is that of 99 % of the closures, and real ones have heavy tails
CLOSING = OptimizerSettings(cutoffs=(20.0, 6.0), cutoff=6.0, iterations=10, tolerance=1e-4)

Told = Callable[[float, str], None]


class _OfMap(NamedTuple):
    """The paths through a map and what stood in it, which are asked for several times."""

    map: MapState
    standing: IntArray
    paths: PathNetwork


class WorkingMap:
    """A drive's map with the claims that stand in it.

    map: as it stands; standing (n,): the claims it was solved with that fit; odds (M,): the claims' log odds when they
    were last weighed; allowed (K,): the clusters that odometry can explain; prevalence (K,): log of how many clusters
    like each are true for one that is false, as those tell that odometry refuses.
    """

    def __init__(self, drive: Drive, claims: Claims, tests: Sequence[ClosureTest], told: Told) -> None:
        """Take a drive and claims in order of i, then of j; told: hears the share done and what is being done."""
        self.drive, self.claims, self.told = drive, claims, told
        self._engine = ClosureEngine(tests)
        self.map = drive.start()
        self._network = _OfMap(self.map, np.zeros(0, np.int64), PathNetwork.of_chain(drive.chain(self.map)))
        self.clusters: Clusters = clusters_of(claims, self._network.paths.chain)
        self.odds = np.full(len(claims), -np.inf)
        self.standing = self._network.standing
        self._sift(self._network.paths)

    def _sift(self, odometry: PathNetwork) -> None:
        """Refuse the clusters that odometry can't explain, and learn from them how often claims are true."""
        own = self.claims[self.clusters.representatives]
        chi2, _ = mahalanobis(own, self.map.poses, odometry.errors(own.i, own.j))
        self.allowed = np.zeros(len(self.clusters), bool)
        self.allowed[self.clusters.label[self.clusters.representatives[chi2 <= GATE]]] = True
        by_chance = allowed_by_chance(own, self.map.poses, odometry)
        self.prevalence = log_prevalence(self.clusters.size, self.allowed, by_chance)

    def again(self) -> WorkingMap:
        """Return odometry's map of the same claims, in which nothing stands."""
        other = copy(self)
        other.map = self.drive.start()
        other.odds, other.standing = np.full(len(self.claims), -np.inf), np.zeros(0, np.int64)
        return other

    def network(self) -> PathNetwork:
        """Return the paths through the drive and the closures that stand."""
        last = self._network
        if last.map is not self.map or last.standing is not self.standing:
            own = self.claims[self.standing]
            chain = last.paths.chain if last.map is self.map else self.drive.chain(self.map)
            paths = PathNetwork(chain, own.i, own.j, own.covariance, self.clusters.label[self.standing])
            self._network = _OfMap(self.map, self.standing, paths)
        return self._network.paths

    def weigh(self, which: IntArray, errors: FloatArray, bar: float) -> None:
        """Set the log odds of some claims by one test after the other; below the bar the last ones aren't asked.

        errors (n, 3, 3): of the map between their places, about the origin.
        """
        label = self.clusters.label[which]
        size, prior = self.clusters.size[label], self._prior()[label]
        knowledge = Knowledge(self.map.poses, errors, size, prior, np.ones(len(which)))
        self.odds[which] = self._engine.weigh(self.claims[which], knowledge, bar).log_odds

    def prior_odds(self, which: IntArray) -> FloatArray:
        """Return the log odds (n,) of some claims by those tests that ask more than whether odometry agrees."""
        own, label = self.claims[which], self.clusters.label[which]
        errors = self.network().along(own.i, own.j)
        said = Knowledge(self.map.poses, errors, self.clusters.size[label], self.prevalence[label], np.ones(len(which)))
        return self._engine.beside_odometry(own, said)

    def _prior(self) -> FloatArray:
        """Return (K,) log prior odds: who agrees with a cluster that stands is as likely as it is."""
        prior = self.prevalence.copy()
        stand = self.standing_clusters()
        prior[stand] = np.maximum(prior[stand], LIKELY)
        return prior

    def solve(self, which: IntArray, settings: OptimizerSettings) -> None:
        """Solve with some claims; those that fit stand."""
        self.map, inlier = self.drive.solve(self.map, self.claims[which], settings)
        self.standing = which[inlier]

    def pull(self, which: IntArray) -> None:
        """Begin a solve with claims that the map may stand far from."""
        own = self.claims[which]
        self.map = replace(self.map, poses=placed(self.map.poses, self.network().chain, own))
        self.solve(which, GROWING)

    def standing_clusters(self) -> IntArray:
        """Return which clusters stand."""
        return np.unique(self.clusters.label[self.standing])

    def ones(self) -> IntArray:
        """Return a standing claim of each cluster that stands."""
        _, first = np.unique(self.clusters.label[self.standing], return_index=True)
        return np.asarray(self.standing[np.sort(first)])

    def all_allowed(self) -> IntArray:
        """Return the representatives of all clusters that odometry allows."""
        some = self.clusters.representatives
        return np.asarray(some[self.allowed[self.clusters.label[some]]])
