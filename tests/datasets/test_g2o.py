"""Pose graphs: both formats, edges given backwards, gaps and several chains, and files that are wrong."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest

from topomap.core.errors import DataError
from topomap.core.geometry import between
from topomap.datasets.g2o import graph_text, read_graph
from topomap.mapping.optimizer.examples import example
from topomap.mapping.pose_graph import GAP_EXTENTS, GAP_HEADING, PoseGraph

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


def rows(*ends: tuple[int, int], x: float = 1.0) -> str:
    """Edges that go ahead by `x` each."""
    return "".join(f"EDGE_SE2 {i} {j} {x} 0 0 {INFORMATION}\n" for i, j in ends)


def test_a_step_without_odometry_is_a_gap_nearly_unknown(tmp_path: Path) -> None:
    found = read_graph(graph(tmp_path, rows((0, 1), (2, 3), (3, 0))))
    assert found.gaps.tolist() == [False, True, False]
    assert np.allclose(found.odometry, [[1, 0, 0], [0, 0, 0], [1, 0, 0]])
    assert np.allclose(found.odometry_covariance[1], np.diag([GAP_EXTENTS * 2.0, GAP_EXTENTS * 2.0, GAP_HEADING]) ** 2)
    assert np.allclose(found.odometry_covariance[0], np.diag([1 / 4, 1 / 9, 1 / 16]))
    assert (found.i.tolist(), found.j.tolist()) == ([0], [3])


def test_where_vertices_are_given_they_say_what_lies_in_a_gap(tmp_path: Path) -> None:
    corner = f"VERTEX_SE2 1 5 5 {np.pi / 2}\nVERTEX_SE2 2 5 8 {np.pi}\n"
    found = read_graph(graph(tmp_path, corner + rows((0, 1), (2, 3))))
    assert np.allclose(found.odometry[1], [3, 0, np.pi / 2])
    assert found.gaps.tolist() == [False, True, False]


def test_ids_need_not_be_consecutive_nor_small(tmp_path: Path) -> None:
    """Ids as gtsam's symbols give them, which no float holds exactly."""
    first = 0x61 << 56
    ids = [first + 1, first + 2, first + 7]
    found = read_graph(graph(tmp_path, rows((ids[0], ids[1]), (ids[1], ids[2]), (ids[0], ids[2]))))
    assert found.names.tolist() == ids
    assert found.gaps.tolist() == [False, False]
    assert (found.i.tolist(), found.j.tolist()) == ([0], [2])


def test_a_second_edge_of_a_step_is_a_closure_and_closures_keep_the_order_of_the_file(tmp_path: Path) -> None:
    text = rows((0, 3), (0, 1), (1, 2), (2, 3), (3, 1)) + rows((1, 2), (0, 2), x=2.0)
    found = read_graph(graph(tmp_path, text))
    assert np.allclose(found.odometry[:, 0], 1.0)
    assert list(zip(found.i.tolist(), found.j.tolist(), strict=True)) == [(0, 3), (1, 3), (1, 2), (0, 2)]
    assert found.relative[2, 0] == 2.0


def test_both_formats_in_one_file_comments_blank_lines_and_windows_ends(tmp_path: Path) -> None:
    text = (
        "\ufeff# a graph of Ün\r\n\r\nPARAMS_SE2OFFSET 0 0 0 0\r\nFIX 0\r\nEQUIV 0 1\r\nVERTEX2 0 0 0 0\r\n"
        "EDGE2 0 1 1 0 0 4 0 9 16 0 0 # by odometry\r\nEDGE_SE2\t1 2 1 0 0 4 0 0 9 0 16\r\n"
    )
    path = tmp_path / "g.g2o"
    path.write_bytes(text.encode())
    found = read_graph(path)
    assert np.allclose(found.odometry_covariance, np.diag([1 / 4, 1 / 9, 1 / 16]))


def test_tens_of_thousands_of_edges_are_read_fast() -> None:
    path = example("w10000.graph")
    begin = time.process_time()
    found = read_graph(path)
    assert time.process_time() - begin < 1.5
    assert (found.nodes, len(found.i), int(found.gaps.sum())) == (10000, 54312, 0)
    assert found.names.tolist() == list(range(10000))


