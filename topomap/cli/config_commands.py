"""Commands on settings: config show, config schema."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.words import CONFIG, SETTINGS

configs = typer.Typer(help="The settings: what there is, what holds.", no_args_is_help=True, rich_markup_mode=None)


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(configs, name="config")


@configs.callback()
def _group() -> None:
    pass


@configs.command()
def show(
    config: Path | None = CONFIG,
    settings: list[str] = SETTINGS,
    everything: bool = typer.Option(False, "--all", help="Also what makes the simulated robot worse, and isn't set."),
) -> None:
    """The settings as TOML with meaning, unit, bounds and default, as --config reads it; a file and --set change it."""
    from topomap.app.config import load_config
    from topomap.app.settings import settings_toml

    print(settings_toml(load_config(config, settings), flaws=everything), end="")


@configs.command()
def schema() -> None:
    """Print the JSON schema of the settings, for editors that complete and check TOML files."""
    from topomap.app.settings import settings_schema

    print(settings_schema())
