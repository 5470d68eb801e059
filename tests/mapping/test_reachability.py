"""Covariances over short cuts, and the chain that grows with its map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from maps import snapshot
from ring import edges_of, ring

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between
from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.odometry.noise import OdometerNoise
from topomap.mapping.optimizer import TurnEdge
from topomap.mapping.uncertainty.incremental_chain import IncrementalChain
from topomap.mapping.uncertainty.odometry_chain import Chain, carried_to_origin
from topomap.mapping.uncertainty.path_covariance import best_way, joined_way, seen_from_all, turned

UNSURE = np.diag([0.05, 0.01, 0.1]) ** 2
CLOSURE = np.diag([0.1, 0.2, 0.05]) ** 2


def made_chain() -> Chain:
    problem = ring(3, nodes=60, length=60, closures=0).problem
    edges = problem.odometry.increments.integrate(Calibration())
    poses = [np.zeros(3)]
    deltas = edges.deltas(Calibration())
    for delta in deltas:
        c, s = np.cos(poses[-1][2]), np.sin(poses[-1][2])
        poses.append(poses[-1] + [c * delta[0] - s * delta[1], s * delta[0] + c * delta[1], delta[2]])
    return Chain.of(np.array(poses), edges, Calibration(), UNSURE)


def rotation(heading: float) -> FloatArray:
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def composed_covariance(a: FloatArray, a_covariance: FloatArray, b: FloatArray, b_covariance: FloatArray) -> FloatArray:
    """The covariance (1, 3, 3) of the pose a b (1, 3), each given with the covariance of its own."""
    turn = rotation(a[0, 2])
    lever = np.eye(3)
    lever[:2, 2] = turn[:2, :2] @ b[0, :2] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    return np.asarray(lever @ a_covariance[0] @ lever.T + turn @ b_covariance[0] @ turn.T)[None]


def through(chain: Chain, i: int, a: int, b: int, j: int, closure: FloatArray) -> FloatArray:
    """The covariance of i_from_j along the chain to a, over a closure to b, and along the chain."""
    at = {name: chain.poses[[k]] for name, k in (("i", i), ("a", a), ("b", b), ("j", j))}
    first = chain.covariance(np.array([i]), np.array([a]))
    middle = composed_covariance(between(at["i"], at["a"]), first, between(at["a"], at["b"]), closure[None])
    last = chain.covariance(np.array([b]), np.array([j]))
    return composed_covariance(between(at["i"], at["b"]), middle, between(at["b"], at["j"]), last)[0]


def test_the_best_way_is_the_chain_or_the_chain_over_a_closure() -> None:
    chain = made_chain()
    ends = np.array([[5, 33]])
    carry = carried_to_origin(chain.poses[ends[:, 0]], chain.poses[ends[:, 1]])
    closures = carry @ CLOSURE[None] @ carry.transpose(0, 2, 1)
    for i, j, over in ((2, 35, (5, 33)), (36, 4, (33, 5)), (40, 44, None)):
        x, y, _ = chain.poses[j].tolist()
        found = best_way(chain.random, chain.systematic, UNSURE, i, j, x, y, ends, closures)
        if over is None:
            expected = chain.covariance(np.array([i]), np.array([j]))[0]
        else:
            a, b = over
            closure = turned(closures[0], chain.poses[a, 2], *chain.poses[b, :2].tolist())
            expected = through(chain, i, a, b, j, closure)
            assert np.trace(expected[:2, :2]) < np.trace(chain.covariance(np.array([i]), np.array([j]))[0][:2, :2])
        assert np.allclose(turned(found, chain.poses[i, 2], x, y), expected, rtol=1e-6, atol=1e-12)


def test_all_places_see_the_end_as_each_does() -> None:
    chain = made_chain()
    ends = np.array([[5, 50]])
    carry = carried_to_origin(chain.poses[ends[:, 0]], chain.poses[ends[:, 1]])
    closures = carry @ CLOSURE[None] @ carry.transpose(0, 2, 1)
    x, y, _ = chain.poses[-1].tolist()
    found = seen_from_all(chain.random, chain.systematic, UNSURE, 59, x, y, ends, closures, 0.01)
    for i in (0, 8, 30, 52):
        errors = best_way(chain.random, chain.systematic, UNSURE, i, 59, x, y, ends, closures)
        in_map = turned(errors, 0.0, x, y)[:2, :2] + 0.01 * np.eye(2)
        assert np.allclose(np.linalg.inv(found[i]), in_map, rtol=1e-6)


def test_the_growing_chain_is_the_whole_one_after_every_change() -> None:
    problem = ring(3, nodes=30, length=30, closures=0).problem
    topo, turns = TopoMap(), []
    last = topo.add(Node(0, 0.0, snapshot(0)), None)
    growing = IncrementalChain(topo, turns)
    for k, edge in enumerate(edges_of(problem)):
        new = topo.add(Node(int(edge.increments.stamps_ns[-1]), 0.0, snapshot(k) if k % 4 else None), edge.increments)
        if k % 4:
            turns.append(TurnEdge(last, new, 0.0, 0.01))
            last = new
        if k == 12:
            topo.insert(int(edge.increments.stamps_ns[1]))
        if k == 20:
            moved = topo.poses.copy()
            moved[15:, 0] += 0.5
            topo.move(moved, topo.calibration)
        if k == 25:
            topo.move(topo.poses.copy(), Calibration(1.02, 0.001, 0.97))
        if k == 23:
            topo.judge(OdometerNoise(2.0, 3.0))
        if k == 27:  # one in the middle says something new, one nothing any more, the rest what it said
            turns[:] = [replace(turn, sigma=0.02 if turn is turns[9] else turn.sigma) for turn in turns]
            del turns[14]
            topo.weigh(list(turns))
        found, whole = growing.current(UNSURE), IncrementalChain(topo, turns).current(UNSURE)
        for mine, other in zip(
            (found.poses, found.travelled, found.random, found.systematic),
            (whole.poses, whole.travelled, whole.random, whole.systematic),
            strict=True,
        ):
            assert np.allclose(mine, other, rtol=1e-9, atol=1e-12)


def test_turns_weighed_anew_that_say_what_they_said_cost_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every stretch of a large map weighs them, and the way of 13,000 nodes was summed up anew each time."""
    topo, turns = TopoMap(), []
    last = topo.add(Node(0, 0.0, snapshot(0)), None)
    for k, edge in enumerate(edges_of(ring(3, nodes=30, length=30, closures=0).problem)):
        new = topo.add(Node(int(edge.increments.stamps_ns[-1]), 0.0, snapshot(k)), edge.increments)
        turns.append(TurnEdge(last, new, 0.0, 0.01))
        last = new
    growing, summed = IncrementalChain(topo, turns), []
    growing.current(UNSURE)
    of = Chain.of
    monkeypatch.setattr(
        Chain, "of", lambda poses, edges, *rest: summed.append(len(edges.turn)) or of(poses, edges, *rest)
    )
    turns[:-2] = [replace(turn) for turn in turns[:-2]]
    turns[-2] = replace(turns[-2], sigma=0.02)
    topo.weigh(list(turns))
    growing.current(UNSURE)
    assert summed == [2]


