"""The homing table on paper: terminal cells, JSON and CSV."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from topomap.bench.homing.bench import Table
from topomap.bench.homing.rows import Row
from topomap.evaluation.statistics import Interval
from topomap.evaluation.summary import write_whole

HEADINGS = (
    "method",
    "mean error [deg]",
    "sd",
    "< 45",
    "45-90",
    "> 90",
    "answered",
    "catchment",
    "success",
    "path ratio",
    "behind best [deg]",
    "ms",
)
JsonValue = str | int | float | bool | None | Sequence["JsonValue"] | Mapping[str, "JsonValue"]


def cells(row: Row) -> list[str]:
    """Return a row's cells as text, under `HEADINGS`."""
    return [
        row.method,
        _plus_minus(row.mean),
        _number(row.sd, 1),
        _share(row.below_45),
        _share(row.to_90),
        _share(row.above_90),
        "-" if row.answered is None else f"{100 * row.answered:.0f} %",
        _share(row.catchment),
        _share(row.success),
        _number(row.path_ratio, 2),
        _span(row.behind),
        _number(row.ms, 2),
    ]


def unfit(table: Table) -> dict[str, list[str]]:
    """Return the names of the methods without figures by the reason why."""
    reasons: dict[str, list[str]] = {}
    for row in table.rows:
        if row.unfit is not None:
            reasons.setdefault(row.unfit, []).append(row.method)
    return reasons


def title(table: Table) -> str:
    """Return the table's title in words."""
    places = max((row.places for row in table.rows), default=0)
    seeds = f"{len(table.seeds)} seed{'s' if len(table.seeds) != 1 else ''}"
    heading = "compass given" if table.compass_error is None else f"compass {table.compass}"
    if table.compass_error is not None:
        heading += f" ({table.compass_error.value:.1f} deg off, {table.compass_ms or 0.0:.1f} ms)"
    return f"{table.environment}: {places} places, {seeds}, {heading}"


def as_json(table: Table) -> dict[str, JsonValue]:
    """Return the table as plain JSON values; what wasn't measured is null."""
    return {
        "environment": table.environment,
        "compass": table.compass,
        "seeds": list(table.seeds),
        "homes": [list(ground.home) for ground in table.entries[0].grounds] if table.entries else [],
        "compass_error_deg": _plain(asdict(table.compass_error)) if table.compass_error else None,
        "compass_ms": table.compass_ms,
        "rows": [_plain(asdict(row)) for row in table.rows],
    }


KEPT = ("environment", "compass", "method", "within", "seeds", "n", "mean", "low", "high", "below_45", "ms")
"""Columns of `kept_rows`."""


def kept_rows(table: Table) -> list[tuple[str, ...]]:
    """Return what is kept of a table in the repository, under `KEPT`: errors in degrees, shares, milliseconds.

    within [m]: only places this near to home counted, "" for all of them.
    """
    seeds = " ".join(map(str, table.seeds))
    return [
        (table.environment, table.compass, r.method, _within(table), seeds, str(r.places), *_figures(r))
        for r in table.rows
        if r.mean is not None
    ]


def _within(table: Table) -> str:
    metres = min(ground.within for entry in table.entries for ground in entry.grounds)
    return "" if metres == float("inf") else f"{metres:g}"


def _figures(row: Row) -> tuple[str, ...]:
    assert row.mean is not None
    assert row.below_45 is not None
    assert row.ms is not None
    errors = (f"{v:.2f}" for v in (row.mean.value, row.mean.low, row.mean.high))
    return *errors, f"{row.below_45.value:.3f}", f"{row.ms:.3g}"


def write_table(table: Table, folder: Path) -> list[Path]:
    """Write table.json and table.csv into a folder and return their paths."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    flat = [_flat(row) for row in table.rows]
    columns = list(flat[0]) if flat else []
    writer.writerow(columns)
    writer.writerows([[line[name] for name in columns] for line in flat])
    json_path, csv_path = folder / "table.json", folder / "table.csv"
    write_whole(json_path, json.dumps(as_json(table), indent=2, allow_nan=False) + "\n")
    write_whole(csv_path, text.getvalue())
    return [json_path, csv_path]


def _flat(row: Row) -> dict[str, str]:
    out: dict[str, str] = {}
    for name, value in asdict(row).items():
        if name in _INTERVALS:
            for part in ("value", "low", "high"):
                key = name if part == "value" else f"{name}_{part}"
                out[key] = "" if value is None else _csv(value[part])
        else:
            out[name] = "" if value is None else _csv(value)
    return out


_INTERVALS = ("mean", "below_45", "to_90", "above_90", "catchment", "success", "behind")


def _csv(value: float | str) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _plain(value: object) -> JsonValue:
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, float):
        return round(value, 6) if value == value else None
    assert value is None or isinstance(value, str | int)
    return value


def _plus_minus(interval: Interval | None) -> str:
    if interval is None:
        return "-"
    return f"{interval.value:.1f} ± {interval.high - interval.value:.1f}"


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _share(interval: Interval | None) -> str:
    if interval is None:
        return "-"
    return f"{100 * interval.value:.1f} %"


def _span(interval: Interval | None) -> str:
    if interval is None:
        return "-"
    if interval.value == interval.low == interval.high == 0.0:
        return "best"
    return f"{interval.value:+.1f} [{interval.low:+.1f}, {interval.high:+.1f}]"
