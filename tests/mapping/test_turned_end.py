"""The newest node lies where its measured turn says, as soon as it is measured and as surely as the map claims."""

from __future__ import annotations

import numpy as np
import pytest
from maps import STEP_NS, square

from topomap.core.geometry import between
from topomap.mapping.graph import TopoMap
from topomap.mapping.optimizer import Closures, Problem, solve
from topomap.mapping.optimizer.problem import TurnEdge
from topomap.mapping.turned_end import turned_end
from topomap.mapping.uncertainty.incremental_chain import IncrementalChain


def solved(topo: TopoMap, turn: TurnEdge) -> np.ndarray:
    """Where a solve of the whole map with this turn has the nodes, the odometry's systematic errors known."""
    known = topo.calibration
    return solve(
        Problem(topo.poses.copy(), topo.odometry(), Closures.of([]), (turn,), known, known, (1e-6, 1e-6, 1e-6))
    ).poses


@pytest.mark.parametrize("off", [0.02, -0.1])
@pytest.mark.parametrize("split", [False, True])
def test_the_end_lies_where_a_solve_of_all_would_have_it(off: float, split: bool) -> None:
    topo = square()
    a, b = topo.chain[-2:]
    if split:
        topo.insert(topo.nodes[a].stamp_ns + 2 * STEP_NS)
    read = topo.pose(b).heading - topo.pose(a).heading
    turn = TurnEdge(a, b, read + off, 0.01)
    expected = solved(topo, turn)
    nodes, poses = turned_end(topo, turn, np.zeros((3, 3)))
    assert abs(poses[-1, 2] - topo.poses[b, 2] - off) < 0.3 * abs(off)
    topo.shift(nodes, poses)
    assert np.abs(between(expected, topo.poses)).max() < 0.02 * abs(off)  # a solve's edges are never quite stiff


def test_the_turns_of_a_map_count_as_soon_as_they_are_measured() -> None:
    topo, unknown = square(), np.diag(np.square([0.05, 0.01, 0.01]))
    chain = IncrementalChain(topo, topo.turns)
    first, last = np.array([topo.chain[-2]]), np.array([topo.chain[-1]])
    before = chain.current(unknown).covariance(first, last)[0]
    topo.turns.append(TurnEdge(int(first[0]), int(last[0]), 0.1, 0.001))
    after = chain.current(unknown).covariance(first, last)[0]
    assert after[2, 2] < 0.05 * before[2, 2]


@pytest.mark.parametrize("whole", [False, True])
def test_what_came_while_older_nodes_were_solved_keeps_its_measured_turns(whole: bool) -> None:
    """A large map's solve takes many steps; nodes of the meantime lay as odometry had them when it was applied."""
    topo = square()
    a, b = topo.chain[-2:]
    old, moved = topo.poses[:a].copy(), [0.3, 0.2, 0.0]
    turn = TurnEdge(a, b, topo.pose(b).heading - topo.pose(a).heading + 0.1, 0.001)
    topo.shift(*turned_end(topo, turn, np.zeros((3, 3))))
    then = between(topo.poses[a], topo.poses[b])
    if whole:
        topo.move(old + moved, topo.calibration)
    else:
        topo.shift(np.arange(4, a), old[4:] + moved)
    assert between(topo.poses[a], topo.poses[b]) == pytest.approx(then)
    assert topo.poses[a - 1] == pytest.approx(old[-1] + moved)
