"""Commands on worlds: worlds, worlds show, worlds sheet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.table import Table

from topomap.cli.console import console, table

if TYPE_CHECKING:
    from topomap.app.worlds import WorldInfo

worlds = typer.Typer(
    help="The simulated worlds: listed when called alone; pictures.", invoke_without_command=True, rich_markup_mode=None
)


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(worlds, name="worlds")


@worlds.callback()
def _list(context: typer.Context) -> None:
    """List the named worlds; also: worlds show NAME|FILE, worlds sheet."""
    if context.invoked_subcommand is not None:
        return
    from topomap.app.worlds import list_worlds

    shown = Table(title="worlds", title_justify="left")
    for heading in ("name", "size", "route", "laps", "for"):
        shown.add_column(heading, justify="right" if heading in ("size", "route", "laps") else "left")
    for info in list_worlds():
        shown.add_row(info.name, *_figures(info), info.purpose)
    console.print(shown)


@worlds.command()
def show(
    world: str = typer.Argument(help="Named world, world file (.toml) or floor plan (.yaml).", metavar="NAME|FILE"),
    out: Path = typer.Option(Path("runs/worlds"), help="Folder for the pictures."),
) -> None:
    """Draw a world's plan with routes, places and grid, and panoramas along its route."""
    from topomap.app.worlds import show_world

    info, files = show_world(world, out)
    size, route, laps = _figures(info)
    rows = [("for", info.purpose), ("size", size), ("route", route), ("laps", laps)]
    table([*rows, ("other routes", ", ".join(info.routes) or "none")], info.name)
    for path in files:
        console.print(str(path), soft_wrap=True)


@worlds.command()
def sheet(
    out: Path = typer.Option(Path("runs/worlds/worlds.png"), help="Picture to write."),
) -> None:
    """Draw plan and panorama of every named world on one sheet."""
    from topomap.app.worlds import draw_sheet

    draw_sheet(out)
    console.print(str(out), soft_wrap=True)


def _figures(info: WorldInfo) -> tuple[str, str, str]:
    width, depth = info.size
    return f"{width:.1f} x {depth:.1f} m", f"{info.route_m:.0f} m", f"{info.laps:g}"
