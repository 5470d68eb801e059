"""A run's report: one HTML file that needs nothing else."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from topomap.core.records import Verdict
from topomap.core.run_data import RunData
from topomap.evaluation.closures import closures
from topomap.evaluation.ledger_rows import LedgerRow, ledger
from topomap.evaluation.summary import Summary, plain, summarise, table_rows, write_whole
from topomap.evaluation.trajectory import RelativeError, drift_percent, rpe
from topomap.report.figures.catalogue import FIGURES
from topomap.report.figures.style import data_uri

LEDGER_LIMIT = 400


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure in the report: its name, caption and data URI."""

    name: str
    caption: str
    uri: str


@dataclass(frozen=True, slots=True)
class LedgerPart:
    """One part of the ledger: title, whether it is unfolded, its rows and how many more were left out."""

    title: str
    unfolded: bool
    rows: list[LedgerRow]
    left_out: int


def write_report(run: RunData, path: Path, summary: Summary | None = None) -> None:
    """Write the report of a run as one self-contained HTML file, whole or not at all; raises OSError.

    summary: the run's, where it is known already, which saves judging every pass again.
    """
    write_whole(path, render(run, summary))


def render(run: RunData, summary: Summary | None = None) -> str:
    """Return the report's HTML: the same text for the same run."""
    loader = PackageLoader("topomap.report", package_path="")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    return page.get_template("report.html").render(
        run=run,
        rows=table_rows(summary or summarise(run)) + relative_rows(run),
        pictures=pictures(run),
        missing=[(kind.name, why) for kind in FIGURES if (why := kind.missing(run)) is not None],
        parts=ledger_parts(run),
        config=json.dumps(plain(run.config), indent=2, ensure_ascii=False),
        versions=sorted(run.versions.items()),
    )


def pictures(run: RunData) -> list[Picture]:
    """Return every figure that applies to the run."""
    return [
        Picture(kind.name, kind.caption, data_uri(kind.draw(run), kind.photographs))
        for kind in FIGURES
        if kind.missing(run) is None
    ]


def relative_rows(run: RunData) -> list[tuple[str, str]]:
    """Return rows with the relative errors per 1 m and 10 m and the drift, where the truth has headings."""
    if run.truth is None:
        return []
    rows = []
    for name, poses in (("dead reckoning", run.dead_reckoning), ("map", run.final)):
        near, far = rpe(poses, run.truth, 1.0), rpe(poses, run.truth, 10.0)
        if near is not None and far is not None:
            drift = drift_percent(poses, run.truth)
            text = f"{_relative(near)} per 1 m, {_relative(far)} per 10 m, drift {drift:.2f} %"
            rows.append((f"{name} RPE", text))
    return rows


def ledger_parts(run: RunData) -> list[LedgerPart]:
    """Return the ledger in parts: what was accepted, what was withdrawn or is pending, what was refused."""
    every = closures(run)
    kinds = (
        ("Accepted", (Verdict.ACCEPTED,)),
        ("Withdrawn or pending", (Verdict.WITHDRAWN, Verdict.PENDING)),
        ("Refused", (Verdict.REFUSED,)),
    )
    return [_part(title, ledger(run, every, verdicts)) for title, verdicts in kinds]


def _part(title: str, rows: list[LedgerRow]) -> LedgerPart:
    shown, left_out = rows[:LEDGER_LIMIT], max(len(rows) - LEDGER_LIMIT, 0)
    return LedgerPart(f"{title} ({len(rows)})", title == "Accepted", shown, left_out)


def _relative(error: RelativeError) -> str:
    return f"{error.translation:.3f} m, {math.degrees(error.rotation):.2f}°"
