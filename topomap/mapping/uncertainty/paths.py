"""How well a pose graph knows one node from another: covariances along the best known way."""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.optimizer import Closures
from topomap.mapping.uncertainty.odometry_chain import Chain, carried_to_origin

WAYS = 2  # that share no edge: a node on a chain that no closure holds has no third
MOST = 10  # nearest others that a closure is compared with


class Network(NamedTuple):
    """Nodes (K,) of the chain that closures touch or ask for; each one's edges; the edges' ends and carried sums."""

    keys: IntArray
    first: IntArray
    onward: IntArray
    start: IntArray
    end: IntArray
    sums: FloatArray

    def place(self, nodes: IntArray) -> IntArray:
        """Return where nodes (n,) of the chain stand among the keys."""
        return np.searchsorted(self.keys, nodes)


class Near(NamedTuple):
    """Pairs (P,) of a closure and one near it, its rank among the nearest of that one, from 1, and the covariances
    (P, 3, 3) of `ia_from_ib` and `ja_from_jb`.
    """

    a: IntArray
    b: IntArray
    rank: IntArray
    known_i: FloatArray
    known_j: FloatArray


class Paths:
    """The chain and its inlier closures as a network.

    Errors carried to the map's origin add up along a way whatever its shape (see `Chain`), so a way's covariance is
    a sum over its edges, and ways that share no edge are independent measurements of the same relative pose. Those with
    the least variance of heading are combined: an upper bound, as further ways could only lower it.
    """

    def __init__(self, chain: Chain, closures: Closures) -> None:
        self._chain, self._closures = chain, closures
        carry = carried_to_origin(chain.poses[closures.i], chain.poses[closures.j])
        self._carried = carry @ closures.covariance @ carry.transpose(0, 2, 1)

    def covariance(self, i: IntArray, j: IntArray, without: IntArray) -> FloatArray:
        """Return (n, 3, 3) covariances of `i_from_j`, without: a closure (n,) not to use, or -1."""
        net = self._network(i, j)
        skip = np.where(without < 0, -1, without + len(net.keys) - 1)
        total, found = _along(*net[1:], net.place(i), net.place(j), skip, WAYS)
        back = np.linalg.inv(carried_to_origin(self._chain.poses[i], self._chain.poses[j]))[:, None]
        known = np.arange(WAYS) < found[:, None]
        each = back @ np.where(known[:, :, None, None], total, np.eye(3)) @ back.transpose(0, 1, 3, 2)
        information = np.where(known[:, :, None, None], np.linalg.inv(each), 0.0).sum(axis=1)
        return np.asarray(np.linalg.inv(information))

    def near(self, i: IntArray, j: IntArray, limit: float) -> Near:
        """Return for some closures with ends i, j (n,) the nearest others with headings of both ends known from their
        own to a limit [rad]; of two that are among each other's nearest, the one that is nearer to the other.
        """
        net = self._network(i, j)
        a, b, rank, first, second = _near(*net[1:], net.place(i), net.place(j), limit**2, MOST)
        order = np.lexsort((rank, np.maximum(a, b), np.minimum(a, b)))
        twice = (np.diff(np.minimum(a, b)[order]) == 0) & (np.diff(np.maximum(a, b)[order]) == 0)
        once = np.sort(order[np.append(True, ~twice)[: len(order)]])
        a, b, rank, first, second = (part[once] for part in (a, b, rank, first, second))
        covariances = []
        for end, total in ((i, first), (j, second)):
            back = np.linalg.inv(carried_to_origin(self._chain.poses[end[a]], self._chain.poses[end[b]]))
            covariances.append(back @ total @ back.transpose(0, 2, 1))
        return Near(a, b, rank, *covariances)

    def _network(self, i: IntArray, j: IntArray) -> Network:
        own = self._closures
        keys = np.unique(np.concatenate([own.i, own.j, i, j]))
        links = len(keys) - 1
        start = np.concatenate([np.arange(links), np.searchsorted(keys, own.i)])
        end = np.concatenate([np.arange(1, links + 1), np.searchsorted(keys, own.j)])
        sums = np.concatenate([np.diff(self._chain.random[keys], axis=0), self._carried])
        return Network(keys, *_adjacent(start, end, len(keys)), start, end, sums)


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
            _, by = _shortest(first, onward, start, end, sums, i[n], j[n], used, n, np.inf)
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
    source: int, target: int, used: IntArray, mark: int, limit: float,
) -> tuple[FloatArray, IntArray]:  # fmt: skip
    """Return how far each node is from the source [variance of heading], and by which edge (Dijkstra).

    It ends at the target (-1: none) and at the limit; nodes beyond are at inf, by -1. used (E,): edges with the mark
    are closed.
    """
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
            if used[edge] != mark and there <= limit and there < distance[other]:
                distance[other], by[other] = there, edge
                heapq.heappush(queue, (there, other))
    return distance, by


@njit(cache=True)
def _near(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, sums: FloatArray,
    i: IntArray, j: IntArray, limit: float, most: int,
) -> tuple[IntArray, IntArray, IntArray, FloatArray, FloatArray]:  # fmt: skip
    """Return pairs a, b with both ends within a variance of heading, b the rank-th nearest, and the sums between."""
    pairs = np.empty((len(i) * most, 3), np.int64)
    sum_i, sum_j = np.empty((len(i) * most, 3, 3)), np.empty((len(i) * most, 3, 3))
    count, used = 0, np.full(len(start), -1)
    for a in range(len(i)):
        from_i, by_i = _shortest(first, onward, start, end, sums, i[a], -1, used, 0, limit)
        from_j, by_j = _shortest(first, onward, start, end, sums, j[a], -1, used, 0, limit)
        far = from_i[i] + from_j[j]
        far[(j == j[a]) | ~np.isfinite(far)] = np.inf
        for rank, b in enumerate(np.argsort(far, kind="mergesort")[:most]):
            if far[b] == np.inf:
                break
            pairs[count] = a, b, rank + 1
            sum_i[count] = _sum_back(start, end, sums, by_i, i[a], i[b])
            sum_j[count] = _sum_back(start, end, sums, by_j, j[a], j[b])
            count += 1
    return pairs[:count, 0], pairs[:count, 1], pairs[:count, 2], sum_i[:count], sum_j[:count]


@njit(cache=True)
def _sum_back(start: IntArray, end: IntArray, sums: FloatArray, by: IntArray, source: int, target: int) -> FloatArray:
    """Return the sum of the edges by which a target is reached from the source."""
    total = np.zeros((3, 3))
    while target != source:
        total += sums[by[target]]
        target = start[by[target]] + end[by[target]] - target
    return total
