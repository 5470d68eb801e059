"""Commands on cameras: rig fit."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.console import console

rigs = typer.Typer(help="Find out how a camera sees.", no_args_is_help=True, rich_markup_mode=None)


def add_to(app: typer.Typer) -> None:
    """Add the commands to the program."""
    app.add_typer(rigs, name="rig")


@rigs.callback()
def _group() -> None:
    pass


@rigs.command()
def fit(
    image: Path = typer.Argument(help="Raw picture of a mirror camera."),
    out: Path | None = typer.Option(None, help="Rig file to write [print it]."),
) -> None:
    """Find centre and radii of a mirror's ring in a raw picture; the nose is taken along the picture's +x."""
    from topomap.core.encoded import decode
    from topomap.core.errors import DataError
    from topomap.core.files import regular
    from topomap.datasets.mirror_file import mirror_text
    from topomap.evaluation.summary import write_whole
    from topomap.vision.image.unwrap import fit_mirror

    try:
        raw = decode(regular(image).read_bytes())
    except (OSError, DataError) as error:
        raise DataError(f"{image}: can't be read as an image: {error}") from error
    text = mirror_text(fit_mirror(raw))
    if out is None:
        console.print(text, end="", highlight=False)
    else:
        write_whole(out, text)
        console.print(str(out), soft_wrap=True)
