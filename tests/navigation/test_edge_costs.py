"""What edges cost, and which are shut."""

from __future__ import annotations

import math

import numpy as np
import pytest
from maps import square

from topomap.core.geometry import Pose2
from topomap.mapping.experience import EdgeExperience, Experience
from topomap.mapping.graph import TopoMap
from topomap.navigation.edge_costs import FAILED, MEMORY_S, SHUT_S, Shut, costs, distance_to, edges_of
from topomap.navigation.planner import NoRoute, near, route

NOW = 10**12


def cost(topo: TopoMap, a: int, b: int, stamp_ns: int, *shut: Shut) -> float:
    edges = edges_of(topo)
    there, back = costs(topo, edges, shut, stamp_ns)
    for k, (i, j) in enumerate(edges):
        if (a, b) == (i, j):
            return float(there[k])
        if (a, b) == (j, i):
            return float(back[k])
    raise AssertionError


def test_an_edge_costs_its_length() -> None:
    topo = square()
    assert cost(topo, 1, 2, NOW) == pytest.approx(topo.length(1, 2), abs=1e-5)


def test_a_failure_shuts_an_edge_one_way_then_makes_it_dear_and_is_forgotten() -> None:
    topo = square()
    topo.experience = Experience([EdgeExperience(1, 2, passed=1, failed=1, failed_ns=NOW)])
    good, later = cost(topo, 2, 1, NOW), NOW + round((SHUT_S + 1) * 1e9)
    assert math.isinf(cost(topo, 1, 2, NOW))
    assert good == pytest.approx(topo.length(1, 2), abs=1e-5)
    assert cost(topo, 1, 2, later) - good == pytest.approx(FAILED * 0.5 * (1 - (SHUT_S + 1) / MEMORY_S))
    assert cost(topo, 1, 2, NOW + round((MEMORY_S + 1) * 1e9)) == pytest.approx(good)


def test_passages_make_a_failed_edge_cheaper_again() -> None:
    topo, later = square(), NOW + round((SHUT_S + 1) * 1e9)
    topo.experience.failed(1, 2, NOW)
    dear = cost(topo, 1, 2, later)
    topo.experience.passed(1, 2, 3.0)
    assert cost(topo, 1, 2, later) < dear


def test_a_place_that_is_shut_shuts_all_edges_past_it() -> None:
    topo = square()
    shut = between(topo, 1, 2)
    assert math.isinf(cost(topo, 1, 2, NOW, shut))
    assert math.isinf(cost(topo, 2, 1, NOW, shut))
    assert math.isfinite(cost(topo, 1, 2, NOW + round((SHUT_S + 1) * 1e9), shut))
    assert math.isfinite(cost(topo, 8, 9, NOW, shut))


def between(topo: TopoMap, a: int, b: int) -> Shut:
    """A shut place half-way between two nodes."""
    x, y = 0.5 * (topo.poses[a, :2] + topo.poses[b, :2])
    return Shut(float(x), float(y), NOW)


def test_the_way_round_is_taken_and_a_shut_only_way_is_said() -> None:
    topo = square(8)
    assert route(topo, 28, 0) == [28, 29, 30, 31, 32, 0]
    assert route(topo, 28, 0, (between(topo, 29, 30),), NOW) == list(range(28, -1, -1))
    with pytest.raises(NoRoute, match="from node 28 to node 0: the only way is blocked"):
        route(topo, 28, 0, (between(topo, 29, 30), between(topo, 9, 10)), NOW)


def test_a_nearer_node_is_joined_where_the_way_to_it_is_free() -> None:
    topo = square()
    pose = Pose2(*topo.poses[3, :2], 0.0)
    free = np.full(360, 5.0, np.float32)
    assert near(topo, pose, free)[0] == 3
    assert near(topo, pose, None) == ()
    walled = np.full(360, 0.3, np.float32)
    assert set(near(topo, pose, walled)) == {3}


def test_the_distance_of_a_point_to_segments() -> None:
    a, b = np.array([[0.0, 0.0], [0.0, 0.0]]), np.array([[2.0, 0.0], [0.0, 0.0]])
    assert distance_to(np.array([1.0, 0.5]), a, b) == pytest.approx([0.5, math.hypot(1.0, 0.5)])
    assert distance_to(np.array([3.0, 0.0]), a, b)[0] == pytest.approx(1.0)


def test_the_mean_time_of_an_edge() -> None:
    known = Experience()
    known.passed(0, 1, 2.0)
    known.passed(0, 1, 4.0)
    assert known.of(0, 1) == EdgeExperience(0, 1, passed=2, seconds=3.0)
    assert known.of(1, 0) == EdgeExperience(1, 0)
    assert list(known) == [known.of(0, 1)]


def test_nobody_drives_where_the_robot_was_carried() -> None:
    topo = square(8)
    topo.remove(topo.closures[0])
    assert math.isfinite(cost(topo, 10, 11, NOW))
    topo.place(11, Pose2(*topo.poses[11]) @ Pose2(3.0, 0.0))
    assert math.isinf(cost(topo, 10, 11, NOW))
    assert math.isfinite(cost(topo, 11, 12, NOW))
    topo.place(20, Pose2(*topo.poses[20]) @ Pose2(0.3, 0.0))  # the odometry was set right, the way was driven
    assert math.isfinite(cost(topo, 19, 20, NOW))
