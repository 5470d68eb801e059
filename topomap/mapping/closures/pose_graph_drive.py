"""A pose graph as the engine takes it: its odometry as a drive, its closures as claims."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.drive import Drive
from topomap.mapping.odometry.increments import EdgeIncrements
from topomap.mapping.optimizer import OdometryEdges
from topomap.mapping.pose_graph import PoseGraph


def drive_of(graph: PoseGraph, factor: float = 1.0) -> Drive:
    """Return the graph's odometry as a drive, its covariances times a factor."""
    return Drive(graph.dead_reckoning(), odometry_edges(graph, factor))


def claims_of(graph: PoseGraph, factor: float = 1.0) -> tuple[Claims, IntArray]:
    """Return the graph's closures as claims in order of i, then j, and each one's place (M,) in the graph."""
    order = np.lexsort((graph.j, graph.i))
    covariance = factor * graph.covariance[order]
    return Claims.of(graph.i[order], graph.j[order], graph.relative[order], covariance), order


def odometry_edges(graph: PoseGraph, factor: float = 1.0) -> OdometryEdges:
    """Return the graph's odometry as increments, one an edge, laid as an arc, with covariances times a factor."""
    half = graph.odometry[:, 2] / 2
    c, s = np.cos(half), np.sin(half)
    x, y = graph.odometry[:, 0], graph.odometry[:, 1]
    deltas = np.column_stack([c * x + s * y, c * y - s * x, graph.odometry[:, 2]])
    carry = np.zeros((len(half), 3, 3))  # what the arc does to the increment's noise, undone below
    carry[:, 0, 0], carry[:, 0, 1], carry[:, 1, 0], carry[:, 1, 1], carry[:, 2, 2] = c, -s, s, c, 1.0
    carry[:, 0, 2], carry[:, 1, 2] = -y / 2, x / 2
    undo = np.linalg.inv(carry)
    covariances = factor * undo @ graph.odometry_covariance @ undo.transpose(0, 2, 1)
    place = np.arange(graph.nodes)
    return OdometryEdges(place[:-1], place[1:], EdgeIncrements(deltas, np.ascontiguousarray(covariances), place))
