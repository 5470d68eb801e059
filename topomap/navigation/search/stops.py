"""The snapshots that a robot would pass, had it stood at a pose of the map: the nearest first, each with its way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2, wrap
from topomap.mapping.graph import TopoMap
from topomap.navigation.edge_costs import costs, edges_of

FAR = 25.0
"""[m] How far ways are followed: a search gives up after 30 m."""
MOST = 60
"""Stops at most: FAR in two directions and a branch or two."""
SPACING = 0.8
"""[m] Between stops: over less the views hardly differ."""
JOIN = 1.0
"""[m] Nodes this near the pose are where ways begin."""
FIRST = 1.2
"""[m] A way's direction is that of its first node so far off: nearer ones lie beside the robot."""
SAME_WAY = 0.9
"""[rad] Directions nearer than this are one way: a branch turns off by more."""


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """A snapshot node on a way: how far it is [m], which of the directions the way sets out in, and the way's nodes."""

    node: int
    way: float
    direction: int
    path: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Stops:
    """Stops, the nearest first; bearings (D,) [rad]: in which the ways set out, seen from the pose."""

    stops: tuple[Stop, ...]
    bearings: FloatArray


def stops_from(topo: TopoMap, snapshots: IntArray, here: Pose2) -> Stops:
    """Return where the ways of the map lead from a pose.

    snapshots (n,): nodes known to lie where the map has them; what came behind the last of them on the chain is no way.
    """
    way, before = _ways(topo, snapshots, here)
    straight = np.hypot(topo.poses[:, 0] - here.x, topo.poses[:, 1] - here.y)
    order = [int(node) for node in np.argsort(way, kind="stable") if np.isfinite(way[node])]
    first, bearings, found, taken = dict[int, int](), list[float](), list[Stop](), list[int]()
    views = set(snapshots.tolist())
    for node in order:
        first[node] = first.get(int(before[node]), -1)
        if first[node] < 0 and straight[node] >= FIRST:
            first[node] = node
        if first[node] < 0 or node not in views or _taken(topo.poses, node, taken):
            continue
        taken.append(node)
        direction = _direction(bearings, here.bearing_to(topo.pose(first[node])))
        found.append(Stop(node, float(max(way[node], straight[node])), direction, _path(before, node)))
        if len(found) == MOST:
            break
    return Stops(tuple(found), np.array(bearings))


def _ways(topo: TopoMap, snapshots: IntArray, here: Pose2) -> tuple[FloatArray, IntArray]:
    """Return the way (N,) [m] to each node along the map, infinite beyond FAR, and the node before it (N,)."""
    known = np.zeros(len(topo.nodes), bool)
    place = {node: k for k, node in enumerate(topo.chain)}
    known[topo.chain[: max(place[node] for node in snapshots.tolist()) + 1]] = True
    edges = edges_of(topo)
    there, back = costs(topo, edges, (), 0)
    both = known[edges].all(axis=1)
    rows, columns = np.r_[edges[both, 0], edges[both, 1]], np.r_[edges[both, 1], edges[both, 0]]
    prices = np.r_[there[both], back[both]]
    open_ = np.isfinite(prices)
    graph = csr_array((prices[open_], (rows[open_], columns[open_])), shape=(len(known), len(known)))
    way, before, _ = dijkstra(
        graph, indices=_begin(topo, known, here), return_predecessors=True, min_only=True, limit=FAR
    )
    return np.asarray(way), np.asarray(before, np.int64)


def _begin(topo: TopoMap, known: BoolArray, here: Pose2) -> IntArray:
    away = np.where(known, np.hypot(topo.poses[:, 0] - here.x, topo.poses[:, 1] - here.y), np.inf)
    near = np.flatnonzero(away <= JOIN)
    return near if len(near) else np.array([int(np.argmin(away))])


def _taken(poses: FloatArray, node: int, taken: list[int]) -> bool:
    """Return whether a stop lies at a node's place already: a way that was driven twice is one."""
    return bool((np.hypot(*(poses[taken, :2] - poses[node, :2]).T) < SPACING).any())


def _direction(bearings: list[float], bearing: float) -> int:
    """Return which of the directions a bearing is; a new one is added."""
    off = [abs(wrap(bearing - known)) for known in bearings]
    if off and min(off) < SAME_WAY:
        return int(np.argmin(off))
    bearings.append(bearing)
    return len(bearings) - 1


def _path(before: IntArray, node: int) -> tuple[int, ...]:
    path = [node]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return tuple(reversed(path))
