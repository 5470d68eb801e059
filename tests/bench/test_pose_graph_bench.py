"""The injection test on a small generated grid drive."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from topomap.bench.pose_graphs.bench import OURS, PeerLimits, averages, bench, to_csv, to_json
from topomap.bench.pose_graphs.injection import LARGEST, counts, inject
from topomap.core.arrays import FloatArray
from topomap.core.errors import TopomapError
from topomap.core.geometry import between, compose
from topomap.mapping.closures.graph_odometry import odometry_edges, odometry_poses
from topomap.mapping.closures.growth import map_graph
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.odometry_chain import Chain

LAP = 40


def drive(rounds: int = 3, seed: int = 0) -> tuple[PoseGraph, FloatArray]:
    """Laps of a 10 m square in 1 m steps with a closure at every second step of the later laps; and the truth."""
    rng = np.random.default_rng(seed)
    nodes = rounds * LAP
    steps = np.tile([1.0, 0.0, 0.0], (nodes - 1, 1))
    steps[9::10, 2] = np.pi / 2
    truth = [np.zeros(3)]
    for step in steps:
        truth.append(compose(truth[-1], step))
    poses = np.array(truth)
    spread = np.diag([0.03, 0.03, 0.02]) ** 2
    j = np.arange(LAP, nodes, 2)
    i = j - LAP
    noise = rng.normal(size=(len(steps) + len(j), 3)) * [0.03, 0.03, 0.02]
    relative = between(poses[i], poses[j]) + noise[len(steps) :]
    tiled = np.tile(spread, (len(steps), 1, 1))
    graph = PoseGraph("square", steps + noise[: len(steps)], tiled, i, j, relative, tiled[: len(j)])
    return graph, poses


def test_counts_keep_the_share_and_the_limit() -> None:
    assert counts(785, 0.0) == (785, 0)
    assert counts(785, 0.2) == (785, 196)
    for true in (128, 785, 2099, 54312):
        for share in (0.5, 0.8, 0.9):
            kept, false = counts(true, share)
            assert false <= LARGEST
            assert false / (kept + false) == pytest.approx(share, abs=0.01)


def test_injected_closures_are_false_and_repeat_with_the_seed() -> None:
    graph, truth = drive()
    found = inject(graph, truth, 0.8, np.random.default_rng(3))
    again = inject(graph, truth, 0.8, np.random.default_rng(3))
    assert found.graph.i.tolist() == again.graph.i.tolist()
    assert found.false.mean() == pytest.approx(0.8, abs=0.01)
    bad, good = found.graph, found.false
    error = between(truth[bad.i], truth[bad.j]) - bad.relative
    off = np.hypot(error[:, 0], error[:, 1])
    assert off[~good].max() < 0.3
    turned = np.abs(np.angle(np.exp(1j * error[:, 2])))
    assert ((off[good] > 1.0) | (turned[good] > np.deg2rad(20))).all()


def test_increments_give_the_edges_back() -> None:
    graph, _ = drive()
    whole = EdgeIncrements.of([edge.increments for edge in odometry_edges(graph)]).integrate(Calibration())
    assert np.allclose(whole.deltas(Calibration()), graph.odometry, atol=1e-9)
    assert np.allclose(whole.covariances(Calibration()), graph.odometry_covariance, atol=1e-9)
    chain = Chain.of(odometry_poses(graph), whole, Calibration(), np.zeros((3, 3)))
    assert np.allclose(chain.covariance(np.array([4]), np.array([5]))[0], graph.odometry_covariance[4], atol=1e-9)


def test_bench_keeps_no_false_one_and_beats_odometry() -> None:
    graph, _ = drive()
    rows = list(bench(graph, [0], [0.0, 0.5], ["Huber"]))
    ours = [row for row in rows if row.method == OURS]
    assert [row.kept_false for row in ours] == [0, 0]
    assert min(row.recall for row in ours) >= 0.8
    for row in ours:
        assert row.ate_m is not None
        assert row.ate_m < row.odometry_ate_m
    assert len(json.loads(to_json(rows))["averages"]) == len(averages(rows)) == 4
    assert to_csv(rows).count("\n") == 5
    with pytest.raises(TopomapError, match="no method 'Cauchy'"):
        list(bench(graph, [0], [0.0], ["Cauchy"]))


def test_a_peer_that_takes_too_long_is_stopped_and_says_so() -> None:
    graph, _ = drive()
    rows = list(bench(graph, [0], [0.5], ["GNC"], PeerLimits(seconds=1e-4)))
    assert [(row.method, row.stopped) for row in rows] == [(OURS, False), ("GNC", True)]
    assert rows[1].recall is None
    assert rows[1].ate_m is None
    assert averages(rows)[1]["stopped"] == 1


def test_without_closures_the_map_is_odometry() -> None:
    graph, _ = drive()
    none = np.zeros(0, np.int64)
    bare = replace(graph, i=none, j=none, relative=np.zeros((0, 3)), covariance=np.zeros((0, 3, 3)))
    found = map_graph(bare)
    assert np.allclose(found.poses, odometry_poses(bare))
    assert found.believed.shape == (0,)


def test_all_false_keeps_none() -> None:
    graph, truth = drive()
    found = inject(graph, truth, 0.5, np.random.default_rng(1))
    bad = found.false
    part = found.graph
    only = replace(part, i=part.i[bad], j=part.j[bad], relative=part.relative[bad], covariance=part.covariance[bad])
    assert not map_graph(only).believed.any()


def test_same_input_same_bytes() -> None:
    graph, truth = drive()
    found = inject(graph, truth, 0.5, np.random.default_rng(2)).graph
    assert map_graph(found).poses.tobytes() == map_graph(found).poses.tobytes()
