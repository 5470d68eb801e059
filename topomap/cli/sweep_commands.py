"""sweep: many runs, one table."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.console import console, grid, progress, show_wide
from topomap.cli.words import CONFIG, SETTINGS

if TYPE_CHECKING:
    from topomap.bench.sweeps.table import Line, Spread
    from topomap.evaluation.statistics import Interval

HEADINGS = (
    "world", "variant", "runs", "dead reckoning\n[m]", "map SE(2)\n[m]", "map Sim(2)\n[m]", "accepted",
    "false,\nin all", "recall", "within 2 sigmas:\nrotation, curvature, distance", "home",
)  # fmt: skip


def add_to(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(sweep)


def sweep(
    worlds: list[str] = typer.Argument(help="Named worlds, world files or floor plans."),
    seeds: str = typer.Option("0-4", help="Seeds, e.g. 0-9, 3 or 0,2,5."),
    config: Path | None = CONFIG,
    settings: list[str] = SETTINGS,
    vary: list[str] = typer.Option(
        [], metavar="SECTION.KEY=[A, B]", help="Values of a setting to compare; may repeat: every combination is run."
    ),
    variants: Path | None = typer.Option(None, help="TOML file whose tables are named variants of the settings."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Make anew what is there already."),
    out: Path = typer.Option(Path("runs") / "sweep", help="Folder for table, figure and the runs' own folders."),
) -> None:
    """Run worlds over seeds and variants of the settings: accuracy, closures, calibration, way home; one table."""
    from topomap.app import sweep as sweeps
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.sweeps.table import lines

    tasks = sweeps.plan(worlds, parse_seeds(seeds), config, settings, sweeps.variants(vary, variants), out)
    with progress("sweep", len(tasks)) as advance:
        found = sweeps.run_sweep(tasks, jobs or cores(), fresh, out, advance)
    shown = grid("over the seeds: mean, least to most", HEADINGS, lines=True)
    for line in lines(found):
        shown.add_row(*cells(line))
    show_wide(shown)
    for path in sweeps.write_sweep(found, out):
        console.print(str(path), soft_wrap=True)


def cells(line: Line) -> tuple[str, ...]:
    """Return a line of the table as text."""
    one = line.spreads
    false = one["closures_false"]
    return (
        line.world,
        line.variant,
        str(len(line.seeds)),
        _span(one["dead_reckoning_ate_m"], ".2f"),
        _span(one["map_ate_se2_m"], ".3f"),
        _span(one["map_ate_sim2_m"], ".3f"),
        _span(one["closures_accepted"], ".0f"),
        f"{false.mean * false.count:.0f}" if false.count else "-",
        _span(one["recall"], ".1%"),
        ", ".join(_share(share) for share in line.within_2_sigmas.values()),
        _share(line.home),
    )


def _span(spread: Spread, form: str) -> str:
    if not spread.count:
        return "-"
    return f"{spread.mean:{form}}\n{spread.least:{form}} to {spread.most:{form}}"


def _share(share: Interval) -> str:
    return f"{share.value:.0%}" if math.isfinite(share.value) else "-"
