"""Routes over the snapshot graph: the cheapest way to a node, from wherever the robot is."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from topomap.core.arrays import Float32Array, FloatArray, IntArray
from topomap.core.errors import TopomapError
from topomap.core.geometry import TAU, Pose2
from topomap.mapping.graph import TopoMap
from topomap.navigation.edge_costs import Shut, costs, distance_to, edges_of

JOIN = 1.0
"""[m] Nodes this near may be joined straight away, where ranges show that the way to them is free."""
BODY = 0.25
"""[m] The way to a node is free where nothing is measured nearer to it than this."""


class NoRoute(TopomapError):
    """There is no way from here to the goal."""


def route(
    topo: TopoMap, start: int, goal: int, shut: tuple[Shut, ...] = (), stamp_ns: int = 0, joins: tuple[int, ...] = ()
) -> list[int]:
    """Return all nodes on the cheapest way from `start`, or one of `joins`, to `goal`, both ends included.

    joins: other nodes near the robot that it may begin at, where that is cheaper. Raises TopomapError when a node is
    unknown or the two are not connected.
    """
    known = range(len(topo.nodes))
    if start not in known or goal not in known:
        wrong = start if start not in known else goal
        told = f"the map's nodes are 0 to {len(known) - 1}" if known else "the map is empty"
        raise NoRoute(f"no route from node {start} to node {goal}: there is no node {wrong}, {told}")
    left, onward = _to_goal(topo, goal, shut, stamp_ns)
    first = min((start, *joins), key=lambda node: (left[node] + topo.length(start, node), node))
    if not np.isfinite(left[first]):
        raise NoRoute(f"no route from node {start} to node {goal}: {_why(topo, start, goal)}")
    path = [first]
    while path[-1] != goal:
        path.append(int(onward[path[-1]]))
    return path


def near(topo: TopoMap, pose: Pose2, ranges: Float32Array | None, shut: tuple[Shut, ...] = ()) -> tuple[int, ...]:
    """Return the nodes within JOIN of a pose to which the measured ranges (W,) leave the way free, nearest first."""
    if ranges is None:
        return ()
    away = np.hypot(topo.poses[:, 0] - pose.x, topo.poses[:, 1] - pose.y)
    close = [int(node) for node in np.argsort(away, kind="stable")[:24] if away[node] < JOIN]
    return tuple(node for node in close if _is_free(pose, topo.pose(node), ranges, shut))


def _is_free(here: Pose2, there: Pose2, ranges: Float32Array, shut: tuple[Shut, ...]) -> bool:
    way = here.distance(there)
    if way < 0.05:
        return True
    angles = np.arange(len(ranges)) * TAU / len(ranges) - here.bearing_to(there)
    along, aside = ranges * np.cos(angles), np.abs(ranges * np.sin(angles))
    a, b = np.array([[here.x, here.y]]), np.array([[there.x, there.y]])
    passes = any(float(distance_to(np.array([s.x, s.y]), a, b)[0]) < BODY for s in shut)
    return not passes and not bool(((aside < BODY) & (along > 0) & (along < way)).any())


def _to_goal(topo: TopoMap, goal: int, shut: tuple[Shut, ...], stamp_ns: int) -> tuple[FloatArray, IntArray]:
    """Return the cost [m] from each node to the goal, and the next node on that way."""
    edges, count = edges_of(topo), len(topo.nodes)
    there, back = costs(topo, edges, shut, stamp_ns)
    # dijkstra runs from the goal: the row of b holds what driving from a to b costs
    rows, columns = np.r_[edges[:, 1], edges[:, 0]], np.r_[edges[:, 0], edges[:, 1]]
    prices = np.r_[there, back]
    open_ = np.isfinite(prices)
    graph = csr_array((prices[open_], (rows[open_], columns[open_])), shape=(count, count))
    left, onward = dijkstra(graph, indices=np.array([goal]), return_predecessors=True)
    return left[0], onward[0].astype(np.int64)


def _why(topo: TopoMap, start: int, goal: int) -> str:
    left, _ = _to_goal(topo, goal, (), 1 << 62)
    return "the only way is blocked" if np.isfinite(left[start]) else "nothing joins them"
