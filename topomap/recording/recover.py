"""Repairing a log that was cut off or damaged."""

from __future__ import annotations

from pathlib import Path

from logs.errors import LogError
from logs.recover import recover
from topomap.core.errors import DataError


def recover_log(source: Path, target: Path) -> tuple[str, str]:
    """Copy all that is readable of a log into a new file; return what was saved and, if anything, what was wrong.

    Raises DataError.
    """
    try:
        saved = recover(source, target)
    except LogError as error:
        raise DataError(str(error)) from error
    wrong = "" if saved.state.whole else f"{saved.state.word}: {saved.state.note}"
    return f"{saved.messages} messages saved, {saved.damaged} damaged records left out", wrong
