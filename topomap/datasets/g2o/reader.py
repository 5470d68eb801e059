"""Pose graphs in the plane: g2o's EDGE_SE2 and TORO's EDGE2, in any chains, with gaps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.geometry import between
from topomap.datasets.g2o.rows import Edges, Vertices, positive_definite, read_rows
from topomap.mapping.pose_graph import PoseGraph, gap_covariance


def read_graph(path: Path) -> PoseGraph:
    """Read a g2o or TORO file. Raises DataError that names file and line.

    Poses are those that edges name, in the order of their ids, which may be any whole numbers. The first edge between
    an id and the next higher one is odometry, every other a closure; edges given backwards are turned round. A step
    without odometry is a gap: as the file's vertices have it, or none, and as good as unknown.
    """
    edges, vertices = read_rows(path)
    names, places = np.unique(edges.ends, return_inverse=True)
    i, j = places.reshape(-1, 2).T
    if len(own := np.flatnonzero(i == j)):
        raise DataError(f"{path}:{edges.line[own[0]]}: an edge joins pose {names[i[own[0]]]} with itself")
    relative, covariance = _forward(path, edges, i > j)
    low, high = np.minimum(i, j), np.maximum(i, j)
    steps = np.flatnonzero(high == low + 1)
    start, first = np.unique(low[steps], return_index=True)
    first = steps[first]
    odometry, spread, gaps = _steps(names, vertices)
    odometry[start], spread[start], gaps[start] = relative[first], covariance[first], False
    closures = np.setdiff1d(np.arange(len(low)), first)
    graph = PoseGraph(
        name=path.name.removesuffix(path.suffix),
        odometry=odometry,
        odometry_covariance=spread,
        i=low[closures],
        j=high[closures],
        relative=relative[closures],
        covariance=covariance[closures],
        gaps=gaps,
        names=names,
    )
    spread[gaps] = gap_covariance(graph.dead_reckoning())
    return replace(graph, odometry_covariance=spread)


def _steps(names: IntArray, vertices: Vertices) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return all steps (N - 1, 3) as the vertices have them, zero where they don't, no covariance yet, all gaps."""
    poses = np.full((len(names), 3), np.nan)
    place = np.searchsorted(names, vertices.ids)
    known = place < len(names)
    known[known] = names[place[known]] == vertices.ids[known]
    poses[place[known]] = vertices.poses[known]
    steps = np.nan_to_num(between(poses[:-1], poses[1:]))
    return steps, np.zeros((len(steps), 3, 3)), np.ones(len(steps), np.bool_)


def _forward(path: Path, edges: Edges, backwards: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Return `i_from_j` and its covariance in the frame of i.

    A file gives the information in the frame of the edge's end (Kuemmerle et al. 2011, eq. 30): for an edge given
    backwards that is already the frame of the earlier pose, but for the lever of the heading.
    """
    relative, covariance = edges.relative, _inverse(path, edges)
    turned = relative.copy()
    turned[backwards] = between(relative[backwards], np.zeros(3))
    carry = np.zeros_like(covariance)
    c, s = np.cos(relative[:, 2]), np.sin(relative[:, 2])
    carry[:, 0, 0], carry[:, 0, 1], carry[:, 1, 0], carry[:, 1, 1], carry[:, 2, 2] = c, -s, s, c, 1.0
    back = np.broadcast_to(-np.eye(3), carry.shape).copy()
    back[:, 0, 2], back[:, 1, 2] = turned[:, 1], -turned[:, 0]
    carry = np.where(backwards[:, None, None], back, carry)
    return turned, carry @ covariance @ carry.transpose(0, 2, 1)


def _inverse(path: Path, edges: Edges) -> FloatArray:
    """Return the covariances (E, 3, 3)."""
    bad = ~positive_definite(edges.information)
    if bad.any():
        line = edges.line[np.argmax(bad)]
        raise DataError(f"{path}:{line}: an edge's information matrix isn't positive definite")
    return np.asarray(np.linalg.inv(edges.information))
