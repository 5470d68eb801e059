"""A pose graph as the engine takes it: its edges as increments, its closures in order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lapped import lapped

from topomap.mapping.closures.pose_graph_drive import claims_of, drive_of, odometry_edges
from topomap.mapping.closures.working_map import GROWING
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.odometry_chain import Chain


def correlated() -> PoseGraph:
    """A lapped drive whose steps have sideways parts and covariances of all shapes."""
    graph = lapped(laps=2).shuffled(1).graph
    rng = np.random.default_rng(0)
    root = rng.normal(size=(graph.nodes - 1, 3, 3)) * 0.05
    odometry = graph.odometry + rng.normal(size=graph.odometry.shape) * [0.1, 0.5, 0.3]
    return replace(graph, odometry=odometry, odometry_covariance=root @ root.transpose(0, 2, 1) + 1e-6 * np.eye(3))


@pytest.mark.parametrize("factor", [1.0, 0.01])
def test_increments_give_the_edges_back(factor: float) -> None:
    graph = correlated()
    whole = odometry_edges(graph, factor).increments.integrate(Calibration())
    assert np.allclose(whole.deltas(Calibration()), graph.odometry, atol=1e-12)
    assert np.allclose(whole.covariances(Calibration()), factor * graph.odometry_covariance, atol=1e-12)


def test_the_drive_is_the_graphs_odometry_and_its_chain_knows_each_step() -> None:
    graph = correlated()
    drive = drive_of(graph, 0.5)
    state = drive.start()
    assert np.array_equal(state.poses, graph.dead_reckoning())
    chain = drive.chain(state)
    k = np.arange(graph.nodes - 1)
    assert np.allclose(chain.covariance(k, k + 1), 0.5 * graph.odometry_covariance, atol=1e-9)


def test_a_held_drives_chain_is_that_of_all_its_errors() -> None:
    drive = drive_of(correlated(), 0.5)
    state = drive.start()
    assert drive.held
    edges = drive.edges.increments.integrate(drive.prior)
    held, whole = drive.chain(state), Chain.of(state.poses, edges, drive.prior, np.zeros((3, 3)))
    assert np.array_equal(held.random, whole.random)
    assert np.array_equal(held.travelled, whole.travelled)
    i, j = np.random.default_rng(1).integers(0, len(state.poses), (2, 50))
    assert np.array_equal(held.covariance(i, j), whole.covariance(i, j))


def test_closures_are_in_order_of_their_places_and_know_where_they_came_from() -> None:
    graph = correlated()
    claims, order = claims_of(graph, 0.25)
    assert (np.diff(claims.i * graph.nodes + claims.j) >= 0).all()
    assert np.array_equal(claims.i, graph.i[order])
    assert np.array_equal(claims.j, graph.j[order])
    assert np.array_equal(claims.relative, graph.relative[order])
    assert np.allclose(claims.covariance, 0.25 * graph.covariance[order])
    assert not claims.looks.any()
    assert not claims.blind.any()
    edges = claims.closures()
    assert np.array_equal(edges.relative, claims.relative)
    assert (edges.weight == 1.0).all()


def test_a_solve_begins_where_the_map_was_and_leaves_it_alone() -> None:
    world = lapped(laps=3)
    drive, claims, _ = world.engine_input()
    before = drive.start()
    kept = before.poses.copy()
    state, inlier = drive.solve(before, claims, GROWING)
    assert inlier.any()
    assert np.abs(state.poses - before.poses).max() > 0.1
    assert np.array_equal(before.poses, kept)
    again, _ = drive.solve(state, claims, GROWING)
    assert np.abs(again.poses - state.poses).max() < 0.05
    assert np.allclose(state.calibration.vector(), drive.prior.vector(), atol=1e-6)  # it is held
