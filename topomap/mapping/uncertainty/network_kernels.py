"""Shortest paths through a network of odometry and closures, compiled."""

from __future__ import annotations

import heapq

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray

NEVER = -1  # the label of odometry, which every path may use
SIGNPOSTS = 4  # landmarks that a search looks at: more show little more and cost a look each


@njit(cache=True)
def heading_variances(random: FloatArray, systematic: FloatArray, calibration: FloatArray) -> FloatArray:
    """Return (E,) each edge's variance of heading [rad^2], which is what a best path has least of."""
    variance = np.empty(len(random))
    for edge in range(len(random)):
        total = random[edge, 2, 2]
        for p in range(3):
            for q in range(3):
                total += systematic[edge, 2, p] * calibration[p, q] * systematic[edge, 2, q]
        variance[edge] = max(total, 1e-15)
    return variance


@njit(cache=True)
def shortest(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, label: IntArray, variance: FloatArray,
    source: int, target: int, skip: int, reach: FloatArray, by: IntArray, seen: IntArray, turn: int,
) -> None:  # fmt: skip
    """Fill reach (N,) [rad^2] and by (N,), the edge by which a node is reached, from the source (Dijkstra).

    It ends at the target (-1: none). What is filled in this turn has seen (N,) equal to turn; edges labelled skip are
    closed.
    """
    reach[source], by[source], seen[source] = 0.0, -1, turn
    queue = [(0.0, source)]
    while queue:
        here, node = heapq.heappop(queue)
        if node == target:
            return
        if here > reach[node]:
            continue
        for edge in onward[first[node] : first[node + 1]]:
            if skip >= 0 and label[edge] == skip:
                continue
            other = start[edge] + end[edge] - node
            there = max(here + variance[edge], np.nextafter(here, np.inf))  # `tree_errors` needs it to grow
            if seen[other] != turn or there < reach[other]:
                reach[other], by[other], seen[other] = there, edge, turn
                heapq.heappush(queue, (there, other))


@njit(cache=True)
def _signposts(landmarks: FloatArray, source: int, target: int, chosen: IntArray) -> None:
    """Fill chosen (S,) with those landmarks (N, K) that show best how far the target is from the source."""
    told = np.abs(landmarks[source] - landmarks[target])
    for s in range(len(chosen)):
        chosen[s] = np.argmax(told)
        told[chosen[s]] = -1.0


@njit(cache=True)
def _left(landmarks: FloatArray, chosen: IntArray, node: int, target: int) -> float:
    """Return what is left to the target at least [rad^2]: landmarks (N, K) are as far from both as that (ALT)."""
    least = 0.0
    for k in chosen:
        least = max(least, abs(landmarks[node, k] - landmarks[target, k]))
    return least


@njit(cache=True)
def towards(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, label: IntArray, variance: FloatArray,
    source: int, target: int, skip: int, landmarks: FloatArray, reach: FloatArray, left: FloatArray, by: IntArray,
    seen: IntArray, turn: int,
) -> None:  # fmt: skip
    """Fill reach and by as `shortest` does, up to the target and mostly in its direction (A*, Goldberg 2005).

    landmarks (N, K): how far each node is from some; left (N,): what is left from a node seen in this turn.
    """
    chosen = np.empty(min(SIGNPOSTS, landmarks.shape[1]), np.int64)
    _signposts(landmarks, source, target, chosen)
    reach[source], by[source], seen[source] = 0.0, -1, turn
    left[source] = _left(landmarks, chosen, source, target)
    queue = [(left[source], 0.0, source)]
    while queue:
        _, gone, node = heapq.heappop(queue)
        if node == target:
            return
        here = -gone
        if here > reach[node]:
            continue
        for edge in onward[first[node] : first[node + 1]]:
            if skip >= 0 and label[edge] == skip:
                continue
            other = start[edge] + end[edge] - node
            there = max(here + variance[edge], np.nextafter(here, np.inf))
            if seen[other] != turn:
                left[other] = _left(landmarks, chosen, other, target)
            elif there >= reach[other]:
                continue
            reach[other], by[other], seen[other] = there, edge, turn
            heapq.heappush(queue, (there + left[other], -there, other))


