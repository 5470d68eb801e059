"""The search for a best path through a network of odometry and closures, compiled."""

from __future__ import annotations

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


class Room(NamedTuple):
    """What a search fills in: reach (N,) [rad^2], the variance of heading on the way to a node; left (N,), what is left
    from it at least; by (N,), the edge by which it is reached; own (N,) and turned (N, 3), the way's own variance and
    what a calibration does to its heading; seen (N,): the search that has filled in the others; queue (Q, 2),
    queued (Q,): a binary heap of nodes with what their way is at least and minus what of it is gone, Q more than N.

    And what it looks at most, side by side in memory: beyond, cost (2 E,): of each node's edges the node beyond and the
    variance of heading [rad^2].
    """

    reach: FloatArray
    left: FloatArray
    by: IntArray
    own: FloatArray
    turned: FloatArray
    seen: IntArray
    queue: FloatArray
    queued: IntArray
    beyond: IntArray
    cost: FloatArray


@njit(cache=True)
def room_of(first: IntArray, onward: IntArray, start: IntArray, end: IntArray, random: FloatArray) -> Room:
    """Return room for searches in a network (`Edges`)."""
    nodes, queue = len(first) - 1, 2 * len(start) + 1
    beyond, cost = np.empty(len(onward), np.int64), np.empty(len(onward))
    for node in range(nodes):
        for k in range(first[node], first[node + 1]):
            edge = onward[k]
            beyond[k], cost[k] = start[edge] + end[edge] - node, max(random[edge, 2, 2], LEAST)
    return Room(
        np.empty(nodes), np.empty(nodes), np.empty(nodes, np.int64), np.empty(nodes), np.empty((nodes, 3)),
        np.full(nodes, -1), np.empty((queue, 2)), np.empty(queue, np.int64), beyond, cost,
    )  # fmt: skip


@njit(cache=True)
def _push(queue: FloatArray, queued: IntArray, size: int, least: float, gone: float, node: int) -> None:
    """Put a node into the heap of so many others: a list of tuples with `heapq` takes twice as long."""
    k = size
    while k > 0:
        above = (k - 1) // 2
        if (queue[above, 0], queue[above, 1], queued[above]) <= (least, gone, node):
            break
        queue[k, 0], queue[k, 1], queued[k] = queue[above, 0], queue[above, 1], queued[above]
        k = above
    queue[k, 0], queue[k, 1], queued[k] = least, gone, node


@njit(cache=True)
def _drop(queue: FloatArray, queued: IntArray, size: int) -> None:
    """Take the first node out of the heap of so many."""
    last = size - 1
    least, gone, node = queue[last, 0], queue[last, 1], queued[last]
    k = 0
    while 2 * k + 1 < last:
        below = 2 * k + 1
        right = below + 1
        if right < last and (queue[right, 0], queue[right, 1], queued[right]) < (
            queue[below, 0], queue[below, 1], queued[below],
        ):  # fmt: skip
            below = right
        if (least, gone, node) <= (queue[below, 0], queue[below, 1], queued[below]):
            break
        queue[k, 0], queue[k, 1], queued[k] = queue[below, 0], queue[below, 1], queued[below]
        k = below
    queue[k, 0], queue[k, 1], queued[k] = least, gone, node


@njit(cache=True)
def _purged(queue: FloatArray, queued: IntArray, reach: FloatArray) -> int:
    """Take out of a full heap those for which a shorter way was found; return how many are left, one a node at most."""
    left = 0
    for k in range(len(queued)):
        if -queue[k, 1] <= reach[queued[k]]:
            _push(queue, queued, left, queue[k, 0], queue[k, 1], queued[k])
            left += 1
    return left


@njit(cache=True)
def _on(
    room: Room, random: FloatArray, systematic: FloatArray, calibration: FloatArray, node: int, edge: int, sign: float,
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
    label: IntArray, calibration: FloatArray, source: int, target: int, skip: int, landmarks: FloatArray, room: Room,
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
    queue, queued = room.queue, room.queued
    queue[0, 0], queue[0, 1], queued[0], waiting = left[source], 0.0, source, 1
    while waiting:
        here, node = -queue[0, 1], queued[0]
        if node == target:
            return
        _drop(queue, queued, waiting)
        waiting -= 1
        if here > reach[node]:
            continue
        for k in range(first[node], first[node + 1]):
            edge, other = onward[k], room.beyond[k]
            if skip >= 0 and label[edge] == skip:
                continue
            if sure:
                there = here + room.cost[k]
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
                room.own[other], room.turned[other] = room.own[node] + room.cost[k], turned
            if waiting == len(queued):
                waiting = _purged(queue, queued, reach)
            _push(queue, queued, waiting, there + left[other], -there, other)
            waiting += 1
