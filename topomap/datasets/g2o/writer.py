"""A pose graph with its optimised poses as g2o text."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.pose_graph import PoseGraph


def graph_text(graph: PoseGraph, poses: FloatArray, kept: BoolArray) -> str:
    """Return poses (N, 3), odometry without its gaps and the kept of the closures (M,) under the graph's own ids.

    The first pose is fixed. g2o takes an edge's information in the frame of its end (Kuemmerle et al. 2011, eq. 30).
    """
    first = np.flatnonzero(~graph.gaps)
    rows = [
        *_vertices(graph.names, poses),
        f"FIX {graph.names[0]}",
        *_edges(graph.names, first, first + 1, graph.odometry[first], graph.odometry_covariance[first]),
        *_edges(graph.names, graph.i[kept], graph.j[kept], graph.relative[kept], graph.covariance[kept]),
    ]
    return "\n".join([*rows, ""])


def _vertices(names: IntArray, poses: FloatArray) -> list[str]:
    named = zip(names.tolist(), poses.tolist(), strict=True)
    return [f"VERTEX_SE2 {name} {x!r} {y!r} {heading!r}" for name, (x, y, heading) in named]


def _edges(names: IntArray, i: IntArray, j: IntArray, relative: FloatArray, covariance: FloatArray) -> list[str]:
    to_end = np.zeros_like(covariance)
    c, s = np.cos(relative[:, 2]), np.sin(relative[:, 2])
    to_end[:, 0, 0], to_end[:, 0, 1], to_end[:, 1, 0], to_end[:, 1, 1], to_end[:, 2, 2] = c, s, -s, c, 1.0
    information = np.linalg.inv(to_end @ covariance @ to_end.transpose(0, 2, 1))
    rows, columns = np.triu_indices(3)
    numbers = np.column_stack([relative, information[:, rows, columns]]).tolist()
    ends = zip(names[i].tolist(), names[j].tolist(), numbers, strict=True)
    return [" ".join(["EDGE_SE2", str(a), str(b), *map(repr, row)]) for a, b, row in ends]
