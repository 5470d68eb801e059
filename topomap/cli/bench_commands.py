"""Commands that measure methods: bench homing, study, loop-rule, spacing, mission, places, looks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.console import console, grid, progress, show_wide
from topomap.cli.words import SETTINGS

if TYPE_CHECKING:
    from topomap.bench.homing.bench import Table

benches = typer.Typer(help="Measure methods against the truth.", no_args_is_help=True, rich_markup_mode=None)
OUT = Path("runs") / "bench"
RESULTS = Path(__file__).parents[2] / "docs" / "results"
KEEP = typer.Option(None, help="CSV file that the figures are added to, as under docs/results.")


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(benches, name="bench")


@benches.callback()
def _group() -> None:
    pass


@benches.command()
def homing(
    env: str = typer.Option("", help="Named environments, comma-separated, e.g. ourlab,hall1."),
    grid: list[Path] = typer.Option([], help="Folder with grid.toml, or a CSV of places and images; may repeat."),
    methods: str = typer.Option("all", help="'all' or names, comma-separated (see 'topomap methods')."),
    home: str | None = typer.Option(None, metavar="X,Y", help="Home [m] [the grid's middle]."),
    compass: str = typer.Option("given", help="'given', or the aligner or row that finds the rotation, e.g. A1 or A6."),
    seeds: str = typer.Option("0", help="Seeds of textures, noise and headings, e.g. 0-4."),
    view: list[str] = typer.Option(
        [], metavar="KEY=VALUE", help="Camera setting, e.g. hour=14, roll_deg=2, goal:hour=6, noise=off; may repeat."
    ),
    starts: int = typer.Option(8, min=0, help="Places, a seed, from which homing is iterated in the world."),
    within: float | None = typer.Option(None, min=0.01, help="Count only places this near to home [m]."),
    every: int = typer.Option(1, min=1, help="Ask one place in so many, others for each seed; no catchment then."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "homing", help="Folder for tables and pictures."),
    keep: Path | None = KEEP,
    pictures: bool = typer.Option(True, help="Draw vector maps and routes, one picture a method."),
) -> None:
    """Home vectors of all methods from every place of a grid: errors, catchment, success, time; with pictures."""
    from topomap.app import bench
    from topomap.app.words import cores
    from topomap.bench.homing.bench import BenchSettings
    from topomap.bench.homing.table import KEPT, kept_rows
    from topomap.bench.pool import Store, default_folder
    from topomap.experiments.results import add_results

    settings = BenchSettings(compass=compass, starts=starts, within=within, every=every)
    asked = bench.request(env, grid, methods, seeds, home, settings, view)
    store = Store(None if fresh else default_folder())
    with progress("homing", asked.steps) as advance:
        tables = bench.run_bench(asked, store, jobs or cores(), advance)
    for found in tables:
        show(found)
        if keep is not None:
            add_results(keep, KEPT, kept_rows(found), keys=4)
    for folder in bench.write_bench(tables, out, pictures):
        console.print(str(folder), soft_wrap=True)


def show(found: Table) -> None:
    """Print a homing table."""
    from rich.table import Table as Grid

    from topomap.bench.homing.table import HEADINGS, cells, title, unfit

    shown = Grid(title=title(found), title_justify="left")
    for name in HEADINGS:
        shown.add_column(name, justify="left" if name == "method" else "right", overflow="fold")
    for row in found.rows:
        if row.unfit is None:
            shown.add_row(*cells(row))
    show_wide(shown)
    for reason, names in unfit(found).items():
        console.print(f"Left out, {reason}: {', '.join(names)}")


@benches.command()
def studies() -> None:
    """List the named studies: which figures of the thesis they repeat and what they ask."""
    from topomap.app import bench

    rows = [(one.name, one.source, ", ".join(one.environments) or "own", one.question) for one in bench.available()]
    table("studies", ("name", "figures", "environment", "question"), rows)


@benches.command()
def study(
    name: str = typer.Argument(help="Name of the study (see 'topomap bench studies'), or 'all'."),
    seeds: str = typer.Option("0", help="Seeds, e.g. 0-4."),
    every: int = typer.Option(1, min=1, help="Ask one place of a grid in so many, others for each seed."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "studies", help="Folder for the figure and its JSON."),
    keep: Path | None = KEEP,
) -> None:
    """Repeat one of the thesis's experiments; write its figure and the figures behind it."""
    from topomap.app import bench
    from topomap.app.words import cores
    from topomap.bench.pool import Store, default_folder

    store = Store(None if fresh else default_folder())
    for one in [one.name for one in bench.available()] if name == "all" else [name]:
        with progress(one, None) as advance:
            written = bench.run_study(one, seeds, store, jobs or cores(), advance, out, every, keep)
        for path in written:
            console.print(str(path), soft_wrap=True)


