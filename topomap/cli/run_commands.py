"""Commands on runs: run, replay, report, info, recover, export."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.console import INTERRUPTED, doubt, fail, progress, say, table
from topomap.cli.words import CONFIG, FORCE, KINDS, PARTIAL, SETTINGS
from topomap.core.errors import RobotFault

if TYPE_CHECKING:
    from topomap.app.runs import RunResult


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    for command in (run, replay, report, info, recover, export):
        app.command()(command)


def run(
    world: str = typer.Argument(help="Named world (see topomap worlds), world file (.toml) or floor plan (map.yaml)."),
    seed: int = typer.Option(0, min=0, help="Seed of all that is random in the run."),
    config: Path | None = CONFIG,
    settings: list[str] = SETTINGS,
    out: Path | None = typer.Option(None, help="Folder for log, map, summary and report [runs/WORLD-SEED]."),
    force: bool = FORCE,
    mission: str | None = typer.Option(None, help=f"What to do: {KINDS} [teach, then home]."),
    map_file: Path | None = typer.Option(None, "--map", help="Saved map to go on with, as run.topomap."),
    start: str | None = typer.Option(None, help="On a saved map: node or place where the robot is put [unknown]."),
    at: str | None = typer.Option(None, help="Where the simulator puts it: X,Y[,DEGREES], or a place of the world."),
) -> None:
    """Drive a simulated world, map it, close loops, travel; write log, map, summary and report.

    On a saved map the robot goes on a mission at once; --mission teach lets the driver show it more.
    """
    from topomap.app import runs
    from topomap.app.folder import RunFolder
    from topomap.app.mission_steps import expected_steps
    from topomap.app.missions import mission_config
    from topomap.app.saved_map import SavedMap
    from topomap.core.names import safe_name

    chosen = mission_config(config, settings, mission, map_file is not None, start, at)
    saved = SavedMap.open(map_file, chosen.stack.mission) if map_file else None
    robot = runs.open_world(world, seed, chosen)
    folder = RunFolder.create(out or Path("runs") / f"{safe_name(robot.world.name)}-{seed}", force=force)
    steps = expected_steps(robot, chosen.stack.mission, saved)
    with progress(robot.world.name, steps) as advance, told_faults():
        result = runs.run_world(robot, seed, chosen, folder, advance, saved)
    show(result)
    if result.failure:
        fail(result.failure)
        raise typer.Exit(2)


def replay(
    log: Path = typer.Argument(help="MCAP log of a run.", metavar="RUN.mcap"),
    settings: list[str] = SETTINGS,
    out: Path | None = typer.Option(None, help="Folder for the new log, map, summary and report [RUN-replay]."),
    force: bool = FORCE,
    partial: bool = PARTIAL,
) -> None:
    """Take a log's readings through the stack again; with the same settings the graph hash is the same."""
    from topomap.app import runs
    from topomap.app.folder import RunFolder
    from topomap.app.same import compare
    from topomap.app.stored_run import open_log

    stored = open_log(log, settings)
    folder = RunFolder.create(out or log.parent / "replay", keep=log, force=force)
    with progress("replay", stored.robot.steps) as advance, told_faults():
        result = runs.replay_log(stored, folder, advance)
    show(result)
    say(compare(log, result.folder.log))
    doubt(log, result.doubt, partial)


def report(
    log: Path = typer.Argument(help="MCAP log of a run, complete or cut off.", metavar="RUN.mcap"),
    out: Path | None = typer.Option(None, help="Folder for summary and report [beside the log]."),
    force: bool = FORCE,
    partial: bool = PARTIAL,
) -> None:
    """Write the summary and the report of a log again."""
    from topomap.app import runs

    result = runs.report_log(log, out or log.parent, force)
    show(result)
    doubt(log, result.doubt, partial)


def info(log: Path = typer.Argument(help="MCAP log of a run.", metavar="RUN.mcap"), partial: bool = PARTIAL) -> None:
    """Show what a log holds."""
    from topomap.app.describe import describe_log

    rows, topics, wrong = describe_log(log)
    table(rows, str(log))
    table(topics, "topics")
    doubt(log, wrong, partial)


def recover(
    log: Path = typer.Argument(help="MCAP log that was cut off or damaged.", metavar="BROKEN.mcap"),
    out: Path = typer.Argument(help="The repaired log; must not exist yet.", metavar="OUT.mcap"),
    partial: bool = PARTIAL,
) -> None:
    """Copy all that is readable of a log into a new, complete one, for viewers that refuse a cut-off file."""
    from topomap.recording.recover import recover_log

    saved, wrong = recover_log(log, out)
    say(f"{out}: {saved}")
    doubt(log, wrong, partial)


def export(
    log: Path = typer.Argument(help="MCAP log of a run.", metavar="RUN.mcap"),
    tum: bool = typer.Option(False, "--tum", help="Trajectories as TUM files (map, online, dead reckoning, truth)."),
    g2o: bool = typer.Option(False, "--g2o", help="The finished map as a g2o pose graph."),
    out: Path | None = typer.Option(None, help="Folder for the files [beside the log]."),
    partial: bool = PARTIAL,
) -> None:
    """Write a run's trajectories and graph in the formats other tools read."""
    from topomap.app.export import export_run

    if not (tum or g2o):
        raise typer.BadParameter("say what to write: --tum, --g2o or both")
    written, wrong = export_run(log, out or log.parent, tum, g2o)
    for path in written:
        say(str(path))
    doubt(log, wrong, partial)


def show(result: RunResult) -> None:
    """Print a run's table, files and notes; end with 128 and the number of the signal that interrupted it."""
    from topomap.evaluation.summary import table_rows

    table(table_rows(result.summary), str(result.summary["world"]))
    for path in result.files:
        say(str(path))
    for note in result.notes:
        say(f"Note: {note}")
    if result.interrupted:
        raise typer.Exit(INTERRUPTED + (result.signal or signal.SIGINT))


@contextmanager
def told_faults() -> Iterator[None]:
    """Show what was kept of a run that ended by a fault, before the fault is told."""
    from topomap.app.runs import RunResult

    try:
        yield
    except RobotFault as fault:
        if isinstance(fault.result, RunResult):
            show(replace(fault.result, interrupted=False))
        raise
