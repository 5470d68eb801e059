"""What every command shares: the console, the progress bar, one clear line for an expected error."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

from topomap.core.names import printable

WIDE = 200  # columns of a table in a pipe, which has no width of its own

FAULT, PARTIAL, INTERRUPTED = 4, 3, 128
"""Exit codes: a run ended by a fault, a log isn't whole, a signal came (its number is added)."""


class PlainConsole(Console):
    """A console for which texts are texts: no markup in brackets, nothing in them that steers the terminal."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text as it is, but for control characters."""
        return super().render_str(printable(text), **(options | {"markup": False, "emoji": False}))


console = PlainConsole()
Advance = Callable[[int], None]


@contextmanager
def progress(label: str, total: int | None) -> Iterator[Advance]:
    """Show a bar on a terminal and nothing in a pipe; yields a function that takes the steps done so far."""
    columns = (_told(), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(printable(label), total=total)
        # how long the way home takes is not known beforehand: the total grows with it
        yield lambda done: bar.update(task, completed=done, total=total and max(total, done))


@contextmanager
def share(label: str) -> Iterator[Callable[[float, str], None]]:
    """Show a bar on a terminal and nothing in a pipe; yields a function that takes the share done and what is next."""
    columns = (_told(), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(printable(label), total=1.0)
        yield lambda done, what: bar.update(task, completed=done, description=printable(f"{label}: {what}"))


def _told() -> TextColumn:
    return TextColumn("{task.description}", markup=False)


def say(text: str) -> None:
    """Print one line, however long; an empty one isn't printed."""
    if text:
        console.print(text, soft_wrap=True, highlight=False)


def doubt(log: Path, wrong: str, partial: bool) -> None:
    """Say on standard error what is wrong with a log that was read; end with code 3 unless one is content with it."""
    if wrong:
        fail(f"{log}: {wrong}")
        if not partial:
            raise typer.Exit(PARTIAL)


def table(rows: list[tuple[str, str]], title: str) -> None:
    """Print rows of name and value."""
    shown = Table(title=title, show_header=False, title_justify="left")
    for name, value in rows:
        shown.add_row(name, value)
    console.print(shown)


def grid(title: str, headings: Sequence[str], lines: bool = False) -> Table:
    """Return an empty table whose cells are never cut; lines: between its rows. Brackets are no markup."""
    shown = Table(title=title, title_justify="left", show_lines=lines)
    for heading in headings:
        shown.add_column(heading, overflow="fold")
    return shown


def show_wide(shown: Table) -> None:
    """Print a table of many columns: as wide as the terminal, in a pipe so that nothing is cut."""
    (console if console.is_terminal else PlainConsole(file=console.file, width=WIDE)).print(shown)


def fail(message: str) -> None:
    """Print one line on standard error."""
    # a terminal that has gone takes no last words
    with suppress(OSError, ValueError):
        print(f"topomap: {printable(' '.join(message.split()))}", file=sys.stderr)


class Interrupted(BaseException):
    """A signal that would end the program; number: which one. No KeyboardInterrupt: all of these end with code 1."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


def interrupt_on_signals(numbers: Iterable[int]) -> None:
    """Let signals end the program as Ctrl-C does, so that what is open is closed; what is ignored (nohup) stays so."""

    def interrupt(number: int, _: FrameType | None) -> None:
        raise Interrupted(number)

    for number in numbers:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, interrupt)