@benches.command("loop-rule")
def loop_rule(
    logs: list[Path] = typer.Argument(help="Logs of drives with truth."),
    threshold: float = typer.Option(0.8, min=0.01, help="Summed difference that keeps a snapshot; half of it closes."),
    keep: Path | None = KEEP,
) -> None:
    """Map logged drives by the thesis's rule (5.2.4) and show it beside the closure engine."""
    from topomap.app.loop_rule import HEAD, TALLY, LoopRow, cells, compare, tally
    from topomap.experiments.results import add_results
    from topomap.mapping.difference_mapping import DifferenceRuleSettings

    rows = list[LoopRow]()
    for log in logs:
        found = compare(log, DifferenceRuleSettings(threshold=threshold))
        table(str(log), HEAD, [cells(row) for row in found])
        rows += found
    if len(logs) > 1:
        table(f"{len(logs)} drives", TALLY, tally(rows))
    if keep is not None:
        add_results(keep, TALLY, tally(rows), keys=2)


@benches.command()
def spacing(
    worlds: list[str] = typer.Argument(None, help="Worlds by name or file [room-corridor hall]."),
    methods: str = typer.Option("all", help="'all' that home, or names, comma-separated."),
    seeds: str = typer.Option("0-1", help="Seeds of looks, noise and where the way begins."),
    apart: list[float] = typer.Option([0.5, 0.8, 1.2, 1.8], min=0.3, max=10, help="Spacing [m]; may repeat."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    keep: Path | None = KEEP,
) -> None:
    """How far milestones may lie apart: the robot goes three of them by a method alone, 0.5 to 1.8 m apart."""
    from topomap.app.spacing import plan, run_spacing
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.pool import Store, default_folder
    from topomap.experiments.results import add_results
    from topomap.experiments.spacing import HEAD, tally

    tasks = plan(worlds or ["room-corridor", "hall"], methods, parse_seeds(seeds), apart)
    with progress("spacing", len(tasks)) as advance:
        courses = run_spacing(tasks, Store(None if fresh else default_folder()), jobs or cores(), advance)
    rows = tally(courses)
    table("milestones, three in a row", HEAD, rows)
    if keep is not None:
        add_results(keep, HEAD, rows, keys=3)


@benches.command()
def mission(
    out: Path = typer.Option(Path("docs") / "THESIS.md", help="File for the table."),
    results: Path = typer.Option(RESULTS, help="Folder of the figures that are kept.", show_default="docs/results"),
) -> None:
    """Write the table of the thesis: every method, figure and table, how it is called, its test, both figures."""
    from topomap.evaluation.summary import write_whole
    from topomap.experiments.mission import mission_table

    out.parent.mkdir(parents=True, exist_ok=True)
    write_whole(out, mission_table(results))
    console.print(str(out), soft_wrap=True)


@benches.command()
def places(
    folder: Path = typer.Argument(help="Folder of photographs along a route: training.csv and its path."),
    spacing: int = typer.Option(30, min=2, help="Every so-manieth image is the map."),
    stride: int = typer.Option(4, min=1, help="Every so-manieth of the others is asked."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "places", help="Folder for the JSON."),
) -> None:
    """Place recognition and compass of every aligner on real photographs."""
    from topomap.app import bench
    from topomap.app.words import cores
    from topomap.bench.places import names
    from topomap.bench.pool import Store, default_folder

    store = Store(None if fresh else default_folder())
    with progress("places", len(names())) as advance:
        scores = bench.run_places(folder, spacing, stride, store, jobs or cores(), advance, out)
    rows = [
        (s.aligner, f"{s.place_error_m:.2f}", f"{s.floor_m:.2f}", f"{s.compass_median_deg:.1f}",
         f"{s.compass_mean_deg:.1f}", f"{s.ms:.2f}")
        for s in scores if s.unfit is None
    ]  # fmt: skip
    table(
        f"{folder.name}: median place error over {max(s.queries for s in scores)} queries",
        ("aligner", "place [m]", "nearest [m]", "compass median [deg]", "mean [deg]", "ms"),
        rows,
    )
    for s in scores:
        if s.unfit is not None:
            console.print(f"Left out, {s.unfit}: {s.aligner}")


@benches.command()
def looks(
    worlds: list[str] = typer.Argument(help="Named worlds, world files or floor plans."),
    seeds: str = typer.Option("0-4", help="Seeds, e.g. 0-9, 3 or 0,2,5."),
    settings: list[str] = SETTINGS,
    vary: list[str] = typer.Option(
        [], metavar="SECTION.KEY=[A, B]", help="Values of a setting, e.g. sim.driver.lateral_offset=[0, 0.3]."
    ),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "looks", help="Folder for table and curve."),
) -> None:
    """How well looks tell places seen again from look-alikes: calibration curve, and weights fitted anew."""
    from topomap.app import look_bench
    from topomap.app.sweep import variants
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.looks.fit import curves
    from topomap.bench.pool import Store, default_folder

    tasks = look_bench.plan(worlds, parse_seeds(seeds), settings, variants(vary, None))
    store = Store(None if fresh else default_folder())
    with progress("looks", len(tasks)) as advance:
        rows = look_bench.run_looks(tasks, store, jobs or cores(), advance)
    found = curves(rows).items()
    lines = [(name, f"{one.count.sum():.0f}", f"{one.error:.3f}") for name, one in found]
    table("looks", ("world", "candidates", "calibration error"), lines)
    for path in look_bench.write_looks(rows, out):
        console.print(str(path), soft_wrap=True)


def table(title: str, headings: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    shown = grid(title, headings)
    for row in rows:
        shown.add_row(*row)
    show_wide(shown)
