"""Options that several commands share, said once."""

from __future__ import annotations

import typer

KINDS = "teach, home, goto:NODE, goto:PLACE, patrol:A,B,... or hall"
CONFIG = typer.Option(None, help="TOML file with settings, e.g. examples/my.toml; 'topomap config show' lists them.")
SETTINGS = typer.Option(
    [],
    "--set",
    metavar="SECTION.KEY=VALUE",
    help="One setting, e.g. stack.mission.then=stop; may repeat; 'topomap config show' lists them.",
)
FORCE = typer.Option(False, "--force", help="Replace what an earlier run left in the folder.")
PARTIAL = typer.Option(
    False,
    "--partial",
    help="Be content with a log that is cut off, damaged, repaired or unverified: no exit code 3.",
)
