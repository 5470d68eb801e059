"""The injection test's rows averaged over seeds, as text, CSV and JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from topomap.bench.pose_graphs.bench import OURS, Row
from topomap.evaluation.rows import rows_csv

HEADINGS = ("graph", "kind", "false", "method", "runs", "stopped", "precision, least", "false kept, most", "recall",
            "recall, least", "ATE [m]", "odometry [m]", "time [s]", "CPU [s]", "building [s]")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Cell:
    """One method on all graphs of a kind and share: the worst precision, the mean and least recall, mean ATE [m] and
    the worst, times [s]; None where no run gave any."""

    graph: str
    kind: str
    false_share: float
    method: str
    runs: int
    stopped: int
    precision_min: float | None
    kept_false_max: int
    recall_mean: float | None
    recall_min: float | None
    ate_m_mean: float | None
    ate_m_max: float | None
    odometry_ate_m: float
    seconds_mean: float
    seconds_max: float
    cpu_seconds_mean: float
    building_seconds_mean: float


def cells(rows: Sequence[Row]) -> list[Cell]:
    """Return the averages over seeds, in the order of the rows."""
    groups: dict[tuple[str, str, float, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.graph, row.kind, row.false_share, row.method), []).append(row)
    return [_cell(own) for own in groups.values()]


def _cell(own: list[Row]) -> Cell:
    precisions = [row.precision for row in own if row.precision is not None]
    ates = [row.ate_m for row in own if row.ate_m is not None]
    recalls = [row.recall for row in own if row.recall is not None]
    timed = [row for row in own if row.asked] or own
    return Cell(
        graph=own[0].graph,
        kind=own[0].kind,
        false_share=own[0].false_share,
        method=own[0].method,
        runs=len(own),
        stopped=sum(row.stopped for row in own),
        precision_min=min(precisions, default=None),
        kept_false_max=max(row.kept_false for row in own),
        recall_mean=float(np.mean(recalls)) if recalls else None,
        recall_min=min(recalls, default=None),
        ate_m_mean=float(np.mean(ates)) if ates else None,
        ate_m_max=max(ates, default=None),
        odometry_ate_m=own[0].odometry_ate_m,
        seconds_mean=float(np.mean([row.seconds for row in timed])),
        seconds_max=max(row.seconds for row in timed),
        cpu_seconds_mean=float(np.mean([row.cpu_seconds for row in timed])),
        building_seconds_mean=float(np.mean([row.building_seconds for row in timed])),
    )


def texts(cell: Cell) -> tuple[str, ...]:
    """Return a cell's columns as text, as HEADINGS names them."""

    def text(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    return (
        cell.graph,
        cell.kind,
        f"{cell.false_share:.0%}",
        cell.method.upper() if cell.method == OURS else cell.method,
        str(cell.runs),
        str(cell.stopped),
        text(cell.precision_min, ".3f"),
        str(cell.kept_false_max),
        text(cell.recall_mean, ".3f"),
        text(cell.recall_min, ".3f"),
        text(cell.ate_m_mean, ".3f"),
        f"{cell.odometry_ate_m:.3f}",
        f"{cell.seconds_mean:.2f}",
        f"{cell.cpu_seconds_mean:.2f}",
        f"{cell.building_seconds_mean:.2f}",
    )


def to_json(rows: Sequence[Row], short: Sequence[str]) -> str:
    """Return all rows, their averages and the lines that say where targets are missed as JSON."""
    whole = {
        "rows": [asdict(row) for row in rows],
        "cells": [asdict(cell) for cell in cells(rows)],
        "short": list(short),
    }
    return json.dumps(whole, indent=1) + "\n"


def to_csv(rows: Sequence[Row]) -> str:
    """Return the averages as CSV with a header."""
    return rows_csv(cells(rows), Cell)
