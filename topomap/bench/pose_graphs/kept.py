"""The injection test's rows as the project keeps them, a line a graph made and contestant, and back."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from topomap.bench.pose_graphs.bench import OURS, Row

ODOMETRY = "odometry"
KEYS = 5  # the first cells tell rows apart
KEPT = ("graph", "kind", "share", "seed", "contestant", "nodes", "true", "false", "kept true", "kept false",
        "precision", "recall", "ATE [m]", "odometry [m]", "seconds", "CPU [s]", "building [s]",
        "stopped", "limit [s]")  # fmt: skip


def kept_rows(rows: Sequence[Row], limit: float) -> list[tuple[str, ...]]:
    """Return lines under KEPT, odometry's own after each of ours; limit [s]: after which a peer was stopped."""
    lines = []
    for row in rows:
        lines.append(_line(row, f"{limit:g}" if row.method != OURS else ""))
        if row.method == OURS:
            lines.append(_line(_odometry(row), ""))
    return lines


def _odometry(row: Row) -> Row:
    """Return what odometry alone makes of a row's graph: it takes nothing for true."""
    return Row(row.graph, row.nodes, row.kind, row.false_share, ODOMETRY, row.seed, row.true, row.false, 0, 0, None,
               0.0, row.odometry_ate_m, row.odometry_ate_m, 0.0, 0.0, 0.0, False)  # fmt: skip


def _line(row: Row, limit: str) -> tuple[str, ...]:
    return (
        row.graph, row.kind, f"{row.false_share:g}", f"{row.seed}", row.method, f"{row.nodes}", f"{row.true}",
        f"{row.false}", f"{row.kept_true}", f"{row.kept_false}", _text(row.precision, 5), _text(row.recall, 5),
        _text(row.ate_m, 4), f"{row.odometry_ate_m:.4f}", f"{row.seconds:.3f}", f"{row.cpu_seconds:.3f}",
        f"{row.building_seconds:.3f}", _stopped(row), limit,
    )  # fmt: skip


def _stopped(row: Row) -> str:
    return ("yes" if row.asked else "before") if row.stopped else "no"


def _text(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def rows_of(lines: Iterable[dict[str, str]]) -> list[Row]:
    """Return the rows that kept lines tell, odometry's own left out. Raises ValueError, KeyError."""
    return [
        Row(
            graph=line["graph"],
            nodes=int(line["nodes"]),
            kind=line["kind"],
            false_share=float(line["share"]),
            method=line["contestant"],
            seed=int(line["seed"]),
            true=int(line["true"]),
            false=int(line["false"]),
            kept_true=int(line["kept true"]),
            kept_false=int(line["kept false"]),
            precision=_number(line["precision"]),
            recall=_number(line["recall"]),
            ate_m=_number(line["ATE [m]"]),
            odometry_ate_m=float(line["odometry [m]"]),
            seconds=float(line["seconds"]),
            cpu_seconds=float(line["CPU [s]"]),
            building_seconds=float(line["building [s]"]),
            stopped=line["stopped"] != "no",
            asked=line["stopped"] != "before",
        )
        for line in lines
        if line["contestant"] != ODOMETRY
    ]


def _number(text: str) -> float | None:
    return None if text == "-" else float(text)
