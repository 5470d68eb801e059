"""topomap optimize: anybody's pose graph with doubtful closures."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.console import console, share, table


def add_to(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(optimize)


def optimize(
    graph: Path = typer.Argument(help="Pose graph in the plane: g2o (EDGE_SE2) or TORO (EDGE2).", metavar="GRAPH.g2o"),
    out: Path | None = typer.Option(None, help="Folder for poses, verdicts, picture, summary and report [runs/NAME]."),
) -> None:
    """Optimise a pose graph whose closures may be false; write poses, each closure's verdict, a map and a report."""
    from topomap.app import optimize as work

    with share(graph.stem) as progress:
        done = work.optimize(graph, out, progress)
    table(done.rows, str(graph))
    for path in done.files:
        console.print(str(path), soft_wrap=True)
