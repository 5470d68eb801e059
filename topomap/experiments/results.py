"""Figures that the project keeps: a CSV file each under docs/results, the commands that made it on top."""

from __future__ import annotations

import csv
import io
import shlex
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from topomap.core.errors import DataError
from topomap.evaluation.summary import write_whole

MARK = "# "


@dataclass(frozen=True, slots=True)
class Results:
    """A file of figures: the commands that made it, and its rows as text by column."""

    commands: tuple[str, ...]
    rows: tuple[dict[str, str], ...]


def read_results(path: Path) -> Results:
    """Return the figures of a file. Raises DataError where it can't be read or a row is too long or too short."""
    try:
        lines = path.read_text(encoding="utf8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    commands = tuple(line.removeprefix(MARK) for line in lines if line.startswith(MARK))
    table = list(csv.reader(line for line in lines if not line.startswith(MARK)))
    head, body = table[0] if table else [], table[1:]
    for row in body:
        if len(row) != len(head):
            raise DataError(f"{path}: {','.join(row)}: {len(row)} cells under {len(head)} headings")
    return Results(commands, tuple(dict(zip(head, row, strict=True)) for row in body))


def add_results(
    path: Path, head: Sequence[str], rows: Iterable[Sequence[str]], keys: int, program: str = "topomap"
) -> None:
    """Write rows into a file of figures, in place of those there that share the first `keys` cells. Raises DataError.

    The command line of this process joins those that made the file, without what decides no figure.
    """
    before = read_results(path) if path.exists() else Results((), ())
    known = {tuple(row.values())[:keys]: tuple(row.values()) for row in before.rows}
    known |= {tuple(row)[:keys]: tuple(row) for row in rows}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(known.values())
    commands = dict.fromkeys((*before.commands, _command(program, sys.argv[1:])))
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, "".join(f"{MARK}{one}\n" for one in commands) + text.getvalue())


def _command(program: str, words: Sequence[str]) -> str:
    """Return a command line without where it writes and how many processes it takes."""
    told = list(words)
    for name in ("--out", "--jobs"):
        if name in told:
            at = told.index(name)
            del told[at : at + 2]
    return shlex.join((program, *(word for word in told if word not in ("--fresh", "--no-pictures"))))
