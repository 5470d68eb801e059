"""The command line: parses arguments, prints, exits; nothing else."""

from __future__ import annotations

import sys

import typer

from topomap import __version__
from topomap.cli import (
    bench_commands,
    closure_commands,
    config_commands,
    console,
    graph_commands,
    map_commands,
    method_commands,
    optimize_commands,
    recording_commands,
    rig_commands,
    run_commands,
    sweep_commands,
    world_commands,
)
from topomap.core.errors import TopomapError

app = typer.Typer(
    help="Loop-closing navigation with topological snapshot maps: drive, map, close the loop, go home, replay, look.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
run_commands.add_to(app)
sweep_commands.add_to(app)
map_commands.add_to(app)
closure_commands.add_to(app)
optimize_commands.add_to(app)
graph_commands.add_to(app)
recording_commands.add_to(app)
method_commands.add_to(app)
world_commands.add_to(app)
bench_commands.add_to(app)
config_commands.add_to(app)
rig_commands.add_to(app)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"topomap {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Show the version."),
) -> None:
    pass


def main() -> None:
    """Run the command line; every expected error is one line and exit code 2."""
    console.terminate_as_interrupt()
    try:
        app()
    except TopomapError as error:
        console.fail(str(error))
        sys.exit(2)
