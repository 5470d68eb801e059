"""The command line: parses arguments, prints, exits; nothing else."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TextIO

import typer

from topomap import __version__
from topomap.app.interrupt import SIGNALS
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
    robot_bench_commands,
    run_commands,
    sweep_commands,
    world_commands,
)
from topomap.core.errors import RobotFault, TopomapError

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
robot_bench_commands.add_to(app)
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
    """Run the command line.

    Every expected error is one line. Exit codes: 1 the output can't be written, 2 something is wrong with what was
    asked, 3 a log isn't whole, 4 a run ended by a fault, 128 and its number for a signal.
    """
    console.interrupt_on_signals(SIGNALS)
    try:
        try:
            _run()
        finally:
            sys.stdout.flush()
    except OSError as error:  # standard output is full, closed or a terminal that has gone
        _let_go(sys.stdout)
        console.fail(f"standard output can't be written ({error.strerror})")
        sys.exit(1)


def _run() -> None:
    try:
        app(standalone_mode=True)
    except RobotFault as error:
        console.fail(str(error))
        sys.exit(console.FAULT)
    except TopomapError as error:
        console.fail(str(error))
        sys.exit(2)
    except console.Interrupted as error:
        sys.exit(console.INTERRUPTED + error.number)


def _let_go(stream: TextIO) -> None:
    """Let what couldn't be written go, so that it isn't tried once more when the program ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
