"""Anybody's pose graph with doubtful closures: read, optimised, written."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.app.folder import make_writable
from topomap.app.wiring import versions
from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.datasets.g2o import graph_text, read_graph
from topomap.evaluation.graph_verdicts import VerdictRow, graph_rows, graph_summary, verdict_rows
from topomap.evaluation.rows import rows_csv
from topomap.evaluation.summary import plain, write_whole
from topomap.mapping.graph_engine import GraphVerdicts, optimise_graph
from topomap.mapping.pose_graph import PoseGraph
from topomap.report.figures.graph_map import graph_map
from topomap.report.figures.style import png
from topomap.report.graph_report import graph_report


@dataclass(frozen=True, slots=True)
class Optimised:
    """What `topomap optimize` made: rows for a terminal and the files it wrote."""

    rows: list[tuple[str, str]]
    files: tuple[Path, ...]


def optimize(path: Path, out: Path | None, progress: Callable[[float, str], None]) -> Optimised:
    """Optimise the pose graph of a file; write poses, verdicts, picture, summary and report. Raises DataError.

    out: a folder, `runs/NAME` if None. progress hears the share done and what is done next.
    """
    graph = read_graph(path)
    folder = out or default_folder(path)
    make_writable(folder)
    begin = time.perf_counter()
    verdicts = optimise_graph(graph, progress)
    seconds = time.perf_counter() - begin
    texts = _texts(path, graph, verdicts, seconds)
    try:
        for name, text in texts.items():
            write_whole(folder / name, text)
    except OSError as error:
        raise DataError(f"{folder}: can't be written ({error.strerror})") from error
    return Optimised(graph_rows(graph, verdicts, seconds), tuple(folder / name for name in texts))


def default_folder(path: Path) -> Path:
    """Return `runs/NAME`, or `runs/NAME-2` and so on where another file's results lie already."""
    base, number = Path("runs") / path.stem, 1
    folder = base
    while folder.exists() and _source(folder) != str(path.resolve()):
        number += 1
        folder = base.with_name(f"{base.name}-{number}")
    return folder


def _source(folder: Path) -> str | None:
    """Return which file a folder's results are of."""
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return str(summary.get("file")) if isinstance(summary, dict) else None


def _texts(path: Path, graph: PoseGraph, verdicts: GraphVerdicts, seconds: float) -> dict[str, str | bytes]:
    summary = {"file": str(path.resolve()), **graph_summary(graph, verdicts, seconds), "versions": plain(versions())}
    picture = graph_map(graph, verdicts)
    return {
        "optimized.g2o": graph_text(graph, verdicts.poses, verdicts.inlier),
        "poses.tum": _tum(graph.names, verdicts.poses),
        "closures.csv": rows_csv(verdict_rows(graph, verdicts), VerdictRow),
        "map.png": png(picture),
        "summary.json": json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n",
        "report.html": graph_report(graph, verdicts, seconds, picture),
    }


def _tum(names: IntArray, poses: FloatArray) -> str:
    """Return `t tx ty tz qx qy qz qw` lines of poses (N, 3); the time is the pose's id (N,)."""
    s, c = np.sin(poses[:, 2] / 2), np.cos(poses[:, 2] / 2)
    numbers = np.column_stack([poses[:, :2], s, c]).tolist()
    rows = zip(names.tolist(), numbers, strict=True)
    return "".join(f"{name} {x:.9f} {y:.9f} 0 0 0 {qz:.9f} {qw:.9f}\n" for name, (x, y, qz, qw) in rows)