def test_edges_that_say_toro_and_mean_g2o_are_told_by_their_information(tmp_path: Path) -> None:
    text = "EDGE2 0 1 1 0 0 4 0 0 9 0 16\nEDGE2 1 2 1 0 0 4 0 0 9 0 16\n"
    found = read_graph(graph(tmp_path, text))
    assert np.allclose(found.odometry_covariance, np.diag([1 / 4, 1 / 9, 1 / 16]))


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    turned = rng.normal(size=(4, 3, 3)) * 0.1
    spread = turned @ turned.transpose(0, 2, 1) + np.eye(3) * 0.01
    made = PoseGraph(
        "g", rng.normal(size=(3, 3)), spread[:3], np.array([0]), np.array([3]), rng.normal(size=(1, 3)), spread[3:],
        gaps=np.array([False, True, False]), names=np.array([4, 7, 8, 20]),
    )  # fmt: skip
    poses = rng.normal(size=(4, 3))
    found = read_graph(graph(tmp_path, graph_text(made, poses, np.array([True]))))
    assert np.allclose(found.odometry[[0, 2]], made.odometry[[0, 2]], atol=1e-12)
    assert np.allclose(found.odometry_covariance[[0, 2]], spread[[0, 2]], rtol=1e-9)
    assert np.allclose(found.odometry[1], between(poses[1], poses[2]))
    assert (found.gaps.tolist(), found.names.tolist()) == (made.gaps.tolist(), made.names.tolist())
    assert np.allclose(found.relative, made.relative)
    assert np.allclose(found.covariance, made.covariance, rtol=1e-9)
    assert not len(read_graph(graph(tmp_path, graph_text(made, poses, np.array([False])))).i)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no edge"),
        ("VERTEX_SE2 0 0 0 0\n", "no edge"),
        ("EDGE_SE2 0 1 1 0\n", ":1: 'EDGE_SE2' needs 11 numbers, it has 4"),
        ("\nVERTEX_SE2 0 0 0\n", ":2: 'VERTEX_SE2' needs 4 numbers, it has 3"),
        ("EDGE_SE2 0 1 1 0 x 4 0 0 9 0 16\n", ":1: 'EDGE_SE2' holds 'x' where a finite number belongs"),
        ("EDGE_SE2 0 1 1 0 nan 4 0 0 9 0 16\n", ":1: 'EDGE_SE2' holds 'nan' where a finite number belongs"),
        ("EDGE_SE2 0 1.5 1 0 0 4 0 0 9 0 16\n", ":1: 'EDGE_SE2' holds '1.5' where a pose's id belongs"),
        (f"EDGE_SE2 0 {2**63} 1 0 0 4 0 0 9 0 16\n", ":1: 'EDGE_SE2' holds '9223372036854775808' where a pose's id"),
        (rows((0, 1)) + "LANDMARK2 0 1 1 1 1 0 1\n", ":2: row 'LANDMARK2' is none of EDGE_SE2, EDGE2"),
        ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", ":1: row 'VERTEX_SE3:QUAT' is of a graph in space"),
        (rows((0, 1), (1, 1)), ":2: an edge joins pose 1 with itself"),
        (
            rows((0, 1)) + "EDGE_SE2 0 1 1 0 0 4 0 0 0 0 16\n",
            ":2: an edge's information matrix isn't positive definite",
        ),
        ("EDGE_SE2 0 1 1 0 0 4 0 0 -9 0 16\n", ":1: an edge's information matrix isn't positive definite"),
    ],
)
def test_bad_files_say_what_is_wrong(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DataError, match=re.escape(message)) as raised:
        read_graph(graph(tmp_path, text))
    assert "\n" not in str(raised.value)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="can't be read"):
        read_graph(tmp_path / "nothing.g2o")
    (tmp_path / "picture.g2o").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(DataError, match=r"picture\.g2o: can't be read"):
        read_graph(tmp_path / "picture.g2o")
