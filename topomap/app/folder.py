"""The folder of a run: one place for its log, map, summary and report."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from topomap.core.errors import DataError


@dataclass(frozen=True, slots=True)
class RunFolder:
    """Where a run's files lie."""

    path: Path

    @property
    def log(self) -> Path:
        """The MCAP log."""
        return self.path / "run.mcap"

    @property
    def map(self) -> Path:
        """The finished map."""
        return self.path / "run.topomap"

    @property
    def summary(self) -> Path:
        """The summary for programs."""
        return self.path / "summary.json"

    @property
    def report(self) -> Path:
        """The report for people."""
        return self.path / "report.html"

    @staticmethod
    def create(path: Path, keep: Path | None = None) -> RunFolder:
        """Make the folder; its files are replaced by the new run's. Raises DataError.

        keep: a file that must not be written over, as a replay reads it.
        """
        folder = RunFolder(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise DataError(f"{path}: the output folder can't be made ({error.strerror})") from error
        if keep is not None and folder.log.exists() and folder.log.samefile(keep):
            raise DataError(f"{path}: holds the log that is read; choose another --out")
        return folder


def make_writable(path: Path) -> None:
    """Make a folder and see that it can be written, before hours of work. Raises DataError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise DataError(f"{path}: the output folder can't be written ({error.strerror})") from error