def test_a_measured_turn_takes_away_what_it_tells_and_no_more() -> None:
    """Against the joint estimate of one edge's errors and the calibration, kept as one vector."""
    problem = ring(3, nodes=10, length=10, closures=0).problem
    edges = problem.odometry.increments.integrate(Calibration())
    poses = np.zeros((len(edges.turn) + 1, 3))
    sigma = 0.004
    told = Chain.of(poses, edges, Calibration(), np.zeros((3, 3)), turn_variances=np.full(len(edges.turn), sigma**2))
    noise = edges.covariances(Calibration())[0]
    turned = np.array([[0.0, 0.0, 1.0]])
    expected = np.linalg.inv(np.linalg.inv(noise) + turned.T @ turned / sigma**2)
    assert np.allclose(told.random[1], expected, rtol=1e-9)
    gain = noise[:, 2] / (noise[2, 2] + sigma**2)
    response = edges.jacobians(Calibration())[0]
    assert np.allclose(told.systematic[1], response - np.outer(gain, response[2]), rtol=1e-9)
    bare = Chain.of(poses, edges, Calibration(), np.zeros((3, 3)), turn_variances=np.full(len(edges.turn), np.inf))
    plain = Chain.of(poses, edges, Calibration(), np.zeros((3, 3)))
    assert np.allclose(bare.random, plain.random)
    assert np.allclose(bare.systematic, plain.systematic)


def test_closures_along_two_stretches_add_up_as_in_a_solve_of_all() -> None:
    """Against the covariance of the same chain and closures by their normal equations."""
    chain = made_chain()
    ends = np.array([[12, 33], [9, 36], [5, 40]])
    carry = carried_to_origin(chain.poses[ends[:, 0]], chain.poses[ends[:, 1]])
    closures = carry @ CLOSURE[None] @ carry.transpose(0, 2, 1)
    nothing = np.zeros((3, 3))
    found = joined_way(chain.random, chain.systematic, nothing, 4, 42, ends, closures)
    steps = np.diff(chain.random, axis=0)[4:42]
    rows = [np.kron(np.eye(len(steps)), np.eye(3))]
    noise = [np.linalg.inv(step) for step in steps]
    for (a, b), closure in zip(ends, closures, strict=True):
        between_them = ((np.arange(4, 42) >= a) & (np.arange(4, 42) < b)).astype(float)
        rows.append(np.kron(between_them[None], np.eye(3)))
        noise.append(np.linalg.inv(closure))
    jacobian = np.concatenate(rows)
    weight = np.zeros((len(jacobian), len(jacobian)))
    for k, one in enumerate(noise):
        weight[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = one
    whole = np.kron(np.ones((1, len(steps))), np.eye(3))
    expected = whole @ np.linalg.solve(jacobian.T @ weight @ jacobian, whole.T)
    assert np.allclose(found, expected, rtol=1e-6)
