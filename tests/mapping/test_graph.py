"""The map: growing, splitting edges, the trajectory, the hash."""

from __future__ import annotations

import numpy as np
import pytest
from maps import STEP_NS, increments, snapshot, square

from topomap.core.geometry import Pose2, compose
from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.odometry.increments import Calibration, Increments, integrate
from topomap.mapping.optimizer import ClosureEdge


def test_a_new_node_stands_where_odometry_leads() -> None:
    topo = TopoMap()
    topo.add(Node(0, 0.0, snapshot(0)), None)
    topo.add(Node(5 * STEP_NS, 0.5, None), increments(0, 5))
    assert topo.poses[1] == pytest.approx([0.5, 0.0, 0.0])


def test_calibration_is_applied_to_a_new_edge() -> None:
    topo = TopoMap()
    topo.calibration = Calibration(distance_scale=0.5)
    topo.add(Node(0, 0.0, snapshot(0)), None)
    topo.add(Node(5 * STEP_NS, 0.5, None), increments(0, 5))
    assert topo.poses[1, 0] == pytest.approx(1.0)


def test_edges_that_another_odometer_drove_say_the_same_under_a_new_calibration() -> None:
    """What this drive finds of its odometer changes the edges it drove, and no others."""
    topo = square()
    known, found = Calibration(1.04, 0.003, 0.95), Calibration(1.02, -0.002, 0.97)
    topo.calibration = known
    before = [integrate(edge, known) for _, _, edge in topo.odometry_edges()]
    topo.move(topo.poses.copy(), found, others=10)
    after = [integrate(edge, found) for _, _, edge in topo.odometry_edges()]
    for k, (then, now) in enumerate(zip(before, after, strict=True)):
        same = [np.allclose(a, b, atol=1e-9) for a, b in zip(then[:2], now[:2], strict=True)]
        assert all(same) == (k < 10), k
    assert topo.way(3, 4).stamps_ns.tolist() == square().way(3, 4).stamps_ns.tolist()


def test_inserting_splits_the_edge_and_moves_nothing() -> None:
    topo = square()
    before, stamps = topo.trajectory()[1].copy(), topo.trajectory()[0].copy()
    node = topo.insert(7 * STEP_NS)
    assert topo.nodes[node].snapshot is None
    assert topo.chain[1:4] == [1, node, 2]
    assert not topo.graph.has_edge(1, 2)
    assert topo.graph.has_edge(1, node)
    assert topo.trajectory()[0].tolist() == stamps.tolist()
    assert topo.trajectory()[1] == pytest.approx(before)


def test_the_way_between_two_nodes_is_what_was_read_between_them() -> None:
    topo = square()
    whole = [topo.way(k, k + 1) for k in range(16)]
    middle = topo.insert(12 * STEP_NS)
    for a, b in ((3, 9), (0, 16), (15, 16), (1, 4)):
        found = topo.way(a, b)
        expected = Increments.concatenate(whole[a:b])
        assert found.stamps_ns.tolist() == expected.stamps_ns.tolist()
        assert np.array_equal(found.deltas, expected.deltas)
    assert topo.way(2, middle).stamps_ns.tolist() == whole[2].stamps_ns[:2].tolist()


def test_inserting_at_a_node_returns_it() -> None:
    topo = square()
    assert topo.insert(10 * STEP_NS) == 2
    assert len(topo.nodes) == 17


def test_the_trajectory_ends_on_moved_nodes() -> None:
    topo = square()
    moved = compose(np.array([1.0, 2.0, 0.5]), topo.poses) + np.linspace(0, 0.3, 17)[:, None]
    topo.move(moved, topo.calibration)
    stamps, poses = topo.trajectory()
    at = {int(s): p for s, p in zip(stamps, poses, strict=True)}
    for node, pose in zip(topo.nodes, moved, strict=True):
        assert at[node.stamp_ns] == pytest.approx(pose)


def test_the_hash_sees_poses_verdicts_and_closures() -> None:
    topo, same = square(), square()
    assert topo.hash([]) == same.hash([])
    assert topo.hash([(1, 2, "accepted", "x")]) != topo.hash([(1, 2, "refused", "x")])
    before = topo.hash([])
    topo.remove(topo.closures[0])
    opened = topo.hash([])
    topo.poses[3, 0] += 1e-12
    assert len({before, opened, topo.hash([])}) == 3


def test_odometry_stays_where_a_closure_between_neighbours_is_removed() -> None:
    topo = square()
    first, second = (ClosureEdge(1, 2, Pose2(x), np.eye(3)) for x in (0.1, 0.2))
    topo.close(first)
    topo.close(second)
    assert topo.graph.edges[1, 2]["kind"] == "odometry"
    topo.remove(first)
    node = topo.insert(7 * STEP_NS)
    assert topo.graph.edges[1, 2]["kind"] == "closure", "odometry now goes by the new node"
    topo.remove(second)
    assert not topo.graph.has_edge(1, 2)
    assert topo.graph.edges[1, node]["kind"] == "odometry"


def test_of_two_closures_between_two_nodes_one_stays() -> None:
    topo = square()
    for x in (0.1, 0.2):
        topo.close(ClosureEdge(2, 9, Pose2(x), np.eye(3)))
    topo.remove(topo.closures[1])
    assert topo.graph.edges[2, 9]["kind"] == "closure"
    topo.remove(topo.closures[1])
    assert not topo.graph.has_edge(2, 9)


def test_many_nodes_outgrow_the_first_table() -> None:
    assert len(square(50).poses) == 201
    assert square(50).pose(200).distance(Pose2()) < 1.0


def test_a_gap_is_seen_by_whoever_asked_for_the_odometry_before() -> None:
    topo = square()
    before = {(a, b): way for a, b, way in topo.odometry_edges()}
    topo.place(5, topo.pose(5) @ Pose2(3.0, 0.0))
    after = {(a, b): way for a, b, way in topo.odometry_edges()}
    assert before[4, 5].covariances[-1, 0, 0] < 1.0
    assert after[4, 5].covariances[-1, 0, 0] > 1000.0


def test_nodes_that_came_while_the_newest_ones_were_solved_go_along_with_them() -> None:
    topo = square()
    nodes = np.array(topo.chain[-4:])
    moved = topo.poses[nodes] + np.array([0.3, -0.2, 0.1])
    between = topo.insert(int(topo.nodes[nodes[-1]].stamp_ns) - 3 * STEP_NS)
    ways = [topo.pose(a).to(topo.pose(b)).array() for a, b in ((int(nodes[-2]), between),)]
    last = topo.nodes[topo.chain[-1]]
    newest = topo.add(
        Node(last.stamp_ns + 5 * STEP_NS, last.travel + 0.5, None), increments(last.stamp_ns // STEP_NS, 5)
    )
    after = topo.pose(int(nodes[-1])).to(topo.pose(newest)).array()
    topo.shift(nodes, moved)
    assert topo.poses[nodes] == pytest.approx(moved)
    assert topo.pose(int(nodes[-2])).to(topo.pose(between)).array() == pytest.approx(ways[0])
    assert topo.pose(int(nodes[-1])).to(topo.pose(newest)).array() == pytest.approx(after)
