"""How well a pose graph knows one node from another: covariances along the best known way."""

from __future__ import annotations

import heapq

import numpy as np
from numba import njit

from topomap.geometry import FloatArray
from topomap.mapping.backend import Closures
from topomap.mapping.chain import Chain, carried_to_origin
from topomap.mapping.odometry import IntArray

WAYS = 2  # that share no edge: a node on a chain that no closure holds has no third


class Paths:
    """The chain and its believed closures as a network.

    Errors carried to the map's origin add up along a way whatever its shape (see `Chain`), so a way's covariance is
    a sum over its edges, and ways that share no edge tell the same independently. The best of them are those with the
    least variance of heading; what they say together is an upper bound, as other ways can only add to what is known.
    """

    def __init__(self, chain: Chain, closures: Closures) -> None:
        self._chain, self._closures = chain, closures
        carry = carried_to_origin(chain.poses[closures.i], chain.poses[closures.j])
        self._carried = carry @ closures.covariance @ carry.transpose(0, 2, 1)

    def covariance(self, i: IntArray, j: IntArray, without: IntArray) -> FloatArray:
        """Return (n, 3, 3) covariances of `i_from_j`, without: a closure (n,) not to use, or -1."""
        own = self._closures
        keys = np.unique(np.concatenate([own.i, own.j, i, j]))
        links = len(keys) - 1
        start = np.concatenate([np.arange(links), np.searchsorted(keys, own.i)])
        end = np.concatenate([np.arange(1, links + 1), np.searchsorted(keys, own.j)])
        sums = np.concatenate([np.diff(self._chain.random[keys], axis=0), self._carried])
        first, onward = _adjacent(start, end, len(keys))
        skip = np.where(without < 0, -1, without + links)
        ends = np.searchsorted(keys, i), np.searchsorted(keys, j)
        total, found = _along(first, onward, start, end, sums, *ends, skip, WAYS)
        back = np.linalg.inv(carried_to_origin(self._chain.poses[i], self._chain.poses[j]))[:, None]
        known = np.arange(WAYS) < found[:, None]
        each = back @ np.where(known[:, :, None, None], total, np.eye(3)) @ back.transpose(0, 1, 3, 2)
        information = np.where(known[:, :, None, None], np.linalg.inv(each), 0.0).sum(axis=1)
        return np.asarray(np.linalg.inv(information))


def _adjacent(start: IntArray, end: IntArray, nodes: int) -> tuple[IntArray, IntArray]:
    """Return where each node's edges begin (nodes + 1,) in the list of edges by node (2 E,)."""
    at = np.concatenate([start, end])
    edge = np.tile(np.arange(len(start)), 2)
    order = np.argsort(at, kind="stable")
    return np.searchsorted(at[order], np.arange(nodes + 1)), edge[order]


@njit(cache=True)
def _along(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, sums: FloatArray,
    i: IntArray, j: IntArray, skip: IntArray, ways: int,
) -> tuple[FloatArray, IntArray]:  # fmt: skip
    """Return (n, ways, 3, 3) the sums along edge-disjoint ways from i to j, the shortest first, and how many (n,)."""
    total, found = np.zeros((len(i), ways, 3, 3)), np.zeros(len(i), np.int64)
    used = np.full(len(start), -1)
    for n in range(len(i)):
        if skip[n] >= 0:
            used[skip[n]] = n
        for way in range(ways):
            by = _shortest(first, onward, start, end, sums, i[n], j[n], used, n)
            if by[j[n]] < 0:
                break
            node = j[n]
            while node != i[n]:
                edge = by[node]
                total[n, way] += sums[edge]
                used[edge] = n
                node = start[edge] + end[edge] - node
            found[n] = way + 1
    return total, found


@njit(cache=True)
def _shortest(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, sums: FloatArray,
    source: int, target: int, used: IntArray, mark: int,
) -> IntArray:  # fmt: skip
    """Return the edge by which each node is reached on the shortest way from the source (Dijkstra); -1: not reached."""
    distance, by = np.full(len(first) - 1, np.inf), np.full(len(first) - 1, -1)
    distance[source] = 0.0
    queue = [(0.0, source)]
    while queue:
        here, node = heapq.heappop(queue)
        if node == target:
            break
        if here > distance[node]:
            continue
        for edge in onward[first[node] : first[node + 1]]:
            other = start[edge] + end[edge] - node
            there = here + sums[edge, 2, 2]
            if used[edge] != mark and there < distance[other]:
                distance[other], by[other] = there, edge
                heapq.heappush(queue, (there, other))
    return by
