"""Commands that measure the robot: bench kidnapped, breaks, faults, journeys, sessions, patrols."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.bench_commands import KEEP, OUT, benches, table
from topomap.cli.console import console, progress

if TYPE_CHECKING:
    from topomap.bench.searches import Search


def add_to(app: typer.Typer) -> None:
    """Add the commands to `topomap bench`, which bench_commands adds to the program."""
    for command in (kidnapped, breaks, faults, journeys, sessions, patrols):
        benches.command()(command)


def kidnapped(
    worlds: str = typer.Argument("room-corridor,hall", help="Worlds by name or file, comma-separated."),
    starts: int = typer.Option(20, min=1, help="Places, a world and seed, where the robot is set down."),
    seeds: str = typer.Option("0", help="Seeds of the drive and of the places, e.g. 0-4."),
    settings: list[str] = typer.Option([], "--set", metavar="KEY=VALUE", help="A setting of the run; may repeat."),
    out: Path = typer.Option(OUT / "kidnapped", help="Folder for the calibration curve."),
    keep: Path | None = KEEP,
) -> None:
    """Set a taught robot down anywhere, turned any way: how far it drives until it knows where, and how surely."""
    from topomap.app import kidnapped as bench
    from topomap.app.config import load_config
    from topomap.app.folder import make_writable
    from topomap.app.words import parse_seeds
    from topomap.bench.searches import HEADINGS, KEPT, KEYS, kept_row, row, tally
    from topomap.experiments.results import add_results

    config, numbers = load_config(None, settings), parse_seeds(seeds)
    found: dict[str, list[Search]] = {}
    make_writable(out)
    for world in (word.strip() for word in worlds.split(",") if word.strip()):
        found[world] = []
        with progress(world, len(numbers) * starts) as advance:
            for seed in numbers:
                own = []
                for one in bench.searches(world, seed, config, starts):
                    own.append(one)
                    advance(len(found[world]) + len(own))
                found[world] += own
                if keep is not None:
                    add_results(keep, KEPT, [kept_row(world, seed, settings, tally(own))], KEYS)
    table("kidnapped", ("world", *HEADINGS), [(world, *row(tally(own))) for world, own in found.items()])
    console.print(str(bench.draw(found, out)), soft_wrap=True)


def breaks(
    worlds: str = typer.Option(
        "room-corridor,hall,examples/worlds/figure_eight.toml",
        help="Worlds by name or file, comma-separated.",
    ),
    seeds: str = typer.Option("0-9", help="Seeds of drives and breaks, e.g. 0-4."),
    count: int = typer.Option(50, min=0, help="Drives with a break each."),
    undisturbed: int = typer.Option(20, min=0, help="Drives without."),
    settings: list[str] = typer.Option([], "--set", metavar="KEY=VALUE", help="A setting of the run; may repeat."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "breaks", help="Folder for the JSON."),
    keep: Path | None = KEEP,
) -> None:
    """Break the odometry once a drive: is it noticed, is nothing false, is the map joined again; and false alarms."""
    from topomap.app import break_bench as bench
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.breaks import HEADINGS, KEPT, kept_rows, rows
    from topomap.bench.pool import Store, default_folder
    from topomap.experiments.results import add_results

    names = [word.strip() for word in worlds.split(",") if word.strip()]
    tasks = bench.plan(names, parse_seeds(seeds), count, undisturbed, settings)
    store = Store(None if fresh else default_folder())
    with progress("breaks", len(tasks)) as advance:
        made = bench.run_breaks(tasks, store, jobs or cores(), advance)
    table("breaks", HEADINGS, rows(made))
    if keep is not None:
        add_results(keep, KEPT, kept_rows(made), keys=4)
    console.print(str(bench.write(made, out)), soft_wrap=True)


def faults(
    worlds: str = typer.Option("hall", help="Worlds by name or file, comma-separated."),
    seeds: str = typer.Option("0", help="Seeds of drives and of the moment, e.g. 0-4."),
    kinds: str = typer.Option("all", "--faults", help="'all' or what fails, comma-separated, e.g. black image."),
    settings: list[str] = typer.Option(
        ["sim.driver.laps=0.2"], "--set", metavar="KEY=VALUE", help="A setting of the run; may repeat."
    ),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "faults", help="Folder for the JSON."),
    keep: Path | None = KEEP,
) -> None:
    """Let every sensor and driver fail, while being taught and on the way home: wheels stopped, no false arrival."""
    from topomap.app import fault_bench as bench
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.pool import Store, default_folder
    from topomap.experiments.results import add_results

    names = [word.strip() for word in worlds.split(",") if word.strip()]
    tasks = bench.plan(names, parse_seeds(seeds), kinds, settings)
    store = Store(None if fresh else default_folder())
    with progress("faults", len(tasks)) as advance:
        made = bench.run_faults(tasks, store, jobs or cores(), advance)
    table("faults", bench.HEADINGS, bench.rows(made))
    if keep is not None:
        add_results(keep, bench.KEPT, bench.kept_rows(made), keys=4)
    console.print(str(bench.write(made, out)), soft_wrap=True)


def journeys(
    worlds: str = typer.Option("room-corridor", help="Worlds by name or file, comma-separated."),
    seeds: str = typer.Option("0", help="Seeds of drift, noise and starts, e.g. 0-4."),
    textures: str = typer.Option("0", help="Seeds of the worlds' looks, e.g. 0-2."),
    kinds: str = typer.Option("none", help="'all' or what goes wrong, comma-separated, e.g. none,turned,carried."),
    count: int = typer.Option(1, min=1, help="Journeys of each kind from every lesson."),
    goal: str = typer.Option("0", help="Node to travel to from the lesson's end; any: another one each time."),
    settings: list[str] = typer.Option([], "--set", metavar="KEY=VALUE", help="Setting; may repeat."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "journeys", help="Folder for the JSON."),
    keep: Path | None = KEEP,
) -> None:
    """Teach each world once and travel many times: homecomings, false arrivals, collisions, ways and speeds."""
    from topomap.app import journey_bench as bench
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.journey_table import HEADINGS, KEPT, kept_rows, rows
    from topomap.bench.pool import Store, default_folder
    from topomap.experiments.results import add_results

    tasks = bench.plan(worlds, parse_seeds(seeds), parse_seeds(textures), kinds, count, goal, settings)
    store = Store(None if fresh else default_folder())
    with progress("journeys", sum(task.travels for task in tasks)) as advance:
        made = bench.run_journeys(tasks, store, jobs or cores(), advance)
    table("journeys", HEADINGS, rows(made))
    if keep is not None:
        add_results(keep, KEPT, kept_rows(made), keys=7)
    console.print(str(bench.write(made, out)), soft_wrap=True)


def sessions(
    worlds: str = typer.Option("hall", help="Worlds by name or file, comma-separated; their routes are rings."),
    seeds: str = typer.Option("0", help="Seeds of the drives, e.g. 0-4."),
    laps: int = typer.Option(10, min=0, help="Laps on known ground, each a drive of its own; 0: merges alone."),
    settings: list[str] = typer.Option([], "--set", metavar="KEY=VALUE", help="Setting; may repeat."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    keep: Path | None = KEEP,
) -> None:
    """Merge two drives that overlap by half, beside one long drive; go on with a map lap after lap, pruned each time.

    --keep FILE.csv holds the merges, FILE-growth.csv beside it the laps.
    """
    from topomap.app import session_bench as bench
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.pool import Store, default_folder
    from topomap.bench.sessions import GROWTH_HEAD, MERGE_HEAD, growth_row, merge_row
    from topomap.experiments.results import add_results

    tasks = bench.plan(worlds, parse_seeds(seeds), laps, settings)
    store = Store(None if fresh else default_folder())
    with progress("sessions", len(tasks)) as advance:
        merges, growths = bench.run_sessions(tasks, store, jobs or cores(), advance)
    beside = keep and keep.with_stem(f"{keep.stem}-growth")
    tables = (
        (keep, "merged", MERGE_HEAD, [merge_row(one) for one in merges]),
        (beside, "growth", GROWTH_HEAD, [growth_row(one) for one in growths]),
    )
    for file, title, head, rows in tables:
        if rows:
            table(title, head, rows)
            if file is not None:
                add_results(file, head, rows, keys=3)


def patrols(
    worlds: str = typer.Option("hall", help="Worlds by name or file, comma-separated."),
    seeds: str = typer.Option("0", help="Seeds of the lessons, e.g. 0-4; the patrol's is 50 higher."),
    legs: int = typer.Option(60, min=1, help="Goals, one after the other, drawn from the map's snapshots."),
    settings: list[str] = typer.Option([], "--set", metavar="KEY=VALUE", help="Setting of both drives; may repeat."),
    changed: list[str] = typer.Option([], "--changed", metavar="KEY=VALUE", help="The patrol's alone; may repeat."),
    jobs: int | None = typer.Option(None, min=1, help="Processes [all cores]."),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "patrols", help="Folder for the JSON of all legs."),
    keep: Path | None = KEEP,
) -> None:
    """Teach and save a map, then let another robot, that isn't told where it is, drive from goal to goal on it."""
    from topomap.app import patrol_bench as bench
    from topomap.app.words import cores, parse_seeds
    from topomap.bench.patrols import HEAD, SHOWN, row, shown, total
    from topomap.bench.pool import Store, default_folder
    from topomap.experiments.results import add_results

    tasks = bench.plan(worlds, parse_seeds(seeds), legs, settings, changed)
    store = Store(None if fresh else default_folder())
    with progress("patrols", len(tasks)) as advance:
        made = bench.run_patrols(tasks, store, jobs or cores(), advance)
    table("patrols", SHOWN, [shown(cells) for cells in (*map(row, made), total(made))])
    if keep is not None:
        add_results(keep, HEAD, [row(one) for one in made], keys=5)
    console.print(str(bench.write(made, out)), soft_wrap=True)