@njit(cache=True)
def path_errors(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray, systematic: FloatArray,
    label: IntArray, calibration: FloatArray, landmarks: FloatArray, i: IntArray, j: IntArray, skip: IntArray,
) -> FloatArray:  # fmt: skip
    """Return (n, 3, 3) the errors about the origin along the best path between i and j (n,).

    landmarks (N, K): how far each node is from some of them; K may be 0.
    """
    nodes = len(first) - 1
    variance = heading_variances(random, systematic, calibration)
    reach, left, by, seen = np.empty(nodes), np.empty(nodes), np.empty(nodes, np.int64), np.full(nodes, -1)
    errors, shared = np.zeros((len(i), 3, 3)), np.zeros((3, 3))
    for n in range(len(i)):
        towards(
            first, onward, start, end, label, variance, i[n], j[n], skip[n], landmarks, reach, left, by, seen, n
        )
        shared[:] = 0.0
        node = j[n]
        while node != i[n]:
            edge = by[node]
            errors[n] += random[edge]
            if end[edge] == node:
                shared += systematic[edge]
            else:
                shared -= systematic[edge]
            node = start[edge] + end[edge] - node
        _add_shared(errors[n], shared, calibration)
    return errors


@njit(cache=True)
def distances(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray, systematic: FloatArray,
    label: IntArray, calibration: FloatArray, roots: IntArray,
) -> FloatArray:  # fmt: skip
    """Return (N, K) how far each node is from each root [rad^2]."""
    nodes = len(first) - 1
    variance = heading_variances(random, systematic, calibration)
    reach, by, seen = np.empty(nodes), np.empty(nodes, np.int64), np.full(nodes, -1)
    result = np.empty((nodes, len(roots)))
    for k in range(len(roots)):
        shortest(first, onward, start, end, label, variance, roots[k], -1, NEVER, reach, by, seen, k)
        result[:, k] = reach
    return result


@njit(cache=True)
def _add_shared(errors: FloatArray, shared: FloatArray, calibration: FloatArray) -> None:
    """Add what an unknown calibration does along a path."""
    for p in range(3):
        for q in range(3):
            for k in range(3):
                for m in range(3):
                    errors[p, q] += shared[p, k] * calibration[k, m] * shared[q, m]


@njit(cache=True)
def tree_errors(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray, systematic: FloatArray,
    label: IntArray, calibration: FloatArray, roots: IntArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return for K roots the random and systematic errors (K, N, 3, 3) along the best paths from them to all nodes."""
    nodes = len(first) - 1
    variance = heading_variances(random, systematic, calibration)
    reach, by, seen = np.empty(nodes), np.empty(nodes, np.int64), np.full(nodes, -1)
    errors, shared = np.zeros((len(roots), nodes, 3, 3)), np.zeros((len(roots), nodes, 3, 3))
    for k in range(len(roots)):
        shortest(first, onward, start, end, label, variance, roots[k], -1, NEVER, reach, by, seen, k)
        for node in np.argsort(reach):  # a node's predecessor is nearer to the root than it is
            edge = by[node]
            if edge < 0:
                continue
            before = start[edge] + end[edge] - node
            sign = 1.0 if end[edge] == node else -1.0
            errors[k, node] = errors[k, before] + random[edge]
            shared[k, node] = shared[k, before] + sign * systematic[edge]
    return errors, shared


@njit(cache=True)
def bounds(random: FloatArray, systematic: FloatArray, calibration: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    """Return (n, 3, 3) errors between i and j (n,) by way of that root (K, N, 3, 3) which leaves the least heading."""
    errors = np.empty((len(i), 3, 3))
    for n in range(len(i)):
        best, least = 0, np.inf
        for k in range(len(random)):
            total = random[k, i[n], 2, 2] + random[k, j[n], 2, 2]
            for p in range(3):
                away = systematic[k, j[n], 2, p] - systematic[k, i[n], 2, p]
                total += away * away * calibration[p, p]
            if total < least:
                best, least = k, total
        errors[n] = random[best, i[n]] + random[best, j[n]]
        _add_shared(errors[n], systematic[best, j[n]] - systematic[best, i[n]], calibration)
    return errors
