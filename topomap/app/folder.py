"""The folder of a run: one place for its log, map, summary and report, and one run at a time in it."""

from __future__ import annotations

import errno
import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from topomap.core.errors import DataError


@dataclass(frozen=True, slots=True)
class RunFolder:
    """Where a run's files lie; force: what an earlier run left there is replaced."""

    path: Path
    force: bool = False

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

    @property
    def files(self) -> tuple[Path, ...]:
        """All of the above."""
        return self.log, self.map, self.summary, self.report

    @staticmethod
    def create(path: Path, keep: Path | None = None, force: bool = False) -> RunFolder:
        """Make the folder for a new run. Raises DataError where another run has it or, unless forced, left files there.

        keep: a file that must not be written over, as a replay reads it.
        """
        folder = RunFolder(path, force)
        _make(path)
        if keep is not None and folder.log.exists() and folder.log.samefile(keep):
            raise DataError(f"{path}: holds the log that is read; choose another --out")
        with folder.owned():
            folder.check()
        return folder

    @staticmethod
    def beside(path: Path, log: Path, force: bool = False) -> RunFolder:
        """Make the folder for what is written of a log. Raises DataError where another run's files lie there."""
        folder = RunFolder(path, force)
        _make(path)
        if not (folder.log.exists() and folder.log.samefile(log)):
            folder.check()
        return folder

    def check(self) -> None:
        """Raise DataError where files of an earlier run are and may not be replaced."""
        there = [path.name for path in self.files if _exists(path)]
        if there and not self.force:
            raise DataError(
                f"{self.path}: holds a run already ({', '.join(there)}); choose another --out or give --force"
                " (Python: force=True)"
            )

    def clear(self) -> None:
        """Take away what an earlier run left, links and not what they lead to. Raises DataError."""
        self.check()
        try:
            for path in self.files:
                path.unlink(missing_ok=True)
        except OSError as error:
            raise DataError(f"{path}: an earlier run's file can't be replaced ({error.strerror})") from error

    @contextmanager
    def owned(self) -> Iterator[None]:
        """Keep every other run out. Raises DataError where one is in already."""
        number = -1
        try:
            number = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (errno.EWOULDBLOCK, errno.EAGAIN):
                os.close(number)
                raise DataError(f"{self.path}: another run is writing there; choose another --out") from error
            # some network file systems have no locks: what isn't there can't be asked for
        try:
            yield
        finally:
            if number >= 0:
                with suppress(OSError):
                    os.close(number)


def _make(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise DataError(f"{path}: the output folder can't be made ({why})") from error


def _exists(path: Path) -> bool:
    return path.exists() or path.is_symlink()


def make_writable(path: Path) -> None:
    """Make a folder and see that it can be written, before hours of work. Raises DataError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise DataError(f"{path}: the output folder can't be written ({error.strerror})") from error
