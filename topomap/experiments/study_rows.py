"""What a study found, as rows: for the figures that the project keeps, and for its document."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from topomap.bench.homing.table import JsonValue

HEAD = ("study", "series", "at", "value", "low", "high", "n")
"""Columns of `study_rows`: at is the curve's x, low and high the ends of the 95 % interval."""
CURVE = {"x", "y", "low", "high"}


def study_rows(study: str, values: JsonValue) -> list[tuple[str, ...]]:
    """Return a study's figures, one a row, under HEAD; what is no number, or a list of points, is left out."""
    return [(study, *row) for row in _rows("", values)]


def _rows(path: str, value: JsonValue) -> Iterator[tuple[str, ...]]:
    if isinstance(value, Mapping):
        if set(value) == CURVE:
            yield from _curve(path, value)
        elif "mean_deg" in value:
            yield path, "", *(_said(value[name]) for name in ("mean_deg", "low", "high", "places"))
        else:
            for name, inner in value.items():
                yield from _rows(f"{path}, {name}" if path else str(name), inner)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, "", _said(value), "", "", ""
    elif isinstance(value, Sequence) and not isinstance(value, str) and all(isinstance(v, int | float) for v in value):
        yield from ((path, str(k), _said(v), "", "", "") for k, v in enumerate(value))


def _curve(path: str, curve: Mapping[str, JsonValue]) -> Iterator[tuple[str, ...]]:
    x, y, low, high = (curve[name] for name in ("x", "y", "low", "high"))
    assert isinstance(x, Sequence)
    for at, *three in zip(x, y, low, high, strict=True):  # type: ignore[arg-type]
        yield path, _said(at), *(_said(v) for v in three), ""


def _said(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, int | float) else ""


def study_lines(rows: Sequence[Mapping[str, str]]) -> list[str]:
    """Return a study's rows as lines of a Markdown table, one a series: at: value ± half the interval; ..."""
    series: dict[str, list[str]] = {}
    for row in rows:
        half = f" ± {(float(row['high']) - float(row['low'])) / 2:.2g}" if row["low"] and row["high"] else ""
        at = f"{row['at']}: " if row["at"] else ""
        count = f" ({row['n']})" if row["n"] else ""
        series.setdefault(row["series"], []).append(f"{at}{float(row['value']):.3g}{half}{count}")
    return [f"| {name} | {'; '.join(said)} |" for name, said in series.items()]
