"""Pose graphs: both formats, edges given backwards, and files that are wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from topomap.core.errors import DataError
from topomap.datasets.g2o import read_graph

INFORMATION = "4 0 0 9 0 16"


def graph(folder: Path, text: str, name: str = "g.g2o") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_g2o_and_toro_order_their_information_differently(tmp_path: Path) -> None:
    g2o = read_graph(graph(tmp_path, "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 1 1 0 0 4 0 0 9 0 16\n"))
    toro = read_graph(graph(tmp_path, "EDGE2 0 1 1 0 0 4 0 9 16 0 0\n", "t.graph"))
    expected = np.diag([1 / 4, 1 / 9, 1 / 16])
    assert np.allclose(g2o.odometry_covariance[0], expected)
    assert np.allclose(toro.odometry_covariance[0], expected)
    assert (g2o.nodes, len(g2o.i), g2o.name) == (2, 0, "g")


def test_covariance_turns_into_the_first_frame(tmp_path: Path) -> None:
    """Seen from the end, which looks left, x is what the start calls y."""
    found = read_graph(graph(tmp_path, f"EDGE_SE2 0 1 1 0 {np.pi / 2} 4 0 0 9 0 16\n"))
    assert np.allclose(found.odometry_covariance[0], np.diag([1 / 9, 1 / 4, 1 / 16]))


def test_an_edge_given_backwards_is_turned_round(tmp_path: Path) -> None:
    rows = [f"EDGE2 {j} {i} {i - j} 0 0 1 0 1 1 0 0\n" for j, i in ((1, 0), (2, 1), (2, 0))]
    found = read_graph(graph(tmp_path, "".join(rows)))
    assert np.allclose(found.odometry, [[1, 0, 0], [1, 0, 0]])
    assert (found.i.tolist(), found.j.tolist()) == ([0], [2])
    assert np.allclose(found.relative, [[2, 0, 0]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no edge"),
        ("EDGE_SE2 0 1 1 0\n", ":1: 'EDGE_SE2' needs 11 finite numbers"),
        ("EDGE_SE2 0 1 1 0 x 4 0 0 9 0 16\n", ":1: 'EDGE_SE2' holds a word that is no number"),
        ("EDGE_SE2 0 1 1 0 nan 4 0 0 9 0 16\n", ":1: 'EDGE_SE2' needs 11 finite"),
        ("EDGE_SE3 0 1\n", ":1: row 'EDGE_SE3' is none of"),
        (f"EDGE_SE2 0 0 1 0 0 {INFORMATION}\n", "joins pose 0 with itself"),
        (f"EDGE_SE2 0 1 1 0 0 {INFORMATION}\nEDGE_SE2 0 2 1 0 0 {INFORMATION}\n", "no odometry from pose 1 to pose 2"),
        ("EDGE_SE2 0 1 1 0 0 4 0 0 0 0 16\n", "isn't positive definite"),
    ],
)
def test_bad_files_say_what_is_wrong(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DataError, match=message):
        read_graph(graph(tmp_path, text))


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="can't be read"):
        read_graph(tmp_path / "nothing.g2o")
