"""A gap in the odometry: what lies behind it is moved as a whole, and what the odometry says of it is set."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.core.records import Motion
from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.odometry.gap import GAP, bridged
from topomap.mapping.odometry.increments import Calibration, Increments, integrate

READ = Calibration(1.04, 0.01, 0.95)


def increments(first: int, count: int = 5) -> Increments:
    motion = Motion(0.1, 0.0, 0.05, 1e-4 * np.eye(3), 0.25)
    return Increments.of([first + k for k in range(count)], [motion] * count)


def chain() -> TopoMap:
    topo = TopoMap()
    topo.calibration = READ
    topo.add(Node(0, 0.0, None), None)
    for k in range(4):
        topo.add(Node(5 * (k + 1), 0.5 * (k + 1), None), increments(5 * k + 1))
    return topo


@pytest.mark.parametrize("target", [Pose2(3.0, -2.0, 2.5), Pose2(0.2, 0.0, -3.0), Pose2(-7.0, 1.0, 0.0)])
def test_a_bridged_edge_leads_to_the_target_by_any_calibration(target: Pose2) -> None:
    edge = bridged(increments(1), READ, target)
    delta, covariance, _ = integrate(edge, READ)
    assert delta == pytest.approx(target.array(), abs=1e-9)
    assert covariance[0, 0] > 0.5 * GAP[0, 0]
    assert np.array_equal(edge.deltas[:-1], increments(1).deltas[:-1])


def test_what_lies_behind_is_moved_as_a_whole_and_odometry_leads_there() -> None:
    topo = chain()
    before = topo.poses.copy()
    topo.place(2, Pose2(10.0, 5.0, math.pi / 2))
    assert np.array_equal(topo.poses[:2], before[:2])
    assert topo.poses[2] == pytest.approx([10.0, 5.0, math.pi / 2])
    for a, b in ((2, 3), (3, 4)):
        was = Pose2.of(before[a]).to(Pose2.of(before[b])).array()
        assert topo.pose(a).to(topo.pose(b)).array() == pytest.approx(was)
    at = topo.pose(0)
    for a, b, edge in topo.odometry_edges():
        at = at @ Pose2.of(integrate(edge, READ)[0])
        assert at.array() == pytest.approx(topo.poses[b], abs=1e-9), (a, b)
