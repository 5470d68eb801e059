"""What a log holds, as rows for a terminal."""

from __future__ import annotations

from pathlib import Path

from logs.errors import LogError
from logs.info import info
from topomap.core.errors import DataError

Rows = list[tuple[str, str]]


def describe_log(path: Path) -> tuple[Rows, Rows, str]:
    """Return rows on the log, rows of its topics and, if anything is, what is wrong with it. Raises DataError."""
    try:
        found = info(path)
    except LogError as error:
        raise DataError(str(error)) from error
    state = "complete" if found.state.whole else f"not complete, {found.state.word}: {found.state.note}"
    about = [
        ("world", found.header.world),
        ("seed", str(found.header.seed)),
        ("state", state),
        ("steps", str(found.steps)),
        ("duration", f"{found.duration_s:.1f} s"),
        ("size", f"{found.size / 1e6:.1f} MB"),
        ("messages", str(found.messages)),
        ("attachments", ", ".join(found.attachments)),
        ("versions", ", ".join(f"{name} {number}" for name, number in found.header.versions.items())),
    ]
    wrong = "" if found.state.whole else f"{found.state.word}: {found.state.note}"
    return about, [(t.topic, f"{t.messages} x {t.schema}") for t in found.topics], wrong
