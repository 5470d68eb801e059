"""Commands on maps: FOLDER and tuc, which map a recording; info, places, merge, prune, export of a saved map."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from typer.core import TyperGroup

from topomap.cli.console import console, progress, share, table
from topomap.cli.run_commands import show
from topomap.cli.words import CONFIG, FORCE, SETTINGS

if TYPE_CHECKING:
    from typer._click.core import Command, Context  # typer's own copy of click: for the types alone

    from topomap.app.maps import Written

MAP = typer.Argument(help="Map file, as runs/a/run.topomap.", metavar="MAP")


class _FolderOrCommand(TyperGroup):
    """`map FOLDER` is `map drive FOLDER`: what names no command is a folder."""

    def resolve_command(self, ctx: Context, args: list[str]) -> tuple[str | None, Command | None, list[str]]:
        known = args[0] in self.commands or args[0].startswith("-")
        return super().resolve_command(ctx, args if known else ["drive", *args])


mapping = typer.Typer(
    cls=_FolderOrCommand,
    help="Map a recording of a real robot (map FOLDER, or map KIND FOLDER), or look at saved maps, name places, merge, "
    "prune and export them. A map is travelled on by `topomap run WORLD --map MAP --mission ...`.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(mapping, name="map")


@mapping.callback()
def _group() -> None:
    pass


@mapping.command()
def drive(
    path: Path = typer.Argument(help="Folder with drive.csv, rig.json and panoramas.", metavar="FOLDER"),
    out: Path | None = typer.Option(None, help="Folder for log, map, summary and report [runs/NAME]."),
    config: Path | None = CONFIG,
    settings: list[str] = SETTINGS,
    force: bool = FORCE,
    made_odometry: int | None = typer.Option(
        None, min=0, metavar="SEED", help="An experiment: make odometry from the true positions, with drift and noise."
    ),
) -> None:
    """Map a drive of panoramas with odometry: `map FOLDER` for short; write log, map, summary and report."""
    from topomap.app import recordings
    from topomap.app.config import load_config
    from topomap.app.folder import RunFolder
    from topomap.datasets.drive_folder import read_folder

    chosen, recorded = load_config(config, settings), read_folder(path)
    folder = RunFolder.create(out or Path("runs") / recorded.name, force=force)
    with progress(recorded.name, len(recorded.table)) as advance:
        result = recordings.map_drive(recorded, folder, chosen, advance, made_odometry)
    show(result)


@mapping.command()
def info(path: Path = MAP) -> None:
    """Show what a map holds: nodes, way, closures, views, size, calibration, places."""
    from topomap.app import maps

    table(maps.describe(path), str(path))


@mapping.command()
def places(
    path: Path = MAP,
    add: list[str] = typer.Option([], metavar="NAME=NODE", help="Name a snapshot node; may repeat."),
    remove: list[str] = typer.Option([], metavar="NAME", help="Take a name away; may repeat."),
    groups: bool = typer.Option(False, "--groups", help="Show the map's own places: snapshots that look alike."),
) -> None:
    """List the named places of a map, which goto:NAME and patrol:NAME,... take; name some, or take names away."""
    from topomap.app import maps

    table(maps.places(path, add, remove), str(path))
    if groups:
        table(maps.groups(path), "snapshots that look alike and lie together")


@mapping.command()
def merge(
    first: Path = typer.Argument(help="Map whose frame and node numbers stay.", metavar="A"),
    second: Path = typer.Argument(help="Map of a drive that overlaps.", metavar="B"),
    out: Path = typer.Option(..., help="The new map file."),
) -> None:
    """Join two maps whose routes overlap; each closure between them is weighed by the closure engine."""
    from topomap.app import maps

    with share("merging") as told:
        done = maps.merge_files(first, second, out, told)
    _tell(done, str(out))


@mapping.command()
def prune(
    path: Path = MAP,
    out: Path | None = typer.Option(None, help="The new map file [the same]."),
) -> None:
    """Leave out nodes that add nothing: ground that older views show as well. Numbers and places stay."""
    from topomap.app import maps

    with share("pruning") as told:
        done = maps.prune_file(path, out or path, lambda done: told(done, "comparing views"))
    _tell(done, str(path))


@mapping.command()
def export(
    path: Path = MAP,
    out: Path | None = typer.Option(None, help="Folder for the files [beside the map]."),
) -> None:
    """Write a map as g2o, TUM, JSON and GeoJSON (in metres) for programs, and as a PNG for people."""
    from topomap.app import maps

    _tell(maps.export_map(path, out or path.parent), str(path))


def _tell(done: Written, title: str) -> None:
    if done.rows:
        table(done.rows, title)
    for path in done.files:
        console.print(str(path), soft_wrap=True)


@mapping.command()
def tuc(
    path: Path = typer.Argument(help="Folder of a TUC recording: *_Input.txt and, if known, *_GT.txt."),
    out: Path | None = typer.Option(None, help="Folder for trajectory, summary and report [runs/NAME]."),
    force: bool = FORCE,
    building_axes: bool = typer.Option(
        False, "--building-axes", help="Assume that straight stretches run along the building's two axes."
    ),
) -> None:
    """Map a recording in the TUC format: odometry and loop candidates; write trajectory, summary and report."""
    from topomap.app import recordings

    with console.status("mapping") if console.is_terminal else nullcontext():
        result = recordings.map_tuc(path, out or Path("runs") / path.resolve().name, building_axes, force)
    show(result)
