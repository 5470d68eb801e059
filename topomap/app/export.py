"""Runs in the formats other tools read: TUM trajectories and g2o pose graphs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.run_data import RunData
from topomap.evaluation.summary import write_whole
from topomap.evaluation.trajectory import truth_in_map
from topomap.mapping.graph import TopoMap
from topomap.mapping.map_problem import map_problem
from topomap.mapping.mapfile import load_map
from topomap.mapping.optimizer import relative_edges
from topomap.recording.run_reader import read_run

TUM_COLUMNS = "timestamp[s] x[m] y[m] z[m] qx qy qz qw"


def export_run(log: Path, out: Path, tum: bool, g2o: bool) -> tuple[list[Path], str]:
    """Write what was asked for into a folder; return the files and, if anything is, what is wrong with the log.

    The g2o graph is made of the finished map, which lies beside the log. Raises DataError, also where that map is
    another run's.
    """
    run = read_run(log)
    topo = _map_of(run, log.with_suffix(".topomap")) if g2o else None
    written = write_tum(run, out) if tum else []
    if topo is not None:
        written += write_texts(out, {"map.g2o": g2o_text(topo), "map-nodes.csv": nodes_text(topo)})
    return written, "" if run.log_state == "whole" else f"{run.log_state}: {run.log_note}"


def _map_of(run: RunData, path: Path) -> TopoMap:
    """Return the map beside a log. Raises DataError where the log's run didn't write it."""
    topo = load_map(path)
    stamps = [node.stamp_ns for node in topo.nodes]
    if not run.graph_hash or stamps != [node.stamp_ns for node in run.nodes]:
        raise DataError(f"{path}: isn't the map of this log's run: a run that was cut off has none")
    return topo


def write_tum(run: RunData, out: Path) -> list[Path]:
    """Write the run's trajectories into a folder as TUM files; return them. Raises DataError."""
    texts = {
        f"{name}.tum": f"# {TUM_COLUMNS}\n# {frame}\n{tum_rows(run.stamps_ns, poses)}"
        for name, (poses, frame) in trajectories(run).items()
    }
    return write_texts(out, texts)


def write_texts(out: Path, texts: dict[str, str]) -> list[Path]:
    """Write texts into a folder by file name; return the files. Raises DataError."""
    try:
        for name, text in texts.items():
            write_whole(out / name, text)
    except OSError as error:
        raise DataError(f"{out}: can't be written ({error.strerror})") from error
    return [out / name for name in texts]


def trajectories(run: RunData) -> dict[str, tuple[FloatArray, str]]:
    """Return the run's trajectories (N, 3) by name, all in the map frame, and how each came to be in it."""
    frame = "map frame: it starts at the first pose"
    own = {"map": run.final, "online": run.online, "dead_reckoning": run.dead_reckoning}
    known = {name: (poses, frame) for name, poses in own.items()}
    if run.truth is None:
        return known
    truth, how = truth_in_map(run)
    if not np.isfinite(truth[:, 2]).all():
        how += "; where the true heading isn't known it is written as 0"
    return known | {"truth": (truth, f"{frame}; the truth was {how}")}


def tum_rows(stamps_ns: IntArray, poses: FloatArray) -> str:
    """Return `t tx ty tz qx qy qz qw` lines of stamps (N,) and poses (N, 3); rows with NaN are left out."""
    rows = []
    for stamp, (x, y, heading) in zip(stamps_ns.tolist(), poses.tolist(), strict=True):
        if math.isfinite(x) and math.isfinite(y):
            half = heading / 2 if math.isfinite(heading) else 0.0
            second, rest = divmod(stamp, 10**9)
            rows.append(f"{second}.{rest:09d} {x:.9f} {y:.9f} 0 0 0 {math.sin(half):.9f} {math.cos(half):.9f}\n")
    return "".join(rows)


def g2o_text(topo: TopoMap) -> str:
    """Return the map as g2o: VERTEX_SE2 numbered in travel order, the first fixed, and an EDGE_SE2 a constraint.

    Odometry is calibrated and joined with the turns measured over the same edge; turns over several edges leave the
    position open. Raises TopomapError for a map of one node.
    """
    vertices = [f"VERTEX_SE2 {k} {x!r} {y!r} {h!r}" for k, (x, y, h) in enumerate(topo.poses[topo.chain].tolist())]
    edges = relative_edges(map_problem(topo))
    place = _places(topo)
    ends = np.column_stack([place[edges.i], place[edges.j]]).tolist()
    numbers = np.column_stack([edges.relative, _information(edges.relative, edges.covariance)]).tolist()
    rows = [" ".join(["EDGE_SE2", *map(str, pair), *map(repr, row)]) for pair, row in zip(ends, numbers, strict=True)]
    return "\n".join([*vertices, *rows, "FIX 0", ""])


def nodes_text(topo: TopoMap) -> str:
    """Return which node of the map each vertex of the g2o file is, as CSV."""
    rows = [(k, node, topo.nodes[node]) for k, node in enumerate(topo.chain)]
    lines = [f"{k},{node},{kept.stamp_ns},{int(kept.snapshot is not None)}" for k, node, kept in rows]
    return "\n".join(["vertex,node,stamp_ns,snapshot", *lines, ""])


def _places(topo: TopoMap) -> IntArray:
    """Return each node's (N,) place in travel order."""
    place = np.empty(len(topo.chain), np.int64)
    place[topo.chain] = np.arange(len(topo.chain))
    return place


def _information(relative: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return (E, 6) the upper triangles of the information matrices of edges whose covariance is in the start's frame.

    g2o and gtsam measure the error in the frame of the measured end (Kuemmerle et al. 2011, eq. 30).
    """
    to_end = np.zeros_like(covariance)
    c, s = np.cos(relative[:, 2]), np.sin(relative[:, 2])
    to_end[:, 0, 0], to_end[:, 0, 1], to_end[:, 1, 0], to_end[:, 1, 1], to_end[:, 2, 2] = c, s, -s, c, 1.0
    information = np.linalg.inv(to_end @ covariance @ to_end.transpose(0, 2, 1))
    rows, columns = np.triu_indices(3)
    return np.asarray(information[:, rows, columns])
