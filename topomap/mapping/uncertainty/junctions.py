"""Best paths through a chain that few closures join: only where closures end can a path leave the chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray, Int32Array, IntArray
from topomap.mapping.uncertainty.junction_kernels import by_junctions, trees, way_errors
from topomap.mapping.uncertainty.network_search import LEAST

EACH = 500
"""Edges looked at on the way from a junction to all others that take as long as a search of its own: 0.1 us each, and
0.1 to 0.3 ms for one of 100,000 paths over 40 to 40,000 closures of w10000."""
MOST = 4000
"""Junctions of which all are known from all: 192 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class Junctions:
    """A chain of N places and its J junctions, the places where closures end, with what lies between as single edges.

    random (N, 3, 3): the chain's errors about the map's origin, summed; variance (N,): the same of the heading as paths
    are chosen by it [rad^2]; places (J,): the junctions; start, end (E,): which of them an edge joins; own (E, 3, 3):
    its errors; apart, by (J, J): the variance of heading along the best path from one to another, and its last edge.
    """

    random: FloatArray
    variance: FloatArray
    places: IntArray
    start: IntArray
    end: IntArray
    own: FloatArray
    apart: FloatArray
    by: Int32Array

    @staticmethod
    def of(random: FloatArray, ends: IntArray, closures: FloatArray) -> Junctions:
        """Take the chain's summed errors (N, 3, 3), the places (M, 2) that closures join, their errors (M, 3, 3)."""
        places = np.unique(ends)
        count = len(places)
        start, end = np.searchsorted(places, ends).T
        start = np.concatenate([np.arange(count - 1), start])
        end = np.concatenate([np.arange(1, count), end])
        variance = np.concatenate([[0.0], np.cumsum(np.maximum(np.diff(random[:, 2, 2]), LEAST))])
        own = np.concatenate([np.diff(random[places], axis=0), closures])
        apart, by = trees(*adjacent(start, end, count), start, end, own)
        return Junctions(random, variance, places, start, end, own, apart, by)

    def errors(self, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n, 3, 3) the errors about the origin along the best path between places i and j (n,)."""
        before, after = by_junctions(self.variance, self.places, self.apart, i, j)
        errors = summed_between(self.random, i, j)
        over = np.flatnonzero(before >= 0)
        a, b = before[over], after[over]
        errors[over] = summed_between(self.random, i[over], self.places[a])
        errors[over] += summed_between(self.random, self.places[b], j[over])
        errors[over] += way_errors(self.start, self.end, self.own, self.by, a, b)
        return errors


def worth(paths: int, junctions: int, closures: int) -> bool:
    """Whether it is quicker to know all paths between junctions first than to search so many paths one by one."""
    return junctions <= MOST and junctions * (junctions + closures) < EACH * paths


def summed_between(sums: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    """Return (n, 3, 3) what sums (N, 3, 3) along the chain grow by between places i and j (n,), in either order."""
    return np.asarray(sums[np.maximum(i, j)] - sums[np.minimum(i, j)])


def adjacent(start: IntArray, end: IntArray, nodes: int) -> tuple[IntArray, IntArray]:
    """Return where each node's edges begin (nodes + 1,) in the list of edges by node (2 E,)."""
    at = np.concatenate([start, end])
    edge = np.tile(np.arange(len(start)), 2)
    order = np.argsort(at, kind="stable")
    return np.searchsorted(at[order], np.arange(nodes + 1)), edge[order]
