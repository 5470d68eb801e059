"""Which junctions a best path leads over, and what is known along it, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, Int32Array, IntArray
from topomap.mapping.uncertainty.network_search import NEVER, room_of, search


@njit(cache=True)
def by_junctions(
    variance: FloatArray, places: IntArray, apart: FloatArray, i: IntArray, j: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the first and the last junction (n,) of the best path between i and j (n,), -1 where it is the chain.

    variance (N,): of the heading along the chain, summed [rad^2]; places (J,): the junctions, in travel order; apart
    (J, J): the variance between any two.
    """
    first, last = np.full(len(i), -1), np.full(len(i), -1)
    for n in range(len(i)):
        here, there = np.searchsorted(places, i[n]), np.searchsorted(places, j[n])
        least = abs(variance[i[n]] - variance[j[n]])
        for a in range(max(here - 1, 0), min(here + 1, len(places))):
            begun = abs(variance[i[n]] - variance[places[a]])
            for b in range(max(there - 1, 0), min(there + 1, len(places))):
                total = begun + apart[a, b] + abs(variance[j[n]] - variance[places[b]])
                if total < least:
                    least, first[n], last[n] = total, a, b
    return first, last


@njit(cache=True)
def trees(
    first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray
) -> tuple[FloatArray, Int32Array]:
    """Return from each node of a network (`Edges`) to each other the variance of heading along the best path (J, J)
    [rad^2], and the edge (J, J) that it ends with, -1 for none.
    """
    nodes = len(first) - 1
    room, none, sure = room_of(first, onward, start, end, random), np.empty((nodes, 0)), np.zeros((3, 3))
    label = np.full(len(start), NEVER)
    apart, by = np.empty((nodes, nodes)), np.empty((nodes, nodes), np.int32)
    for root in range(nodes):
        search(first, onward, start, end, random, random, label, sure, root, -1, NEVER, none, room, root)
        apart[root], by[root] = room.reach, room.by
    return apart, by


@njit(cache=True)
def way_errors(
    start: IntArray, end: IntArray, random: FloatArray, by: Int32Array, i: IntArray, j: IntArray
) -> FloatArray:  # fmt: skip
    """Return (n, 3, 3) the random errors along the best path between i and j (n,), by `trees`."""
    errors = np.zeros((len(i), 3, 3))
    for n in range(len(i)):
        node = j[n]
        while node != i[n]:
            edge = by[i[n], node]
            errors[n] += random[edge]
            node = start[edge] + end[edge] - node
    return errors
