"""The injection test on a small generated grid drive."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from graphs import ring_graph

from topomap.bench.pose_graphs.bench import OURS, Design, Row, bench
from topomap.bench.pose_graphs.clean import bridged, clean_optimum
from topomap.bench.pose_graphs.figure import injection
from topomap.bench.pose_graphs.injection import inject
from topomap.bench.pose_graphs.kept import KEPT, kept_rows, rows_of
from topomap.bench.pose_graphs.overview import overview
from topomap.bench.pose_graphs.peers import MethodRun, PeerProcess, nothing
from topomap.bench.pose_graphs.table import Cell, cells, texts, to_csv, to_json
from topomap.bench.pose_graphs.targets import shortfalls
from topomap.core.arrays import FloatArray
from topomap.core.errors import TopomapError
from topomap.core.geometry import between, compose
from topomap.evaluation.trajectory import ate
from topomap.mapping.graph_engine import optimise_graph
from topomap.mapping.optimizer.peers import PEERS, inliers
from topomap.mapping.pose_graph import PoseGraph

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


def design(**changes: object) -> Design:
    return replace(Design(kinds=["random"], shares=[0.5], seeds=[0], peers=[]), **changes)


def of(cells: Iterable[tuple[Row, ...]]) -> list[Row]:
    return [row for made in cells for row in made]


def test_bench_keeps_no_false_one_and_beats_odometry() -> None:
    graph, _ = drive()
    rows = of(bench(graph, design(shares=[0.0, 0.5], peers=["Huber"])))
    ours = [row for row in rows if row.method == OURS]
    assert [row.kept_false for row in ours] == [0, 0]
    assert min(row.recall for row in ours) >= 0.8
    for row in ours:
        assert row.ate_m is not None
        assert row.ate_m < row.odometry_ate_m
    assert [row.building_seconds > 0 for row in rows] == [False, True, False, True]
    whole = json.loads(to_json(rows, ["a line"]))
    assert len(whole["cells"]) == len(cells(rows)) == 4
    assert whole["short"] == ["a line"]
    assert to_csv(rows).count("\n") == 5
    assert to_csv(rows).startswith("graph,kind,false_share,method,")


def test_rows_are_kept_as_lines_with_odometry_beside_them_and_read_again() -> None:
    rows = of(bench(drive()[0], design(peers=["GNC"], limit=1e-4)))
    lines = [dict(zip(KEPT, line, strict=True)) for line in kept_rows(rows, 0.5)]
    told = [(line["contestant"], line["stopped"], line["limit [s]"], line["recall"]) for line in lines]
    assert told == [("topomap", "no", "", "1.00000"), ("odometry", "no", "", "0.00000"), ("GNC", "yes", "0.5", "-")]
    assert lines[1]["ATE [m]"] == lines[0]["odometry [m]"] != lines[0]["ATE [m]"]
    for row, again in zip(rows, rows_of(lines), strict=True):
        same = dict.fromkeys(("ate_m", "odometry_ate_m", "seconds", "cpu_seconds", "building_seconds"), 0.0)
        assert replace(row, **same) == replace(again, **same)
        assert row.ate_m is again.ate_m is None or again.ate_m == pytest.approx(row.ate_m, abs=1e-4)


def test_the_overview_tells_the_worst_of_each_contestant() -> None:
    one = of(bench(drive()[0], design(peers=["DCS"])))
    worse = [replace(row, seed=1, recall=0.5, precision=0.9, ate_m=7.0, cpu_seconds=3.0) for row in one]
    ours, peer = one[0], replace(one[1], precision=0.95, recall=0.75, ate_m=1.5)
    rows = [replace(ours, cpu_seconds=1.0), replace(peer, cpu_seconds=2.0), worse[0], replace(worse[1], stopped=True)]
    headings, lines = overview([*rows, replace(ours, kind="close", false_share=0.9)])
    assert headings[5:] == (OURS, "DCS", "CPU [s], topomap / DCS")
    assert lines[0][1:4] == ("random", "50%", "2")
    assert lines[0][5:] == ("0.9000 / 0.500 / 7.000", "0.9500 / 0.750 / 1.500, 1 of 2 stopped", "2.00 / 2.00")
    assert lines[1][1:4] == ("close", "90%", "1")
    assert lines[1][6] == "not run"


def test_what_there_is_not_is_refused() -> None:
    with pytest.raises(TopomapError, match="no peer 'Cauchy': there are DCS, GNC, Huber, Levenberg-Marquardt"):
        Design(peers=["Cauchy"])
    with pytest.raises(TopomapError, match="no kind 'evil': there are random, close, groups-5, groups-10, mixed"):
        Design(kinds=["evil"])


def test_without_false_closures_kind_and_seed_change_nothing() -> None:
    full = Design(shares=[0.0, 0.5], seeds=[3, 4], kinds=["random", "close"])
    assert full.cells() == [
        ("none", 0.0, 3), ("random", 0.5, 3), ("random", 0.5, 4), ("close", 0.5, 3), ("close", 0.5, 4)
    ]  # fmt: skip


def test_a_peer_that_takes_too_long_is_stopped_and_says_so() -> None:
    graph, _ = drive(rounds=16)  # half a second of DCS's: no machine is done within the limit
    rows = of(bench(graph, design(peers=["GNC", "DCS"], limit=1e-4)))
    assert [(row.method, row.stopped) for row in rows] == [(OURS, False), ("GNC", True), ("DCS", True)]
    assert rows[1].recall is None
    assert rows[1].ate_m is None
    assert rows[1].building_seconds > 0.0
    assert cells(rows)[1].stopped == 1
    assert texts(cells(rows)[1])[:6] == ("square", "random", "50%", "GNC", "1", "1")


def test_a_peer_that_was_stopped_is_not_asked_where_more_are_false(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def run(_: PeerProcess, method: str, graph: PoseGraph) -> MethodRun:
        asked.append((method, len(graph.i)))
        return nothing(graph, 2.0, 0.0, stopped=method == "GNC" and len(graph.i) > 90)

    monkeypatch.setattr(PeerProcess, "run", run)
    graph, _ = drive()
    whole = design(kinds=["random", "close"], shares=[0.0, 0.2, 0.6, 0.8], peers=["GNC", "DCS"], limit=2.0)
    rows = of(bench(graph, whole))
    many = {share: next(row.true + row.false for row in rows if row.false_share == share) for share in whole.shares}
    once = [("GNC", many[share]) for share in (0.2, 0.6)]
    assert [entry for entry in asked if entry[0] == "GNC"] == [("GNC", many[0.0]), *once, *once]
    assert len([entry for entry in asked if entry[0] == "DCS"]) == 7
    told = [(row.stopped, row.asked) for row in rows if row.method == "GNC"]
    assert told == [(False, True), *2 * [(False, True), (True, True), (True, False)]]
    lines = [dict(zip(KEPT, line, strict=True)) for row in rows for line in kept_rows([row], 2.0)]
    assert [line["stopped"] for line in lines if line["contestant"] == "GNC"] == ["no", *2 * ["no", "yes", "before"]]
    assert [(row.stopped, row.asked) for row in rows_of(lines)] == [(row.stopped, row.asked) for row in rows]
    assert cells(rows)[-2].seconds_mean == 0.0
    both = cells([replace(row, false_share=0.6) for row in rows if row.method == "GNC" and row.kind == "close"])
    assert both[0].seconds_mean == 2.0
    gnc = overview(rows)[1][1][6]
    assert gnc.endswith("2 of 3 stopped (1 not asked again)")


def test_a_peer_stopped_without_false_closures_is_not_asked_with_any(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PeerProcess, "run", lambda _, __, graph: nothing(graph, 2.0, 0.0, stopped=True))
    rows = of(bench(drive()[0], design(shares=[0.0, 0.2], seeds=[0, 1], peers=["DCS"])))
    assert [row.asked for row in rows if row.method == "DCS"] == [True, False, False]
    times = {line.get_label(): line for line in injection(rows, "random").axes[3].get_lines()}
    assert times["DCS"].get_xydata().tolist() == [[0.0, 2.0]], "a peer that wasn't asked took no time at all"
    assert len(times[OURS].get_xydata()) == 2


@pytest.mark.parametrize("method", PEERS)
def test_every_peer_finds_the_optimum_of_true_closures_where_drift_is_low(method: str) -> None:
    graph, truth = drive(seed=5)
    graph = replace(graph, odometry=0.3 * graph.odometry + 0.7 * between(truth[:-1], truth[1:]))
    peer = PEERS[method]
    poses, good = inliers(graph, peer.solve(peer.build(graph), graph.nodes))
    assert ate(poses, truth) < 0.5 * ate(graph.dead_reckoning(), truth)
    assert good.mean() > 0.9


def test_gaps_are_bridged_by_true_closures_before_lago_counts_turns() -> None:
    """With any heading in its gaps a ring has the optimum that it has with the right ones."""
    ring = ring_graph(laps=3, false=0, seed=2).without((20, 47, 70, 100))
    odometry = ring.graph.odometry.copy()
    odometry[ring.graph.gaps, 2] = [2.9, -1.4, 1.9, -2.5]
    clean = clean_optimum(replace(ring.graph, odometry=odometry))
    assert ate(clean, ring.truth) < 0.2
    apart = ring_graph(laps=2, false=0).without((30,)).graph
    alone = replace(apart, i=apart.i[:0], j=apart.j[:0], relative=apart.relative[:0], covariance=apart.covariance[:0])
    assert np.allclose(bridged(alone).odometry, alone.odometry)


def cell(method: str, **changes: object) -> Cell:
    whole = Cell(
        graph="g", kind="random", false_share=0.5, method=method, runs=3, stopped=0, precision_min=1.0,
        kept_false_max=0, recall_mean=1.0, recall_min=1.0, ate_m_mean=0.2, ate_m_max=0.2, odometry_ate_m=1.0,
        seconds_mean=1.0, seconds_max=1.0, cpu_seconds_mean=1.0, building_seconds_mean=0.0,
    )  # fmt: skip
    return replace(whole, **changes)


@pytest.mark.parametrize(
    ("ours", "peer", "lines"),
    [
        ({}, {}, []),
        ({"precision_min": 0.99, "kept_false_max": 2}, {}, ["precision 0.9900 < 0.999 (2 false kept)"]),
        ({"precision_min": None, "recall_mean": 0.0}, {}, ["recall 0.000 < 0.98 x 1.000 (DCS)"]),
        ({"recall_mean": 0.97}, {}, ["recall 0.970 < 0.98 x 1.000 (DCS)"]),
        ({"recall_mean": 0.97}, {"precision_min": 0.99}, []),
        ({"ate_m_max": 1.1}, {}, ["ATE 1.100 m > odometry's 1.000 m"]),
        ({"ate_m_mean": 0.25}, {}, ["ATE 0.250 m > 1.2 x 0.200 m (DCS)"]),
        ({"ate_m_mean": 0.05}, {"ate_m_mean": 0.0}, []),
        ({"ate_m_mean": 0.25}, {"ate_m_mean": 0.1, "stopped": 1}, []),
        ({"ate_m_mean": None, "ate_m_max": None}, {}, ["no poses"]),
    ],
)
def test_cells_that_fall_short_are_told(ours: dict[str, object], peer: dict[str, object], lines: list[str]) -> None:
    other = cell("DCS", kind="close", recall_mean=0.0, ate_m_mean=0.0)
    found = shortfalls([cell(OURS, **ours), cell("DCS", **peer), other])
    assert found == [f"g, random, 50%: {line}" for line in lines]


def test_without_closures_the_map_is_odometry() -> None:
    graph, _ = drive()
    none = np.zeros(0, np.int64)
    bare = replace(graph, i=none, j=none, relative=np.zeros((0, 3)), covariance=np.zeros((0, 3, 3)))
    found = optimise_graph(bare)
    assert np.allclose(found.poses, bare.dead_reckoning())
    assert found.inlier.shape == found.log_odds.shape == (0,)


def test_all_false_keeps_none() -> None:
    graph, truth = drive()
    found = inject(graph, truth, "random", 0.5, np.random.default_rng(1))
    bad = found.false
    part = found.graph
    only = replace(part, i=part.i[bad], j=part.j[bad], relative=part.relative[bad], covariance=part.covariance[bad])
    assert not optimise_graph(only).inlier.any()


def test_same_input_same_bytes() -> None:
    graph, truth = drive()
    found = inject(graph, truth, "random", 0.5, np.random.default_rng(2)).graph
    assert optimise_graph(found).poses.tobytes() == optimise_graph(found).poses.tobytes()
