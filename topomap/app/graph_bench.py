"""The injection test on named pose graphs: finds the files, runs, writes table and figure."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from topomap.bench.pose_graphs.bench import OURS, PeerLimits, Row, averages, bench, to_csv, to_json
from topomap.bench.pose_graphs.figure import injection
from topomap.core.errors import DataError
from topomap.datasets.g2o import read_graph
from topomap.evaluation.summary import write_whole
from topomap.mapping.optimizer.examples import example
from topomap.mapping.pose_graph import PoseGraph

SETS = ("intel", "CSAIL", "manhattanOlson3500", "w10000")


def find_graph(name: str) -> Path:
    """Return a set's file: a path, one under TOPOMAP_DATA/pose-graphs, or gtsam's example. Raises DataError."""
    if Path(name).is_file():
        return Path(name)
    data = os.environ.get("TOPOMAP_DATA")
    local = Path(data) / "pose-graphs" / f"{name}.g2o" if data else None
    if local is not None and local.is_file():
        return local
    try:
        return example(name)
    except DataError as error:
        looked = f"no file {local}" if local else "TOPOMAP_DATA names no folder with pose-graphs/ in it"
        raise DataError(f"no pose graph '{name}': no such file, {looked}, and no example of gtsam") from error


def read_sets(names: Sequence[str]) -> list[PoseGraph]:
    """Return the named pose graphs."""
    return [read_graph(find_graph(name)) for name in names]


def run_bench(
    graphs: Sequence[PoseGraph],
    seeds: Sequence[int],
    peers: Sequence[str],
    limits: PeerLimits,
    told: Callable[[Row], None],
) -> list[Row]:
    """Run the test; `told` is called with every row as it is measured."""
    rows = []
    for graph in graphs:
        for row in bench(graph, seeds, peers=peers, limits=limits):
            told(row)
            rows.append(row)
    return rows


def write_bench(rows: Sequence[Row], out: Path) -> tuple[Path, ...]:
    """Write graphs.json, graphs.csv and graphs.png."""
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "graphs.json", to_json(rows))
    write_whole(out / "graphs.csv", to_csv(rows))
    injection(rows).savefig(out / "graphs.png", dpi=130, metadata={"Software": None})
    return tuple(out / f"graphs.{kind}" for kind in ("json", "csv", "png"))


def table(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """Return the averages as text: graph, false share, method, runs, stopped, least precision, recall, ATE, times."""
    return [_cells(line) for line in averages(rows)]


def _cells(line: dict[str, object]) -> tuple[str, ...]:
    def text(key: str, form: str) -> str:
        value = line[key]
        return format(value, form) if isinstance(value, int | float) else "-"

    name = str(line["method"])
    return (
        str(line["graph"]),
        text("false_share", ".0%"),
        name.upper() if name == OURS else name,
        text("runs", "d"),
        text("stopped", "d"),
        text("precision_min", ".1%"),
        text("kept_false_max", "d"),
        text("recall_mean", ".1%"),
        text("recall_min", ".1%"),
        text("ate_m_mean", ".3f"),
        text("odometry_ate_m", ".3f"),
        text("seconds_mean", ".2f"),
    )
