"""What a pose graph's closures are judged by: noise, ways through the map, odds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topomap.bench.pose_graphs.injection import inject
from topomap.mapping.closures.graph_odometry import chain_of, odometry_edges, odometry_poses, volume
from topomap.mapping.closures.noise import rescaled, variance_factor
from topomap.mapping.closures.odds import crowding, log_odds
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements
from topomap.mapping.optimizer import Closures
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.odometry_chain import Chain
from topomap.mapping.uncertainty.paths import Paths

SIGMAS = np.array([0.03, 0.03, 0.02])


def laps(rounds: int = 4, seed: int = 0) -> PoseGraph:
    """Laps of a 10 m square in 1 m steps, each place closed with the one a lap before; noise as stated."""
    rng, lap = np.random.default_rng(seed), 40
    steps = np.tile([1.0, 0.0, 0.0], (rounds * lap - 1, 1))
    steps[9::10, 2] = np.pi / 2
    j = np.arange(lap, rounds * lap)
    spread = np.tile(np.diag(SIGMAS**2), (len(steps), 1, 1))
    odometry = steps + rng.normal(size=steps.shape) * SIGMAS
    return PoseGraph("laps", odometry, spread, j - lap, j, rng.normal(size=(len(j), 3)) * SIGMAS, spread[: len(j)])


def factor_of(graph: PoseGraph) -> float:
    edges = EdgeIncrements.of([edge.increments for edge in odometry_edges(graph)]).integrate(Calibration())
    poses = odometry_poses(graph)
    return variance_factor(graph, chain_of(poses, edges), volume(poses))


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_covariances_stated_too_large_are_found_out(share: float) -> None:
    graph = laps()
    truth = odometry_poses(replace(graph, odometry=np.round(graph.odometry / (np.pi / 2)) * (np.pi / 2)))
    mixed = inject(graph, truth, "random", share, np.random.default_rng(1)).graph
    assert factor_of(mixed) == pytest.approx(1.0, abs=0.35)
    assert factor_of(rescaled(mixed, 100.0)) == pytest.approx(0.01, abs=0.0035)


def test_without_true_loops_the_statement_stands() -> None:
    graph = laps()
    none = replace(graph, i=graph.i[:0], j=graph.j[:0], relative=graph.relative[:0], covariance=graph.covariance[:0])
    assert factor_of(none) == 1.0


def test_two_ways_know_more_than_one() -> None:
    graph = laps()
    edges = EdgeIncrements.of([edge.increments for edge in odometry_edges(graph)]).integrate(Calibration())
    chain = chain_of(odometry_poses(graph), edges)
    closures = Closures(graph.i, graph.j, graph.relative, graph.covariance, np.ones(len(graph.i)))[np.array([0])]
    i, j, free = np.array([0, 5]), np.array([40, 60]), np.array([-1, -1])
    along = chain.covariance(i, j)
    bare = Paths(chain, closures[:0]).covariance(i, j, free)
    assert np.allclose(bare, along, rtol=1e-6, atol=1e-9)
    known = Paths(chain, closures).covariance(i, j, free)
    both = np.linalg.inv(np.linalg.inv(along[0]) + np.linalg.inv(closures.covariance[0]))
    assert np.allclose(known[0], both, rtol=1e-6, atol=1e-9)
    without = Paths(chain, closures).covariance(i, j, np.array([0, 0]))
    assert np.allclose(without, along, rtol=1e-6, atol=1e-9)
    assert np.linalg.det(known[1]) < np.linalg.det(along[1])


def test_odds_are_against_an_even_density_and_fall_where_places_crowd() -> None:
    spread = np.diag([0.1, 0.1, 0.1])[None] ** 2
    even = np.exp(log_odds(np.zeros(1), spread, 1000.0))
    assert even[0] == pytest.approx(1000.0 / ((2 * np.pi) ** 1.5 * 1e-3))
    claim = Closures(np.array([0]), np.array([50]), np.zeros((1, 3)), spread, np.ones(1))
    rng = np.random.default_rng(0)
    spaced = np.column_stack([rng.uniform(0, 20, (400, 2)), rng.uniform(-np.pi, np.pi, 400)])
    lattice = np.column_stack([rng.integers(0, 20, (400, 2)), np.zeros(400)])
    everything = 400 * 2 * np.pi
    wide = np.diag([0.5, 0.5, 0.5])[None] ** 2
    assert crowding(spaced, claim, wide, everything)[0] < 3.0
    straight = np.diag([1.5, 1.5, 0.1])[None] ** 2
    assert crowding(spaced, claim, straight, everything)[0] < 3.0
    assert crowding(lattice, claim, straight, everything)[0] > 10.0
    assert crowding(lattice, claim, spread, everything)[0] == 1.0  # what stands just as claimed makes it true
    assert crowding(spaced[:1], claim[:0], wide[:0], everything).shape == (0,)


def test_increments_give_the_edges_back() -> None:
    graph = laps(3)
    whole = EdgeIncrements.of([edge.increments for edge in odometry_edges(graph)]).integrate(Calibration())
    assert np.allclose(whole.deltas(Calibration()), graph.odometry, atol=1e-9)
    assert np.allclose(whole.covariances(Calibration()), graph.odometry_covariance, atol=1e-9)
    chain = Chain.of(odometry_poses(graph), whole, Calibration(), np.zeros((3, 3)))
    assert np.allclose(chain.covariance(np.array([4]), np.array([5]))[0], graph.odometry_covariance[4], atol=1e-9)
