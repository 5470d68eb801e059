"""The injection test on named pose graphs: finds the files, runs, writes table and figures."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from topomap.app.folder import make_writable
from topomap.app.sweep import source_digest
from topomap.app.wiring import versions
from topomap.bench.pool import Store
from topomap.bench.pose_graphs.bench import Design, Row, bench
from topomap.bench.pose_graphs.figure import injection, kinds
from topomap.bench.pose_graphs.table import cells, to_csv, to_json
from topomap.bench.pose_graphs.targets import shortfalls
from topomap.core.errors import DataError
from topomap.datasets.g2o import read_graph
from topomap.evaluation.summary import write_whole
from topomap.mapping.optimizer.examples import example
from topomap.mapping.pose_graph import PoseGraph
from topomap.report.figures.style import png


def find_graph(name: str) -> Path:
    """Return a graph's file: a path, one under TOPOMAP_DATA/pose-graphs, or gtsam's example. Raises DataError."""
    if Path(name).is_file():
        return Path(name)
    data = os.environ.get("TOPOMAP_DATA")
    local = Path(data or "TOPOMAP_DATA") / "pose-graphs" / f"{name}.g2o"
    if data and local.is_file():
        return local
    try:
        return example(name)
    except DataError as error:
        hint = "" if data else " (set TOPOMAP_DATA to the folder of recorded data)"
        raise DataError(f"no pose graph '{name}': neither a file nor {local}{hint} nor an example of gtsam") from error


def read_sets(names: Sequence[str]) -> list[PoseGraph]:
    """Return the named pose graphs."""
    return [read_graph(find_graph(name)) for name in names]


def run_bench(
    graphs: Sequence[PoseGraph], design: Design, out: Path, told: Callable[[tuple[Row, ...]], None],
    store: Store | None = None,
) -> tuple[list[Row], tuple[Path, ...]]:  # fmt: skip
    """Run the test and write what is known after each graph, as it may take hours; `told` hears the rows of every graph
    made as they are measured. Raises DataError if the folder can't be written."""
    make_writable(out)
    rows: list[Row] = []
    written: tuple[Path, ...] = ()
    for graph in graphs:
        for made in bench(graph, design, store, json.dumps([versions(), source_digest()])):
            told(made)
            rows += made
        written = _write(rows, out)
    return rows, written


def _write(rows: Sequence[Row], out: Path) -> tuple[Path, ...]:
    """Write graphs.json, graphs.csv and a picture a kind."""
    contents: dict[str, str | bytes] = {"graphs.json": to_json(rows, short(rows)), "graphs.csv": to_csv(rows)}
    contents |= {f"graphs-{kind}.png": png(injection(rows, kind)) for kind in kinds(rows)}
    try:
        for name, content in contents.items():
            write_whole(out / name, content)
    except OSError as error:
        raise DataError(f"{out}: the output folder can't be written ({error.strerror})") from error
    return tuple(out / name for name in contents)


def short(rows: Sequence[Row]) -> list[str]:
    """Return a line a target that is missed."""
    return shortfalls(cells(rows))
