"""Routes over the graph."""

from __future__ import annotations

import pytest
from maps import STEP_NS, increments, square

from topomap.core.errors import TopomapError
from topomap.mapping.graph import Node
from topomap.navigation.course import Course
from topomap.navigation.planner import route


def test_a_closure_shortens_the_way_home() -> None:
    topo = square()
    assert route(topo, 14, 0) == [14, 15, 16, 0]
    topo.remove(topo.closures[0])
    assert route(topo, 14, 0) == list(range(14, -1, -1))


def test_pose_nodes_are_passed_but_no_milestones() -> None:
    topo = square()
    new = topo.insert(7 * STEP_NS)
    path = route(topo, 0, 3)
    assert new in path
    assert [path[k] for k in Course(topo, path).milestones] == [0, 1, 2, 3]


def test_an_unknown_or_unconnected_node_is_named() -> None:
    topo = square()
    with pytest.raises(
        TopomapError, match="no route from node 0 to node 99: there is no node 99, the map's nodes are 0 to 16"
    ):
        route(topo, 0, 99)
    lonely = topo.add(Node(10**12, 0.0, None), increments(90, 1), jump=True)
    with pytest.raises(TopomapError, match=f"to node {lonely}"):
        route(topo, 0, lonely)
