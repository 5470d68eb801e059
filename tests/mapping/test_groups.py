"""Closures believed together: what a pair is worth, which groups pass, and who joins them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.graph_odometry import chain_of, extended, odometry_edges
from topomap.mapping.closures.groups import NEARBY, Bar, credible_groups, log_odds_of_pairs
from topomap.mapping.closures.growth import map_graph
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements
from topomap.mapping.optimizer import Closures
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.agreement import loops_between
from topomap.mapping.uncertainty.odometry_chain import Chain
from topomap.mapping.uncertainty.paths import Paths

NODES, KNOWN = 600, 0.5
NAMES = ("i", "j", "relative", "covariance")
STEP = np.array([0.05, 0.05, 0.02])  # sigmas of odometry


def wander(turned: float = 0.3) -> tuple[PoseGraph, FloatArray]:
    """A drive of 600 m that turns at random and crosses itself: no closures yet; and its true poses."""
    rng = np.random.default_rng(5)
    steps = np.column_stack([np.ones(NODES - 1), np.zeros(NODES - 1), turned * rng.normal(size=NODES - 1)])
    truth = extended(np.zeros((1, 3)), steps)
    spread = np.tile(np.diag(STEP**2), (NODES - 1, 1, 1))
    none = np.zeros(0, np.int64)
    graph = PoseGraph("", steps + rng.normal(size=steps.shape) * STEP, spread, none, none, np.zeros((0, 3)), spread[:0])
    return graph, truth


def told(truth: FloatArray, i: list[int], j: list[int], seed: int = 0) -> Closures:
    rng = np.random.default_rng(seed)
    ends = np.array(i), np.array(j)
    relative = between(truth[ends[0]], truth[ends[1]]) + rng.normal(size=(len(i), 3)) * [0.05, 0.05, 0.02]
    return Closures(*ends, relative, np.tile(np.diag([0.05, 0.05, 0.02]) ** 2, (len(i), 1, 1)), np.ones(len(i)))


def mapped(graph: PoseGraph) -> tuple[FloatArray, Chain]:
    poses = extended(np.zeros((1, 3)), graph.odometry)
    edges = EdgeIncrements.of([edge.increments for edge in odometry_edges(graph)]).integrate(Calibration())
    return poses, chain_of(poses, edges)


def test_near_ends_are_found_along_the_chain_and_across_closures() -> None:
    graph, truth = wander()
    _, chain = mapped(graph)
    i, j = np.array([10, 60, 20]), np.array([300, 320, 590])
    bare = Paths(chain, told(truth, [0], [1])[:0])
    a, b, rank, known_i, known_j = bare.near(i, j, KNOWN)
    assert list(zip(a, b, rank, strict=True)) == [(0, 1, 1), (1, 2, 2), (2, 0, 1)]
    assert np.allclose(known_i, chain.covariance(i[a], i[b]), rtol=1e-5, atol=1e-8)
    assert np.allclose(known_j, chain.covariance(j[a], j[b]), rtol=1e-5, atol=1e-8)
    assert bare.near(i, j, 0.15).a.tolist() == [0]  # 56 m of 0.02 rad a metre
    linked = Paths(chain, told(truth, [300], [590]))
    assert len(linked.near(i, j, 0.15).a) == 3
    assert len(bare.near(i[:0], j[:0], KNOWN).a) == 0


def test_what_a_pair_is_worth_is_counted_over_all_other_ends() -> None:
    graph, truth = wander()
    poses, chain = mapped(graph)
    closures = told(truth, [100, 110], [400, 415])
    paths = Paths(chain, closures[:0])
    a, b, worth = log_odds_of_pairs(closures, poses, paths, KNOWN, Bar(8.0, 2.0, 16.0))
    assert (a.tolist(), b.tolist()) == ([0], [1])
    near = paths.near(closures.i, closures.j, KNOWN)
    first, last = np.meshgrid(np.arange(110 - NEARBY, 111 + NEARBY), np.arange(415 - NEARBY, NODES), indexing="ij")
    last_kept = last <= 415 + NEARBY
    ends = np.concatenate([[110], first[last_kept]]), np.concatenate([[415], last[last_kept]])
    count = len(ends[0])
    everywhere = Closures(
        np.append(100, ends[0]),
        np.append(400, ends[1]),
        np.concatenate([closures.relative[:1], np.tile(closures.relative[1], (count, 1))]),
        np.tile(closures.covariance[0], (count + 1, 1, 1)),
        np.ones(count + 1),
    )
    one, others = np.zeros(count, np.int64), np.arange(1, count + 1)
    known = [np.tile(part, (count, 1, 1)) for part in (near.known_i, near.known_j)]
    ij = (everywhere.i, everywhere.j)
    gap, spread = loops_between(everywhere.relative, everywhere.covariance, ij, poses, one, others, *known)
    # the gap of other ends is seen from the same place: its covariance is that of the pair itself
    chi2 = np.einsum("ni,ij,nj->n", gap, np.linalg.inv(spread[0]), gap)
    assert np.isfinite(wrap_all(gap[:, 2])).all()
    density = np.exp(-chi2 / 2)
    assert worth[0] == pytest.approx(np.log(density[0] / density[1:].mean()), abs=0.05)


def test_true_ones_are_credible_together_and_false_ones_stay_out() -> None:
    graph, truth = wander()
    poses, chain = mapped(graph)
    true = told(truth, [40, 52, 70], [500, 520, 533])
    wrong = told(np.random.default_rng(3).permutation(truth), [45, 300, 310], [510, 450, 540])
    both = Closures(*(np.concatenate(parts) for parts in zip(*map(_parts, (true, wrong)), strict=True)))
    good = credible_groups(both, np.zeros(6), poses, Paths(chain, both[:0]), KNOWN, Bar(8.0, 4.0, 16.0))
    assert good.tolist() == [True, True, True, False, False, False]
    high = credible_groups(both, np.zeros(6), poses, Paths(chain, both[:0]), KNOWN, Bar(80.0, 4.0, 16.0))
    assert not high.any()
    alone = credible_groups(both[:1], np.full(1, 99.0), poses, Paths(chain, both[:0]), KNOWN, Bar(8.0, 4.0, 16.0))
    assert alone.tolist() == [False]


def test_a_graph_that_no_closure_joins_alone_is_joined_by_a_group() -> None:
    graph, truth = wander()
    noisy = replace(
        graph,
        odometry=graph.odometry + np.random.default_rng(1).normal(size=graph.odometry.shape) * [0.05, 0.05, 0.05],
        odometry_covariance=np.tile(np.diag([0.07, 0.07, 0.063]) ** 2, (NODES - 1, 1, 1)),
    )
    true = told(truth, [40, 44, 48, 52, 56, 60], [500, 506, 510, 515, 520, 524])
    false = told(np.random.default_rng(4).permutation(truth), [*range(3, 83, 10)], [*range(250, 330, 10)])
    both = [np.concatenate(parts) for parts in zip(*map(_parts, (true, false)), strict=True)]
    mixed = replace(noisy, i=both[0], j=both[1], relative=both[2], covariance=both[3])
    believed = map_graph(mixed).believed
    assert believed[:6].sum() >= 4
    assert not believed[6:].any()
    rest = np.arange(5, len(both[0]))
    single = replace(noisy, **{name: part[rest] for name, part in zip(NAMES, both, strict=False)})
    assert not map_graph(single).believed.any()


def _parts(c: Closures) -> tuple[np.ndarray, ...]:
    return c.i, c.j, c.relative, c.covariance, c.weight
