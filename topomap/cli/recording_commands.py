"""bench recording: how firmly the map of a recorded drive stands."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.bench_commands import OUT, benches
from topomap.cli.console import console, grid, progress, show_wide

HEADINGS = ("what is varied", "runs", "ATE SE(2) [m]", "Sim(2) [m]", "kept", "false, most", "gross, most",
            "curvature [rad/m]", "time, most [s]", "worst")  # fmt: skip


def add_to(app: typer.Typer) -> None:
    """Add the command to `topomap bench`, which bench_commands adds to the program."""
    benches.command()(recording)


def recording(
    path: Path = typer.Argument(help="Folder of a recording in the TUC format."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    out: Path = typer.Option(OUT / "recording", help="Folder for table and figure."),
) -> None:
    """Map a recorded drive with every setting moved by 20 %, other starting curvatures, a tenth of its candidates."""
    from topomap.app import recordings
    from topomap.app.words import cores
    from topomap.bench.recordings.stability import variations, worst

    which = variations()
    with progress("recording", len(which)) as advance:
        rows = recordings.bench(path, which, jobs or cores(), advance)
    shown = grid(f"{path.resolve().name}: least to most over the variations", HEADINGS)
    for group, runs, best, last in worst(rows):
        own = [row for row in rows if row.group == group]
        shown.add_row(
            group, str(runs), _span([r.se2_m for r in own], ".2f"), _span([r.sim2_m for r in own], ".2f"),
            _span([r.kept for r in own], "d"), _most([r.false for r in own]), _most([r.gross for r in own]),
            _span([r.curvature for r in own], ".4f"), f"{max(r.seconds for r in own):.1f}",
            last.name if best is not last else "",
        )  # fmt: skip
    show_wide(shown)
    for written in recordings.write_bench(rows, out):
        console.print(str(written), soft_wrap=True)


def _span(values: list[float | None], form: str) -> str:
    known = [v for v in values if v is not None]
    if not known:
        return "-"
    least, most = format(min(known), form), format(max(known), form)
    return least if least == most else f"{least} to {most}"


def _most(values: list[int | None]) -> str:
    known = [v for v in values if v is not None]
    return str(max(known)) if known else "-"
