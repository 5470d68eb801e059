"""What the best paths through a network of odometry and closures know, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.uncertainty.network_search import NEVER, room_of, search


@njit(cache=True)
def path_errors(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray, systematic: FloatArray,
    label: IntArray, calibration: FloatArray, landmarks: FloatArray, i: IntArray, j: IntArray, skip: IntArray,
) -> FloatArray:  # fmt: skip
    """Return (n, 3, 3) the errors about the origin along the best path between i and j (n,).

    landmarks (N, K): how far each node is from some of them; K may be 0.
    """
    room = room_of(first, onward, start, end, random)
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
    room, none = room_of(first, onward, start, end, random), np.empty((len(first) - 1, 0))
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
    room, none = room_of(first, onward, start, end, random), np.empty((nodes, 0))
    errors, shared = np.zeros((len(roots), nodes, 3, 3)), np.zeros((len(roots), nodes, 3, 3))
    for k in range(len(roots)):
        search(first, onward, start, end, random, systematic, label, calibration, roots[k], -1, NEVER, none, room, k)
        for node in np.argsort(room.reach):  # a node's predecessor is nearer to the root than it is
            edge = room.by[node]
            if edge < 0:
                continue
            before = start[edge] + end[edge] - node
            sign = 1.0 if end[edge] == node else -1.0
            for p in range(3):
                for q in range(3):
                    errors[k, node, p, q] = errors[k, before, p, q] + random[edge, p, q]
                    shared[k, node, p, q] = shared[k, before, p, q] + sign * systematic[edge, p, q]
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
