"""What every command shares: the console, the progress bar, one clear line for an expected error."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from rich.console import Console
from rich.markup import escape
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

WIDE = 200  # columns of a table in a pipe, which has no width of its own

console = Console()
Advance = Callable[[int], None]


@contextmanager
def progress(label: str, total: int | None) -> Iterator[Advance]:
    """Show a bar on a terminal and nothing in a pipe; yields a function that takes the steps done so far."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(label, total=total)
        # how long the way home takes is not known beforehand: the total grows with it
        yield lambda done: bar.update(task, completed=done, total=total and max(total, done))


@contextmanager
def share(label: str) -> Iterator[Callable[[float, str], None]]:
    """Show a bar on a terminal and nothing in a pipe; yields a function that takes the share done and what is next."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(label, total=1.0)
        yield lambda done, what: bar.update(task, completed=done, description=f"{label}: {escape(what)}")


def table(rows: list[tuple[str, str]], title: str) -> None:
    """Print rows of name and value."""
    shown = Table(title=title, show_header=False, title_justify="left")
    for name, value in rows:
        shown.add_row(name, value)
    console.print(shown)


def grid(title: str, headings: Sequence[str], lines: bool = False) -> Table:
    """Return an empty table whose cells are never cut; lines: between its rows. Brackets are no markup."""
    shown = Table(title=escape(title), title_justify="left", show_lines=lines)
    for heading in headings:
        shown.add_column(escape(heading), overflow="fold")
    return shown


def show_wide(shown: Table) -> None:
    """Print a table of many columns: as wide as the terminal, in a pipe so that nothing is cut."""
    (console if console.is_terminal else Console(file=console.file, width=WIDE)).print(shown)


def fail(message: str) -> None:
    """Print one line on standard error."""
    print(f"topomap: {' '.join(message.split())}", file=sys.stderr)


def terminate_as_interrupt() -> None:
    """Let SIGTERM end a run as Ctrl-C does: wheels stopped, log closed, summary written."""

    def interrupt(_: int, __: FrameType | None) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
