"""How well the map knows one place from another, and which older places the robot can be at."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.mapping.graph import TopoMap
from topomap.mapping.optimisation import Optimisation
from topomap.mapping.optimizer.problem import ClosureEdge
from topomap.mapping.uncertainty.incremental_chain import IncrementalChain
from topomap.mapping.uncertainty.odometry_chain import Chain, carried_to_origin
from topomap.mapping.uncertainty.path_covariance import best_way, joined_way, seen_from_all, turned

LATEST = 3  # closures over which a shorter way is looked for
JOINED = 20  # latest closures before a place that together tell how its stretch lies to an older one


class Reachability:
    """Covariances along the travelled chain, also over closures; follows the map as it changes."""

    def __init__(self, topo: TopoMap, optimisation: Optimisation, sigma: float, probability: float) -> None:
        """sigma [m]: how far apart the two spots of a true closure may lie; probability of a true one to pass."""
        self._map = topo
        self._optimisation = optimisation
        self._incremental = IncrementalChain(topo, optimisation.sequential.turns)
        self._variance = sigma**2
        self._limit = float(chdtri(2, 1 - probability))
        self._made: tuple[int, ...] | None = None
        self._chain: Chain | None = None
        self._place: IntArray = np.zeros(0, np.int64)
        self._joins: tuple[IntArray, FloatArray] | None = None  # all closures, as `_carried` gives them
        self._informations: FloatArray | None = None

    def errors(self, match: int, query: int) -> FloatArray:
        """Return the errors (3, 3) about the map's origin between two nodes along the route, or across closures where
        that is better: over the best one, or over all along two stretches that lie beside one another.
        """
        chain = self._current()
        x, y, _ = self._map.poses[query].tolist()
        if self._joins is None:
            self._joins = self._carried(self._map.closures)
        ends, closures = self._joins
        i, j = int(self._place[match]), int(self._place[query])
        found = np.asarray(best_way(chain.random, chain.systematic, chain.calibration, i, j, x, y, ends, closures))
        before = np.flatnonzero(ends.max(axis=1, initial=0) <= j)
        if not len(before):
            return found
        latest = before[np.argsort(ends[before].max(axis=1), kind="stable")[-JOINED:]]
        joined = joined_way(
            chain.random, chain.systematic, chain.calibration, i, j, np.sort(ends[latest], axis=1), closures[latest]
        )
        return min(found, np.asarray(joined), key=lambda errors: _position(errors, x, y))

    def covariance(self, match: int, query: int) -> FloatArray:
        """Return the covariance (3, 3) of `match_from_query` by these errors."""
        return self.seen(match, query, self.errors(match, query))

    def seen(self, match: int, query: int, errors: FloatArray) -> FloatArray:
        """Return errors (3, 3) about the map's origin as the covariance (3, 3) of `match_from_query`."""
        x, y, _ = self._map.poses[query].tolist()
        return turned(errors, self._map.pose(match).heading, x, y)

    def reach(self, node: int) -> float:
        """Return how far from where the map has it the robot may be, seen from an older node [m]."""
        information = self._seen_from_all()[self._place[node]]
        variance = 1.0 / float(np.linalg.eigvalsh(information)[0]) - self._variance
        return math.sqrt(self._limit * max(variance, 0.0))

    def within_reach(self, pose: Pose2, nodes: IntArray) -> IntArray:
        """Return those of some older nodes (n,) at which odometry allows the robot to be, now estimated at `pose`."""
        if not len(nodes):
            return nodes
        informations = self._seen_from_all()
        away = self._map.poses[nodes, :2] - np.array([pose.x, pose.y])
        chi2 = np.einsum("ni,nij,nj->n", away, informations[self._place[nodes]], away)
        possible: IntArray = nodes[chi2 <= self._limit]
        return possible

    def _current(self) -> Chain:
        state = (len(self._map.nodes), len(self._map.turns), len(self._map.closures), self._optimisation.solves)
        if self._made != state or self._chain is None:
            self._made = state
            self._chain = self._incremental.current(self._optimisation.covariance)
            self._place = np.empty(len(self._map.chain), np.int64)
            self._place[self._map.chain] = np.arange(len(self._map.chain))
            self._joins = self._informations = None
        return self._chain

    def _seen_from_all(self) -> FloatArray:
        """Return (N, 2, 2) informations of the chain's end, seen from every place of it, in the map frame."""
        chain = self._current()
        if self._informations is not None:
            return self._informations
        x, y, _ = chain.poses[-1].tolist()
        ends, closures = self._carried(self._map.closures[-LATEST:])
        last = len(chain.poses) - 1
        self._informations = np.asarray(
            seen_from_all(chain.random, chain.systematic, chain.calibration, last, x, y, ends, closures, self._variance)
        )
        return self._informations

    def _carried(self, closures: Sequence[ClosureEdge]) -> tuple[IntArray, FloatArray]:
        """Return the chain places (M, 2) that closures join, and their covariances (M, 3, 3) about the origin."""
        ends = np.array([(c.i, c.j) for c in closures], np.int64).reshape(-1, 2)
        carry = carried_to_origin(self._map.poses[ends[:, 0]], self._map.poses[ends[:, 1]])
        covariances = np.array([c.covariance for c in closures]).reshape(-1, 3, 3)
        return self._place[ends], carry @ covariances @ carry.transpose(0, 2, 1)


def _position(errors: FloatArray, x: float, y: float) -> float:
    """Return the variance of a position [m^2] by errors (3, 3) about the origin."""
    return float(np.trace(turned(errors, 0.0, x, y)[:2, :2]))
