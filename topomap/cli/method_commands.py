"""The command that lists the methods: methods."""

from __future__ import annotations

import typer
from rich.table import Table

from topomap.cli.console import console, show_wide


def add_to(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(methods)


def methods(
    text: str = typer.Argument("", help="List only the rows that contain this text."),
) -> None:
    """List every aligner and homing method with its row, needs, source and defaults."""
    from topomap.vision.registry import entries

    shown = Table(title="Methods", title_justify="left")
    for column in ("row", "name", "family", "kind", "needs", "homes", "source", "defaults"):
        shown.add_column(column, overflow="fold", no_wrap=column in ("row", "name"))
    chosen = [entry for entry in entries() if text.lower() in _searched(entry)]
    for entry in chosen:
        homes = {True: "yes", False: "no", None: ""}[entry.homes]
        shown.add_row(entry.row, entry.name, entry.family, entry.kind, entry.needs, homes, entry.source, entry.defaults)
    show_wide(shown)
    console.print(f"{len(chosen)} entries")


def _searched(entry: object) -> str:
    return str(entry).lower()
