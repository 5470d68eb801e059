"""Commands that measure: bench homing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.console import console, progress

if TYPE_CHECKING:
    from topomap.study.homing_bench import Table

benches = typer.Typer(help="Measure methods against the truth.", no_args_is_help=True, rich_markup_mode=None)
OUT = Path("runs") / "bench"


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(benches, name="bench")


@benches.callback()
def _group() -> None:
    pass


@benches.command()
def homing(
    env: str = typer.Option("", help="Named environments, comma-separated, e.g. ourlab,hall1."),
    grid: list[Path] = typer.Option([], help="Folder of panoramas on a grid; may repeat."),
    methods: str = typer.Option("all", help="'all' or names, comma-separated (see 'topomap methods')."),
    home: str | None = typer.Option(None, metavar="X,Y", help="Home [m] [the grid's middle]."),
    compass: str = typer.Option("given", help="'given', or the aligner or row that finds the rotation, e.g. A1 or A6."),
    seeds: str = typer.Option("0", help="Seeds of textures, noise and headings, e.g. 0-4."),
    starts: int = typer.Option(8, min=0, help="Places, a seed, from which homing is iterated in the world."),
    within: float | None = typer.Option(None, min=0.01, help="Count only places this near to home [m]."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "homing", help="Folder for tables and pictures."),
) -> None:
    """Home vectors of all methods from every place of a grid: errors, catchment, success, time; with pictures."""
    from topomap.app import bench
    from topomap.study.homing_bench import BenchSettings
    from topomap.study.homing_pool import Store, default_folder

    settings = BenchSettings(compass=compass, starts=starts, within=within)
    asked = bench.request(env, grid, methods, seeds, home, settings)
    store = Store(None if fresh else default_folder())
    with progress("homing", asked.steps) as advance:
        tables = bench.run_bench(asked, store, jobs or bench.cores(), advance)
    for found in tables:
        show(found)
    for folder in bench.write_bench(tables, out):
        console.print(str(folder), soft_wrap=True)


def show(found: Table) -> None:
    """Print a homing table."""
    from rich.table import Table as Grid

    from topomap.study.homing_table import HEADINGS, cells, title, unfit

    shown = Grid(title=title(found), title_justify="left")
    for name in HEADINGS:
        shown.add_column(name, justify="left" if name == "method" else "right", overflow="fold")
    for row in found.rows:
        if row.unfit is None:
            shown.add_row(*cells(row))
    console.print(shown)
    for reason, names in unfit(found).items():
        console.print(f"Left out, {reason}: {', '.join(names)}")
