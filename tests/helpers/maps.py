"""Small maps for tests: a square route with made-up snapshots."""

from __future__ import annotations

import numpy as np

from topomap.core.geometry import Pose2
from topomap.core.recorded import RecordedRig
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.odometry.increments import Increments
from topomap.mapping.optimizer.problem import ClosureEdge

RIG = RecordedRig(72, 10, 4.5, 72 / (2 * np.pi), 0.6, 36, True)
STEP_NS = 250_000_000


def increments(first: int, count: int, turn: float = 0.0) -> Increments:
    """`count` steps of 0.1 m from step `first` on, each turning by `turn` [rad]."""
    stamps = (np.arange(first, first + count) + 1) * STEP_NS
    deltas = np.tile([0.1, 0.0, turn], (count, 1))
    return Increments(stamps, deltas, np.tile(np.diag([1e-4, 1e-6, 1e-4]), (count, 1, 1)))


def snapshot(number: int) -> Snapshot:
    return Snapshot(f"image {number}".encode(), np.full(72, float(number), np.float32), RIG)


def square(per_side: int = 4) -> TopoMap:
    """A closed square of 0.5 m edges that turns left at each corner, closed at the end."""
    topo = TopoMap()
    topo.add(Node(0, 0.0, snapshot(0)), None)
    for k in range(1, 4 * per_side + 1):
        turn = np.pi / 10 if k % per_side == 0 else 0.0
        topo.add(Node(5 * k * STEP_NS, 0.5 * k, snapshot(k)), increments(5 * (k - 1), 5, turn))
    topo.close(ClosureEdge(0, 4 * per_side, Pose2(), np.diag([0.1, 0.1, 0.01])))
    return topo
