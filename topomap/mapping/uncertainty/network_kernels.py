"""Shortest paths through a network of odometry and closures, compiled."""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray

NEVER = -1  # the label of odometry, which every path may use
LEAST = 1e-15  # variance of heading [rad^2] that any edge has: without it there are no shortest paths
SIGNPOSTS = 4  # landmarks that a search looks at: more show little more and cost a look each


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


class _Room(NamedTuple):
    """What a search fills in: reach (N,) [rad^2], the variance of heading on the way to a node; left (N,), what is left
    from it at least; by (N,), the edge by which it is reached; own (N,) and turned (N, 3), the way's own variance and
    what a calibration does to its heading; seen (N,): the search that has filled in the others.
    """

    reach: FloatArray
    left: FloatArray
    by: IntArray
    own: FloatArray
    turned: FloatArray
    seen: IntArray


@njit(cache=True)
def _room(nodes: int) -> _Room:
    return _Room(
        np.empty(nodes), np.empty(nodes), np.empty(nodes, np.int64), np.empty(nodes), np.empty((nodes, 3)),
        np.full(nodes, -1),
    )  # fmt: skip


@njit(cache=True)
def _on(
    room: _Room, random: FloatArray, systematic: FloatArray, calibration: FloatArray, node: int, edge: int, sign: float,
    turned: FloatArray,
) -> float:  # fmt: skip
    """Return the variance of heading [rad^2] beyond an edge; turned (3,) is filled in: what a calibration does adds up
    with its sign.
    """
    total = room.own[node] + max(random[edge, 2, 2], LEAST)
    for p in range(3):
        turned[p] = room.turned[node, p] + sign * systematic[edge, 2, p]
    for p in range(3):
        for q in range(3):
            total += turned[p] * calibration[p, q] * turned[q]
    return float(total)


@njit(cache=True)
def search(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray, systematic: FloatArray,
    label: IntArray, calibration: FloatArray, source: int, target: int, skip: int, landmarks: FloatArray, room: _Room,
    turn: int,
) -> None:  # fmt: skip
    """Fill in the room from a source up to a target (-1: everywhere), mostly in its direction (A*, Goldberg 2005).

    Edges labelled skip are closed; landmarks (N, K): how far each node is from some. With an unsure calibration the
    least variance isn't a sum of edges', and the way found needn't be the best.
    """
    reach, left, by, seen = room.reach, room.left, room.by, room.seen
    chosen = np.empty(min(SIGNPOSTS, landmarks.shape[1]), np.int64)
    turned, sure = np.zeros(3), not calibration.any()
    if len(chosen):
        _signposts(landmarks, source, target, chosen)
    reach[source], by[source], seen[source] = 0.0, -1, turn
    room.own[source], room.turned[source] = 0.0, 0.0
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
            if sure:
                there = here + max(random[edge, 2, 2], LEAST)
            else:
                sign = 1.0 if end[edge] == other else -1.0
                there = _on(room, random, systematic, calibration, node, edge, sign, turned)
            there = max(there, np.nextafter(here, np.inf))  # `tree_errors` needs it to grow
            if seen[other] != turn:
                left[other] = _left(landmarks, chosen, other, target)
            elif there >= reach[other]:
                continue
            reach[other], by[other], seen[other] = there, edge, turn
            if not sure:
                room.own[other], room.turned[other] = room.own[node] + max(random[edge, 2, 2], LEAST), turned
            heapq.heappush(queue, (there + left[other], -there, other))


@njit(cache=True)
def path_errors(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray, systematic: FloatArray,
    label: IntArray, calibration: FloatArray, landmarks: FloatArray, i: IntArray, j: IntArray, skip: IntArray,
) -> FloatArray:  # fmt: skip
    """Return (n, 3, 3) the errors about the origin along the best path between i and j (n,).

    landmarks (N, K): how far each node is from some of them; K may be 0.
    """
    room = _room(len(first) - 1)
    errors, shared = np.zeros((len(i), 3, 3)), np.zeros((3, 3))
    for n in range(len(i)):
        search(
            first, onward, start, end, random, systematic, label, calibration, i[n], j[n], skip[n], landmarks, room, n
        )
        shared[:] = 0.0
        node = j[n]
        while node != i[n]:
            edge = room.by[node]
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
    room, none = _room(len(first) - 1), np.empty((len(first) - 1, 0))
    result = np.empty((len(first) - 1, len(roots)))
    for k in range(len(roots)):
        search(first, onward, start, end, random, systematic, label, calibration, roots[k], -1, NEVER, none, room, k)
        result[:, k] = room.reach
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
    room, none = _room(nodes), np.empty((nodes, 0))
    errors, shared = np.zeros((len(roots), nodes, 3, 3)), np.zeros((len(roots), nodes, 3, 3))
    for k in range(len(roots)):
        search(first, onward, start, end, random, systematic, label, calibration, roots[k], -1, NEVER, none, room, k)
        for node in np.argsort(room.reach):  # a node's predecessor is nearer to the root than it is
            edge = room.by[node]
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
