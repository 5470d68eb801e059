"""The odometer's declared errors: widened while nothing tells them, and judged by ranges."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.odometry.calibration import DistanceScale
from topomap.mapping.odometry.increments import Increments
from topomap.mapping.odometry.noise import LEAST, WIDE_FORWARD, WIDE_TURN, OdometerNoise, declared, rolled


def increments(forward_sigma: float, turn_sigma: float, steps: int = 10) -> Increments:
    deltas = np.tile([0.1, 0.0, 0.0], (steps, 1))
    covariance = np.diag([forward_sigma**2, 1e-12, turn_sigma**2])
    return Increments(np.arange(1, steps + 1), deltas, np.tile(covariance, (steps, 1, 1)))


def test_zeros_are_not_believed() -> None:
    way = increments(0.0, 0.0)
    assert declared(way)[0, 2, 2] == pytest.approx(LEAST * WIDE_TURN**2 * 0.1)
    wide = OdometerNoise().judged(way).covariances
    assert wide[:, 0, 0].sum() == pytest.approx(WIDE_FORWARD**2)
    assert wide[:, 2, 2].sum() == pytest.approx(WIDE_TURN**2)


def test_what_is_declared_is_only_widened_until_something_tells_it() -> None:
    poor = increments(0.1, 0.1)
    assert OdometerNoise().judged(poor).covariances[:, 2, 2] == pytest.approx(poor.covariances[:, 2, 2])


def test_factors_scale_variances_and_keep_correlations() -> None:
    way = increments(0.02, 0.02)
    way.covariances[:, 0, 2] = way.covariances[:, 2, 0] = 0.5 * 0.02**2
    judged = OdometerNoise(4.0, 9.0).judged(way).covariances[0]
    assert judged[0, 0] == pytest.approx(4 * 0.02**2)
    assert judged[2, 2] == pytest.approx(9 * 0.02**2)
    assert judged[0, 2] / math.sqrt(judged[0, 0] * judged[2, 2]) == pytest.approx(0.5)


def test_a_standstill_stays_one() -> None:
    still = Increments(np.arange(3), np.zeros((3, 3)), np.zeros((3, 3, 3)))
    assert rolled(still) == 0.0
    assert not OdometerNoise().judged(still).covariances.any()


def test_a_map_hands_out_what_was_judged_and_keeps_what_was_declared() -> None:
    topo = TopoMap()
    topo.add(Node(0, 0.0, None), None)
    topo.add(Node(10, 1.0, None), increments(0.02, 0.02))
    topo.judge(OdometerNoise(1.0, 4.0))
    (_, _, judged), *_ = topo.odometry_edges()
    assert judged.covariances[0, 2, 2] == pytest.approx(4 * 0.02**2)
    assert topo.way(0, 1).covariances[0, 2, 2] == pytest.approx(0.02**2)
    topo.insert(5)
    parts = [part for _, _, part in topo.odometry_edges()]
    assert sum(len(part) for part in parts) == 10
    assert parts[0].covariances[0, 2, 2] == pytest.approx(4 * 0.02**2)


@pytest.mark.parametrize("times", [1 / 3, 1.0, 3.0])
def test_ranges_judge_the_way(times: float) -> None:
    rng, found = np.random.default_rng(0), DistanceScale()
    for _ in range(300):
        found.add(0.95 * 0.8 + rng.normal(0.0, 0.02), 0.8 + rng.normal(0.0, 0.003), 0.003, 0.0, times * 0.02)
    told = found.odometer()
    assert told is not None
    assert told[0] == pytest.approx(times**-2, rel=0.35)
    assert told[0] < told[1]


def test_nearly_the_same_isnt_judged_anew() -> None:
    assert OdometerNoise(1.0, 2.0).near(OdometerNoise(1.05, 2.1))
    assert not OdometerNoise(1.0, 2.0).near(OdometerNoise(1.0, 3.0))
    assert not OdometerNoise(1.0, None).near(OdometerNoise(1.0, 3.0))
    assert OdometerNoise().near(OdometerNoise())


def test_a_map_judged_anew_judges_its_edges_at_once_and_each_as_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 13,000 edges one by one it took a second, in a single step."""
    topo = TopoMap()
    topo.add(Node(0, 0.0, None), None)
    ways = [replace(increments(0.01 * k, 0.02), stamps_ns=np.arange(10) + 10 * k + 1) for k in range(50)]
    for k, way in enumerate(ways):
        topo.add(Node(10 * k + 10, k + 1.0, None), way)
    noise, calls = OdometerNoise(2.0, None), []
    alone = [noise.judged(way) for way in ways]
    judging = OdometerNoise.covariances
    monkeypatch.setattr(OdometerNoise, "covariances", lambda self, way: calls.append(way) or judging(self, way))
    topo.judge(noise)
    found, whole = [way for _, _, way in topo.odometry_edges()], topo.odometry().increments
    assert len(calls) == 2  # for edges by themselves, and for all in one piece
    assert np.array_equal(whole.covariances, np.concatenate([own.covariances for own in alone]))
    topo.add(Node(1000, 60.0, None), replace(ways[0], stamps_ns=ways[0].stamps_ns + 900))
    whole = topo.odometry().increments
    assert len(calls[2].deltas) == len(ways[0])  # what was judged already is kept
    assert np.array_equal(whole.covariances[-10:], alone[0].covariances)
    for one, own in zip(found, alone, strict=True):
        assert np.array_equal(one.covariances, own.covariances)
        assert np.array_equal(one.stamps_ns, own.stamps_ns)
        assert np.array_equal(one.deltas, own.deltas)


def test_a_piece_of_the_chain_is_the_same_cut_from_the_whole_or_taken_edge_by_edge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    topo = TopoMap()
    topo.add(Node(0, 0.0, None), None)
    ways = [replace(increments(0.01 * k, 0.02), stamps_ns=np.arange(10) + 10 * k + 1) for k in range(13)]
    for k, way in enumerate(ways[:12]):
        topo.add(Node(10 * k + 10, k + 1.0, None), way)

    def pieces(share: float) -> list[list[list[float]]]:
        monkeypatch.setattr("topomap.mapping.graph.SHARE", share)
        told = [topo.odometry(place) for place in (0, 1, 4, 11)]
        return [[one.increments.starts.tolist(), one.increments.deltas.tolist(), one.increments.covariances.tolist()]
                for one in told]  # fmt: skip

    for change in (
        lambda: None,
        lambda: topo.judge(OdometerNoise(2.0, 3.0)),
        lambda: topo.insert(36),
        lambda: topo.add(Node(130, 13.0, None), ways[12]),
    ):
        change()
        assert pieces(0.0) == pieces(2.0)
