"""How well the map knows one place from another: covariances along the best known path over odometry and closures."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.uncertainty.junctions import Junctions, adjacent, summed_between, worth
from topomap.mapping.uncertainty.network_kernels import bounds, distances, path_errors, tree_errors
from topomap.mapping.uncertainty.network_search import NEVER
from topomap.mapping.uncertainty.odometry_chain import Chain, carried_to_origin

ROOTS = 24  # nodes from which paths to all others are known; more of them hardly tighten the bound on 10,000 nodes
MANY = 30  # paths asked for from which on it pays to find first how far all places are from some landmarks
LANDMARKS, ANOTHER = 4, 250  # of these so many, and one more for every so many paths: of few paths more save nothing


class Edges(NamedTuple):
    """E edges of a network of N nodes.

    first (N + 1,) and onward (2 E,): each node's edges; start, end (E,): the nodes an edge joins; random (E, 3, 3): its
    error about the map's origin; systematic (E, 3, 3): what the calibration does to it; label (E,): -1 for odometry.
    """

    first: IntArray
    onward: IntArray
    start: IntArray
    end: IntArray
    random: FloatArray
    systematic: FloatArray
    label: IntArray


class PathNetwork:
    """The travelled chain and the closures that stand, as a network of errors that add up along a path.

    Errors carried to the map's origin add whatever the path's shape (see `Chain`). The best path is the one with the
    least variance of heading. Other paths can only add to what is known, so the covariance is an upper bound.
    """

    def __init__(self, chain: Chain, i: IntArray, j: IntArray, covariance: FloatArray, label: IntArray) -> None:
        """Take the chain and M closures: i, j (M,) places, covariance (M, 3, 3) of `i_from_j`, label (M,) from 0."""
        self.chain = chain
        nodes = len(chain.poses)
        carry = carried_to_origin(chain.poses[i], chain.poses[j])
        start = np.concatenate([np.arange(nodes - 1), i])
        end = np.concatenate([np.arange(1, nodes), j])
        self._edges = Edges(
            *adjacent(start, end, nodes),
            start,
            end,
            np.concatenate([np.diff(chain.random, axis=0), carry @ covariance @ carry.transpose(0, 2, 1)]),
            np.concatenate([np.diff(chain.systematic, axis=0), np.zeros((len(i), 3, 3))]),
            np.concatenate([np.full(nodes - 1, NEVER), label]),
        )
        self._ends = np.column_stack([i, j])
        self._junctions: Junctions | None = None
        self._far = np.zeros((nodes, 0))

    @staticmethod
    def of_chain(chain: Chain) -> PathNetwork:
        """Return the network of the chain alone."""
        nothing = np.zeros(0, np.int64)
        return PathNetwork(chain, nothing, nothing, np.zeros((0, 3, 3)), nothing)

    def errors(self, i: IntArray, j: IntArray, without: IntArray | None = None) -> FloatArray:
        """Return (n, 3, 3) the errors about the origin between places i and j (n,).

        without (n,): closures of this label aren't used, -1 for none.
        """
        if not len(self._ends):
            return self.along(i, j)
        skip = np.full(len(i), NEVER) if without is None else without
        sure = not self.chain.calibration.any()
        if sure and without is None and worth(len(i), self._junction_count, len(self._ends)):
            return self._over_junctions().errors(i, j)
        landmarks = self._landmarks(len(i)) if sure and len(i) >= MANY else self._far[:, :0]
        found = np.asarray(path_errors(*self._edges, self.chain.calibration, landmarks, i, j, skip))
        if sure or without is not None:
            return found
        detour = self.upper_bounds(i, j)  # the way found needn't be the best
        return np.where((detour[:, 2, 2] < found[:, 2, 2])[:, None, None], detour, found)

    @cached_property
    def _junction_count(self) -> int:
        return len(np.unique(self._ends))

    def _over_junctions(self) -> Junctions:
        if self._junctions is None:
            self._junctions = Junctions.of(self.chain.random, self._ends, self._edges.random[-len(self._ends) :])
        return self._junctions

    def _landmarks(self, paths: int) -> FloatArray:
        """(N, K) how far places are from some [rad^2] with closures of every label: no path is shorter."""
        wanted = min(LANDMARKS + paths // ANOTHER, ROOTS, len(self._far))
        if self._far.shape[1] < wanted:
            self._far = np.asarray(distances(*self._edges, self.chain.calibration, self._roots(wanted)))
        return self._far

    def _roots(self, count: int) -> IntArray:
        """Return so many places, evenly spread along the way."""
        nodes = len(self.chain.poses)
        return np.unique(np.linspace(0, nodes - 1, min(count, nodes)).astype(np.int64))

    def upper_bounds(self, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n, 3, 3) errors about the origin that are no smaller than `errors`: by the best of some detours."""
        if not len(self._ends):
            return self.along(i, j)
        random, systematic = tree_errors(*self._edges, self.chain.calibration, self._roots(ROOTS))
        return np.asarray(bounds(random, systematic, self.chain.calibration, i, j))

    def along(self, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n, 3, 3) the errors about the origin between places i and j (n,) by odometry alone."""
        random = summed_between(self.chain.random, i, j)
        if not self.chain.calibration.any():
            return random
        systematic = summed_between(self.chain.systematic, i, j)
        return np.asarray(random + systematic @ self.chain.calibration @ systematic.transpose(0, 2, 1))
