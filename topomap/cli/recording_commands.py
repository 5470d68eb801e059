"""bench recording and bench drive: how firmly the maps of recorded drives stand."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.bench_commands import KEEP, OUT, benches
from topomap.cli.console import console, grid, progress, show_wide
from topomap.cli.words import CONFIG, SETTINGS

HEADINGS = ("what is varied", "runs", "ATE SE(2) [m]", "Sim(2) [m]", "kept", "false, most", "gross, most",
            "curvature [rad/m]", "time, most [s]", "worst")  # fmt: skip


DRIVE_HEADINGS = ("scale", "every", "draw", "declared", "dead reckoning [m]", "map [m]", "accepted", "false", "recall",
                  "distance scale", "rotation scale", "map kept")  # fmt: skip


def add_to(app: typer.Typer) -> None:
    """Add the commands to `topomap bench`, which bench_commands adds to the program."""
    benches.command()(recording)
    benches.command()(drive)


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


def drive(
    path: Path = typer.Argument(help="Folder with drive.csv, rig.json and panoramas.", metavar="FOLDER"),
    draws: int = typer.Option(3, min=1, help="Draws of the made odometry's errors."),
    scale: list[float] = typer.Option([1.0], min=0.01, help="Make the world so many times larger; may repeat."),
    every: list[int] = typer.Option([1], min=1, help="Take every so many-th frame; may repeat."),
    declared: list[float] = typer.Option([1.0], min=0, help="Declared over true variances; may repeat."),
    config: Path | None = CONFIG,
    settings: list[str] = SETTINGS,
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    out: Path = typer.Option(OUT / "drive", help="Folder for the table."),
    keep: Path | None = KEEP,
) -> None:
    """Map a drive of panoramas with odometry made from its true positions, with drift and noise, in many ways."""
    from topomap.app import drive_bench
    from topomap.app.config import load_config
    from topomap.app.words import cores
    from topomap.bench.recordings.drives import variations

    chosen, which = load_config(config, settings), variations(scale, every, draws, declared)
    with progress(path.resolve().name, len(which)) as advance:
        rows = drive_bench.bench_drive(path, which, chosen, jobs or cores(), advance, keep)
    shown = grid(path.resolve().name, DRIVE_HEADINGS)
    for row in rows:
        shown.add_row(
            f"{row.scale:g}", str(row.every), str(row.draw), f"{row.declared:.3g}", _number(row.dead_reckoning_m),
            _number(row.map_m), str(row.accepted), _number(row.false, "d"), _number(row.recall, ".0%"),
            _scale(row.distance_scale, row.distance_sigma, row.true_distance_scale),
            _scale(row.rotation_scale, row.rotation_sigma, row.true_rotation_scale), row.kept,
        )  # fmt: skip
    show_wide(shown)
    for written in drive_bench.write_drive_bench(rows, out):
        console.print(str(written), soft_wrap=True)


def _number(value: float | None, form: str = ".3f") -> str:
    return "-" if value is None else format(value, form)


def _scale(found: float | None, sigma: float, true: float | None) -> str:
    said = "unobserved" if found is None else f"{found:.3f} ± {sigma:.3f}"
    return f"{said}, true {_number(true)}"
