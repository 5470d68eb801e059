"""Pose graphs in the plane: g2o's EDGE_SE2 and TORO's EDGE2."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.geometry import between
from topomap.mapping.pose_graph import PoseGraph

# where row and column of the information matrix stand among an edge's six last numbers
UPPER = {"EDGE_SE2": ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)),
         "EDGE2": ((0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2))}  # fmt: skip
IGNORED = {"VERTEX_SE2", "VERTEX2", "EQUIV", "FIX"}


def read_graph(path: Path) -> PoseGraph:
    """Read a g2o or TORO file; edges given backwards are turned round. Raises DataError that names file and line."""
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    edges, information = [], []
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if words and words[0] in UPPER:
            numbers = _numbers(f"{path}:{number}", words)
            edges.append(numbers[:5])
            information.append(_matrix(words[0], numbers[5:]))
        elif words and words[0] not in IGNORED:
            raise DataError(f"{path}:{number}: row '{words[0]}' is none of {', '.join((*UPPER, *sorted(IGNORED)))}")
    if not edges:
        raise DataError(f"{path}: no edge 'EDGE_SE2' or 'EDGE2'")
    return _graph(path, np.array(edges), np.array(information))


def _numbers(where: str, words: list[str]) -> list[float]:
    try:
        numbers = [float(word) for word in words[1:]]
    except ValueError:
        raise DataError(f"{where}: '{words[0]}' holds a word that is no number") from None
    if len(numbers) != 11 or not np.isfinite(numbers).all():
        raise DataError(f"{where}: '{words[0]}' needs 11 finite numbers, it has {len(numbers)}")
    return numbers


def _matrix(kind: str, numbers: list[float]) -> FloatArray:
    matrix = np.zeros((3, 3))
    for (row, column), value in zip(UPPER[kind], numbers, strict=True):
        matrix[row, column] = matrix[column, row] = value
    return matrix


def _graph(path: Path, edges: FloatArray, information: FloatArray) -> PoseGraph:
    ends = edges[:, :2].astype(np.int64)
    names, places = np.unique(ends, return_inverse=True)
    i, j = places.reshape(-1, 2).T
    if np.any(i == j):
        raise DataError(f"{path}: an edge joins pose {names[i[i == j][0]]} with itself")
    relative, covariance = _forward(path, edges[:, 2:5], information, i > j)
    low, high = np.minimum(i, j), np.maximum(i, j)
    first = _odometry(path, low, high, len(names))
    rest = np.setdiff1d(np.arange(len(low)), first)
    name = path.name.removesuffix(path.suffix)
    return PoseGraph(name, relative[first], covariance[first], low[rest], high[rest], relative[rest], covariance[rest])


def _odometry(path: Path, low: IntArray, high: IntArray, nodes: int) -> IntArray:
    """Return the first edge between each pose and the next; a second one is a closure."""
    steps = np.flatnonzero(high == low + 1)
    start, first = np.unique(low[steps], return_index=True)
    if len(start) != nodes - 1:
        missing = int(np.setdiff1d(np.arange(nodes - 1), start)[0])
        raise DataError(f"{path}: no odometry from pose {missing} to pose {missing + 1}")
    return np.asarray(steps[first], np.int64)


def _forward(
    path: Path, relative: FloatArray, information: FloatArray, backwards: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return `i_from_j` and its covariance in the frame of i.

    A file gives the information in the frame of the edge's end (Kuemmerle et al. 2011, eq. 30): for an edge given
    backwards that is already the frame of the earlier pose, but for the lever of the heading.
    """
    try:
        covariance = np.linalg.inv(information)
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise DataError(f"{path}: an edge's information matrix isn't positive definite") from None
    turned = relative.copy()
    turned[backwards] = between(relative[backwards], np.zeros(3))
    carry = np.zeros_like(covariance)
    c, s = np.cos(relative[:, 2]), np.sin(relative[:, 2])
    carry[:, 0, 0], carry[:, 0, 1], carry[:, 1, 0], carry[:, 1, 1], carry[:, 2, 2] = c, -s, s, c, 1.0
    back = np.broadcast_to(-np.eye(3), carry.shape).copy()
    back[:, 0, 2], back[:, 1, 2] = turned[:, 1], -turned[:, 0]
    carry = np.where(backwards[:, None, None], back, carry)
    return turned, carry @ covariance @ carry.transpose(0, 2, 1)
