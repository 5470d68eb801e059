"""What adds nothing is left out, and everything else stays as it was."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from maps import RIG, increments

from topomap.core.encoded import encode
from topomap.core.geometry import Pose2
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.mapfile import from_bytes, to_bytes
from topomap.mapping.odometry.increments import Increments
from topomap.mapping.optimizer.problem import ClosureEdge
from topomap.mapping.sessions.prune import prune
from topomap.mapping.sessions.rebuild import only

STEPS = 40
"""Snapshots of a lap, 0.5 m apart, on a circle: equal steps and turns."""
SPOT = np.diag([0.01, 0.01, 0.001])


def view(number: int) -> Snapshot:
    """A view of its own for each number, blurred as places are."""
    noise = np.random.default_rng(number).integers(0, 256, (RIG.height, RIG.width, 1), np.uint8)
    return Snapshot(encode(np.repeat(noise, 3, axis=2)), None, RIG)


def laps(count: int, places: int = STEPS, closed: bool = True) -> TopoMap:
    """So many laps of a circle; each place looks the same in each lap; every fourth is closed to the first lap."""
    topo = TopoMap()
    for k in range(count * places):
        way = increments(5 * (k - 1), 5, math.tau / places / 5) if k else None
        topo.add(Node(5 * k * 250_000_000, 0.5 * k, view(k % places)), way)
        if k >= places and k % 4 == 0 and closed:
            topo.close(ClosureEdge(k % places, k, Pose2(), SPOT))
    return topo


def spread(way: Increments, step: float) -> Increments:
    """The same turns with steps of another length [m]."""
    return replace(way, deltas=way.deltas * [step / 0.1, 1.0, 1.0])


def test_laps_on_known_ground_are_left_out() -> None:
    topo = laps(1)
    for count in (2, 4):
        pruned = prune(laps(count)).map
        assert len(pruned.nodes) - len(topo.nodes) <= 1, "the closure that ends the first lap"
    size = len(to_bytes(prune(laps(4)).map)) / len(to_bytes(prune(laps(2)).map))
    assert size < 1.02


def test_a_lap_whose_views_lie_midway_between_those_of_the_first_is_left_out() -> None:
    """A metre and the step that fills it lie between snapshots: 0.55 m is half of that, and the map grew by it."""
    topo, places = TopoMap(), 40
    for k in range(4 * places):
        way = increments(5 * (k - 1), 5, math.tau / places / 10) if k else None
        before, seen = k < 2 * places, k % 2 == 0 if k < 2 * places else k % 2 == 1
        shown = view((k % (2 * places)) // 2) if seen else None
        topo.add(Node(5 * k * 250_000_000, 0.55 * k, shown), spread(way, 0.11) if way else None)
        if not before and k % 4 == 0:
            topo.close(ClosureEdge(k - 2 * places, k, Pose2(), SPOT))
    pruned = prune(topo).map
    assert sum(node.snapshot is not None for node in pruned.nodes) <= places + 1


def test_numbers_poses_and_places_stay() -> None:
    topo = laps(2)
    topo.places = {"desk": 3, "again": STEPS + 11}
    pruned, gone = prune(topo)
    assert set(gone) | set(pruned.names) == set(topo.names)
    assert not set(gone) & set(pruned.names)
    for node, name in enumerate(pruned.names):
        assert pruned.poses[node].tolist() == topo.poses[name].tolist()
        assert pruned.nodes[node].stamp_ns == topo.nodes[name].stamp_ns
    assert pruned.places == topo.places
    assert pruned.node_named(STEPS + 11) is not None
    assert to_bytes(from_bytes(to_bytes(pruned))) == to_bytes(pruned)


def test_numbers_that_were_left_out_are_given_to_no_other_node() -> None:
    """The places of a map are named by them, in notes and logs as well, when the last of them is long gone."""
    whole = laps(2)
    pruned, gone = prune(whole)
    assert max(gone) > max(pruned.names), "the end of the drive is left out"
    kept = from_bytes(to_bytes(pruned))
    for topo in (pruned, kept, only(kept, set(range(5)), set())):
        name = topo.names[topo.add(Node(10**12, 99.0, None), increments(10**4, 1))]
        assert name == len(whole.nodes)


def test_pruned_again_nothing_changes() -> None:
    once = prune(laps(3)).map
    again = prune(once)
    assert again.gone == ()
    assert to_bytes(again.map) == to_bytes(once)


def test_new_ground_behind_known_ground_can_be_reached() -> None:
    topo = laps(2)
    last = 2 * STEPS
    for k in range(8):  # on, out of the circle
        topo.add(
            Node(5 * (last + k) * 250_000_000, 0.5 * (last + k), view(1000 + k)), increments(5 * (last + k - 1), 5)
        )
    pruned = prune(topo).map
    first, end = pruned.node_named(0), pruned.node_named(last + 7)
    assert end is not None
    path = nx.shortest_path(pruned.graph, first, end)
    ways = [pruned.length(a, b) for a, b in pairwise(path)]
    assert max(ways) < 0.8, "no step of the way leads through what was left out"


def test_without_a_closure_nothing_says_that_it_is_the_same_ground() -> None:
    assert prune(laps(2, closed=False)).gone == ()


def test_what_looks_otherwise_stays() -> None:
    topo = laps(2)
    topo.nodes = [
        node if k < STEPS else Node(node.stamp_ns, node.travel, view(500 + k)) for k, node in enumerate(topo.nodes)
    ]
    assert prune(topo).gone == ()


@pytest.mark.parametrize("laps_more", [1, 3])
def test_the_route_between_what_is_kept_is_as_long_and_uncertain_as_before(laps_more: int) -> None:
    topo = laps(1 + laps_more)
    last = len(topo.nodes)
    topo.add(Node(5 * last * 250_000_000, 0.5 * last, view(2000)), increments(5 * (last - 1), 5))
    topo.close(ClosureEdge(STEPS - 1, last - 1, Pose2(), SPOT))
    pruned = prune(topo).map
    before = sum(float(own.covariances[:, 2, 2].sum()) for _, _, own in topo.odometry_edges())
    after = sum(float(own.covariances[:, 2, 2].sum()) for _, _, own in pruned.odometry_edges())
    assert len(pruned.nodes) < len(topo.nodes)
    assert after == pytest.approx(before)
