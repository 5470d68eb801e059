"""topomap closures: the audit trail, one candidate explained, closures changed by hand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.console import console, doubt, table
from topomap.core.records import Verdict

if TYPE_CHECKING:
    from topomap.core.run_data import RunData

COLUMNS = (("time [s]", 8), ("query", 5), ("match", 5), ("verdict", 9), ("truth", 5), ("off", 15), ("similarity", 10),
           ("scores", 60), ("reason", 1))  # fmt: skip


def add_to(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(closures)


def closures(
    file: Path = typer.Argument(help="RUN.mcap; for --withdraw and --add a map file.", metavar="FILE"),
    verdict: Verdict | None = typer.Option(None, help="Only candidates with this verdict."),
    false: bool = typer.Option(False, "--false", help="Only candidates that the truth calls false."),
    limit: int = typer.Option(0, min=0, help="At most so many rows [all]."),
    explain: tuple[str, str] | None = typer.Option(
        None, metavar="A B", help="Why A (query: node, or time as 41.5s) against node B was taken or refused."
    ),
    evaluate: bool = typer.Option(False, "--evaluate", help="Precision and recall of the candidates."),
    withdraw: tuple[int, int] | None = typer.Option(None, metavar="A B", help="Map file: take a closure back."),
    add: tuple[int, int] | None = typer.Option(None, metavar="A B", help="Map file: nodes A and B are one place."),
    out: Path | None = typer.Option(None, help="Folder of pictures [beside FILE], or the new map [FILE-changed]."),
) -> None:
    """List every closure candidate of a run with scores, verdict, reason and truth; explain one; change a map."""
    asked = [name for name, value in (("--explain", explain), ("--evaluate", evaluate or None),
                                      ("--withdraw", withdraw), ("--add", add)) if value is not None]  # fmt: skip
    if len(asked) > 1:
        raise typer.BadParameter(f"{' and '.join(asked)} don't go together")
    if withdraw is not None or add is not None:
        _change(file, withdraw, add, out)
    elif explain is not None:
        _explain(file, explain, out)
    else:
        _list(file, verdict, false, limit, evaluate, out)


def _change(file: Path, withdraw: tuple[int, int] | None, add: tuple[int, int] | None, out: Path | None) -> None:
    from topomap.app import map_surgery

    target = out or file.with_name(f"{file.stem}-changed{file.suffix}")
    if withdraw is not None:
        done = map_surgery.withdraw(file, *withdraw, target)
    elif add is not None:
        done = map_surgery.add(file, *add, target)
    table(done.rows, str(file))
    console.print(str(done.file), soft_wrap=True)


def _explain(file: Path, pair: tuple[str, str], out: Path | None) -> None:
    from topomap.app import closures as trail

    doubt(file, trail.lacking(trail.read(file)), partial=True)
    told = trail.explain(file, *pair, out or file.parent)
    table(told.rows, str(file))
    console.print("The log holds no images of both." if told.figure is None else str(told.figure), soft_wrap=True)


def _list(file: Path, verdict: Verdict | None, false: bool, limit: int, evaluate: bool, out: Path | None) -> None:
    from topomap.app import closures as trail

    run = trail.read(file)
    doubt(file, trail.lacking(run), partial=True)
    if evaluate:
        _evaluate(run, out or file.parent)
        return
    _rows(run, verdict, false, limit)


def _rows(run: RunData, verdict: Verdict | None, false: bool, limit: int) -> None:
    from topomap.app import closures as trail

    rows = trail.table(run, verdict, false)
    _line(f"{len(rows)} closure candidates of {run.world}")
    # one line a candidate however long, so that it can be searched
    _line("  ".join(f"{name:<{width}}" for name, width in COLUMNS))
    for row in rows[: limit or None]:
        cells = (
            row.time,
            row.query,
            row.match,
            row.verdict,
            row.truth,
            row.off,
            row.similarity,
            row.scores,
            row.reason,
        )
        _line("  ".join(f"{cell:<{width}}" for cell, (_, width) in zip(cells, COLUMNS, strict=True)).rstrip())
    if limit and len(rows) > limit:
        console.print(f"{len(rows) - limit} more")


def _line(text: str) -> None:
    """Print one line as it is: without markup, as brackets are units here."""
    console.print(text, soft_wrap=True, markup=False, highlight=False)


def _evaluate(run: RunData, out: Path) -> None:
    from topomap.app import closures as trail

    found, path = trail.evaluation(run, out)
    rows = [
        ("judged", f"{found.judged} candidates, {found.true} true"),
        ("accepted", f"{found.accepted_true} true, {found.accepted_false} false"),
        ("precision", f"{found.precision:.3f}"),
        ("recall", f"{found.recall:.3f}"),
    ]
    for one in found.curves:
        text = f"area {one.auc:.3f}, recall {one.recall_at_full_precision:.3f} at precision 1"
        rows.append((f"by {one.score}", text))
    table(rows, run.world)
    console.print(str(path), soft_wrap=True)
