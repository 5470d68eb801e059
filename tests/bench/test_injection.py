"""False closures injected into pose graphs: how many, of which kinds, and that they are false."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from graphs import ring_graph

from topomap.bench.pose_graphs.injection import CLOSE_RADIUS, KINDS, Injected, inject, wanted
from topomap.core.errors import TopomapError
from topomap.core.geometry import between, compose
from topomap.datasets.g2o import read_graph
from topomap.mapping.optimizer.examples import example
from topomap.mapping.pose_graph import PoseGraph

RING = ring_graph(laps=6, false=0)


def injected(kind: str, share: float = 0.8, seed: int = 0) -> Injected:
    return inject(RING.graph, RING.truth, kind, share, np.random.default_rng(seed))


def groups(found: Injected) -> list[list[int]]:
    """The false closures by group: rows whose j runs on by one and whose i by one, either way."""
    graph = found.graph
    rows = sorted(np.flatnonzero(found.false).tolist(), key=lambda row: (graph.j[row], graph.i[row]))
    ends = {(int(graph.i[row]), int(graph.j[row])): row for row in rows}
    chains = []
    for (i, j), row in ends.items():
        for step in (1, -1):
            if (i - step, j - 1) in ends:
                continue
            chain = [row]
            while (i + step * len(chain), j + len(chain)) in ends:
                chain.append(ends[i + step * len(chain), j + len(chain)])
            chains.append(chain)
    return chains


def test_all_true_closures_stay_and_nothing_caps_the_false_ones() -> None:
    assert wanted(785, 0.0) == 0
    assert wanted(54312, 0.9) == 488808
    for kind in KINDS:
        for share in (0.0, 0.2, 0.9):
            found = injected(kind, share)
            kept = found.graph
            assert found.false.sum() == wanted(len(RING.graph.i), share)
            true = sorted(zip(kept.i[~found.false], kept.j[~found.false], kept.relative[~found.false, 0], strict=True))
            assert true == sorted(zip(RING.graph.i, RING.graph.j, RING.graph.relative[:, 0], strict=True))


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_injected_is_false_and_repeats_with_the_seed(kind: str) -> None:
    found, again, other = injected(kind), injected(kind), injected(kind, seed=1)
    assert found.graph.i.tolist() == again.graph.i.tolist()
    assert found.graph.i.tolist() != other.graph.i.tolist()
    graph = found.graph
    assert (graph.i < graph.j).all()
    error = between(RING.truth[graph.i], RING.truth[graph.j]) - graph.relative
    off = np.hypot(error[:, 0], error[:, 1])
    turned = np.abs(np.angle(np.exp(1j * error[:, 2])))
    assert ((off > 1.0) | (turned > np.deg2rad(20)))[found.false].all()
    assert off[~found.false].max() < 0.3
    assert (np.abs(graph.relative[:, 2]) <= np.pi).all()


def test_the_ends_of_close_ones_are_near_and_those_of_random_ones_anywhere() -> None:
    # a ring wider than the radius
    wide = RING.truth * np.array([4.0, 4.0, 1.0])
    graph = replace(RING.graph, odometry=between(wide[:-1], wide[1:]))
    near = inject(graph, wide, "close", 0.8, np.random.default_rng(0))
    apart = np.hypot(*(wide[near.graph.i, :2] - wide[near.graph.j, :2])[near.false].T)
    assert apart.max() <= CLOSE_RADIUS
    far = inject(graph, wide, "random", 0.8, np.random.default_rng(0))
    assert np.median(np.hypot(*(wide[far.graph.i, :2] - wide[far.graph.j, :2])[far.false].T)) > CLOSE_RADIUS


def test_close_pairs_are_drawn_evenly_over_the_near_ones() -> None:
    """Along a straight drive each node has as many near ones before as behind."""
    nodes = 400
    steps = np.tile([1.0, 0.0, 0.0], (nodes - 1, 1))
    spread = np.tile(np.eye(3) * 1e-4, (nodes - 1, 1, 1))
    far = np.tile([-30.0, 0.0, 0.0], (nodes, 1))  # a claim that nothing near fulfils
    graph = PoseGraph(
        "line", steps, spread, np.zeros(nodes, np.int64), np.full(nodes, 30), far, spread[:1].repeat(nodes, 0)
    )
    found = inject(graph, graph.dead_reckoning(), "close", 0.9, np.random.default_rng(0))
    gap = (found.graph.j - found.graph.i)[found.false]
    counts = np.bincount(gap, minlength=12)[2:11]
    assert counts.sum() == found.false.sum()
    assert counts.min() > 0.8 * counts.mean()
    assert counts.max() < 1.2 * counts.mean()


@pytest.mark.parametrize("size", [5, 10])
def test_groups_run_along_both_stretches_in_both_directions_and_agree(size: int) -> None:
    found = injected(f"groups-{size}", 0.5)
    graph, poses = found.graph, RING.graph.dead_reckoning()
    whole = [chain for chain in groups(found) if len(chain) >= size]
    assert sum(map(len, whole)) >= 0.9 * found.false.sum()
    back = [graph.i[chain[1]] < graph.i[chain[0]] for chain in whole]
    assert {True, False} == set(map(bool, back))
    carried, same = 0, 0
    for chain in whole:
        first = chain[0]
        for row in chain[1:size]:
            on = compose(
                compose(between(poses[graph.i[row]], poses[graph.i[first]]), graph.relative[first]),
                between(poses[graph.j[first]], poses[graph.j[row]]),
            )
            same += int(np.allclose(graph.relative[row], graph.relative[first]))
            carried += int(np.hypot(*(graph.relative[row] - on)[:2]) < 0.5)
    assert same > 0.2 * sum(len(chain) - 1 for chain in whole)
    assert carried > 0.4 * sum(len(chain) - 1 for chain in whole)


def test_groups_cross_no_gap() -> None:
    gaps = tuple(range(15, RING.graph.nodes - 1, 16))
    split = RING.without(gaps)
    found = inject(split.graph, split.truth, "groups-10", 0.5, np.random.default_rng(0))
    for chain in groups(found):
        for ends in (found.graph.i, found.graph.j):
            part = ends[chain[:10]]
            if len(part) == 10:
                assert len(set((part // 16).tolist())) == 1


def test_mixed_is_a_third_of_each() -> None:
    found = injected("mixed", 0.9)
    grouped = {row for chain in groups(found) if len(chain) >= 5 for row in chain}
    assert len(grouped) / found.false.sum() == pytest.approx(1 / 3, abs=0.08)


def test_a_graph_without_room_says_so() -> None:
    tiny = ring_graph(laps=1, false=0).graph
    tiny = replace(
        tiny, odometry=tiny.odometry[:6], odometry_covariance=tiny.odometry_covariance[:6], names=np.arange(7),
        gaps=np.zeros(6, np.bool_), i=np.array([0]), j=np.array([6]), relative=np.zeros((1, 3)),
        covariance=tiny.odometry_covariance[:1],
    )  # fmt: skip
    with pytest.raises(TopomapError, match="pose graph 'ring': no room for 1 false closures of the kind 'groups-10'"):
        inject(tiny, tiny.dead_reckoning(), "groups-10", 0.5, np.random.default_rng(0))


def test_half_a_million_are_made_in_seconds() -> None:
    graph = read_graph(example("w10000.graph"))
    poses = graph.dead_reckoning()
    begin = time.process_time()
    found = inject(graph, poses, "mixed", 0.9, np.random.default_rng(0))
    assert time.process_time() - begin < 8.0
    assert (len(found.false), int(found.false.sum())) == (543120, 488808)
