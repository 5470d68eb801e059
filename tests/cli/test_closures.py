"""topomap closures on a small log and map."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from maps import RIG, STEP_NS, increments
from typer.testing import CliRunner

from topomap.app import map_surgery
from topomap.cli.main import app
from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.mapfile import load_map, save_map
from topomap.mapping.optimizer import ClosureEdge


def picture(k: int) -> bytes:
    """A view of its own for each place of the square."""
    noise = np.random.default_rng(k % 16).integers(0, 255, (10, 72, 3), np.uint8)
    good, encoded = cv2.imencode(".png", noise)
    assert good
    return encoded.tobytes()


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Two laps of a square, closed at three places."""
    topo = TopoMap()
    topo.add(Node(0, 0.0, Snapshot(picture(0), None, RIG)), None)
    for k in range(1, 33):
        turn = np.pi / 10 + 0.002 if k % 4 == 0 else 0.002
        topo.add(Node(5 * k * STEP_NS, 0.5 * k, Snapshot(picture(k), None, RIG)), increments(5 * (k - 1), 5, turn))
    for k in (2, 6, 10):
        topo.close(ClosureEdge(k, k + 16, Pose2(), np.diag([0.1, 0.1, 0.05]) ** 2))
    save_map(topo, tmp_path / "run.topomap")
    return tmp_path / "run.topomap"


def test_withdraw_and_add_give_the_closure_back(saved: Path) -> None:
    run = CliRunner()
    first, second = saved.with_name("first.topomap"), saved.with_name("second.topomap")
    done = run.invoke(app, ["closures", str(saved), "--withdraw", "6", "22", "--out", str(first)])
    assert done.exit_code == 0, done.output
    assert "withdrawn: nodes 6 and 22" in done.output
    assert [(c.i, c.j) for c in load_map(first).closures] == [(2, 18), (10, 26)]
    assert len(load_map(saved).closures) == 3, "the map that was read stays as it was"
    done = run.invoke(app, ["closures", str(first), "--add", "6", "22", "--out", str(second)])
    assert done.exit_code == 0, done.output
    assert (6, 22) in [(c.i, c.j) for c in load_map(second).closures]


@pytest.mark.parametrize(
    ("a", "b", "message"),
    [
        (6, 99, "no node 99: the map has nodes 0 to 32"),
        (6, 6, "not one with itself"),
        (2, 18, "closed already"),
        (0, 8, "contradicts it"),
    ],
)
def test_what_cannot_be_added(saved: Path, a: int, b: int, message: str) -> None:
    out = saved.with_name("out.topomap")
    with pytest.raises(TopomapError, match=message):
        map_surgery.add(saved, a, b, out)
    assert not out.exists()


def test_what_cannot_be_withdrawn(saved: Path) -> None:
    with pytest.raises(TopomapError, match=r"no closure between nodes 0 and 9 .there are 2-18, 6-22, 10-26"):
        map_surgery.withdraw(saved, 0, 9, saved.with_name("out.topomap"))


def test_two_wishes_at_once_are_refused(saved: Path) -> None:
    done = CliRunner().invoke(app, ["closures", str(saved), "--withdraw", "2", "18", "--evaluate"])
    assert done.exit_code == 2
    assert "don't go together" in done.output
