"""Whether a replay's map is the run's: to the bit, to the last digits, or another one."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from round_world import RoundRobot
from synthetic_run import make_run

import topomap
from topomap.app import same
from topomap.core.geometry import Pose2
from topomap.core.run_data import NodeData, RunData
from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.optimizer.problem import ClosureEdge

NODES = tuple(NodeData(k, k, np.array([k, 2.0, 0.1]), True) for k in range(3))
RUN = dataclasses.replace(make_run(), nodes=NODES, graph_hash="a", topology_hash="t")


def said(monkeypatch: pytest.MonkeyPatch, then: RunData, now: RunData) -> str:
    monkeypatch.setattr(same, "read_run", {Path("then"): then, Path("now"): now}.__getitem__)
    return same.compare(Path("then"), Path("now"))


def shifted(by: tuple[float, float, float]) -> RunData:
    nodes = tuple(dataclasses.replace(n, pose=n.pose + (np.array(by) if n.node == 1 else 0)) for n in NODES)
    return dataclasses.replace(RUN, nodes=nodes, graph_hash="b")


def test_how_near_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(monkeypatch, RUN, RUN) == "The graph hash is the run's."
    assert said(monkeypatch, dataclasses.replace(RUN, graph_hash=""), RUN) == ""
    near = said(monkeypatch, RUN, shifted((4e-15, 0.0, 2 * np.pi)))
    assert "the same to 4e-15 m and 0 rad" in near
    assert "the same to 5e-06 m and 0.2 rad" in said(monkeypatch, RUN, shifted((3e-6, -4e-6, 0.2)))
    other = dataclasses.replace(shifted((0.0, 0.0, 0.0)), topology_hash="u")
    assert "other nodes, edges or verdicts" in said(monkeypatch, RUN, other)


def test_old_logs_without_a_hash_of_the_topology_are_compared_by_their_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    old = dataclasses.replace(RUN, topology_hash="")
    assert "the same to 0 m" in said(monkeypatch, old, shifted((0.0, 0.0, 0.0)))
    assert "other nodes" in said(monkeypatch, old, dataclasses.replace(shifted((0.0,) * 3), nodes=NODES[:2]))


def test_the_topology_is_all_but_the_numbers() -> None:
    def made(x: float, ends: tuple[int, int] = (0, 1), stamp: int = 7) -> TopoMap:
        topo = TopoMap()
        topo.restore(
            [Node(0, 0.0, None), Node(stamp, x, None)], np.array([[0.0] * 3, [x, 0.0, 0.0]]), [0, 1], [], [], []
        )
        topo.close(ClosureEdge(*ends, Pose2(x, 0.0, 0.0), np.eye(3), 1.0))
        return topo

    verdicts = [(7, 0, "accepted")]
    first = made(1.0).topology_hash(verdicts)
    assert made(1.0 + 1e-15).topology_hash(verdicts) == first
    assert made(1.0 + 1e-15).hash([]) != made(1.0).hash([])
    assert made(1.0, (1, 0)).topology_hash(verdicts) != first
    assert made(1.0, stamp=8).topology_hash(verdicts) != first
    assert made(1.0).topology_hash([(7, 0, "refused")]) != first


def test_a_replay_has_both_hashes(tmp_path: Path) -> None:
    run = topomap.drive(RoundRobot(75), tmp_path / "a", settings=["stack.mission.then=stop"])
    again = topomap.replay(tmp_path / "a" / "run.mcap", tmp_path / "b")
    assert run.summary["topology_hash"] == again.summary["topology_hash"] != ""
    assert len(run.summary["topology_hash"]) == 64
    assert same.compare(run.folder.log, again.folder.log) == "The graph hash is the run's."
