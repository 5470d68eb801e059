"""Commands that map recordings: map tuc."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import typer

from topomap.cli.console import console
from topomap.cli.run_commands import show
from topomap.cli.words import FORCE

mapping = typer.Typer(help="Map a recording of a real robot.", no_args_is_help=True, rich_markup_mode=None)


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(mapping, name="map")


@mapping.callback()
def _group() -> None:
    pass


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
