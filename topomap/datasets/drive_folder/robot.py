"""A drive from a folder as a robot that is driven by somebody else: the stack watches and maps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.core.errors import DataError, ShapeError
from topomap.core.files import regular
from topomap.core.recorded import RecordedReading, RecordedRig
from topomap.core.records import Command, Motion
from topomap.core.robot import Reading
from topomap.datasets.drive_folder.reader import DriveFolder

EPOCH_NS = 1_600_000_000_000_000_000
"""[ns] Run time 0 of every drive: a fixed epoch, so that the same files give the same log."""
AS_THEY_ARE = (".png", ".jpg", ".jpeg")


@dataclass(frozen=True, slots=True)
class FolderTruth:
    """The true pose at a stamp; fits `topomap.core.robot.Truth`."""

    stamp_ns: int
    x: float
    y: float
    heading: float
    contact: bool = False


class FolderRobot:
    """Hands over a drive's readings one by one; a Robot and a TruthSource."""

    def __init__(self, drive: DriveFolder) -> None:
        self._drive = drive
        self._next = 0

    @property
    def rig(self) -> RecordedRig:
        """How the panoramas were taken."""
        return self._drive.rig

    def __len__(self) -> int:
        return len(self._drive.table)

    def sense(self) -> Reading | None:
        """Return the next reading, None at the end. Raises DataError for an image that can't be read or used."""
        table, k = self._drive.table, self._next
        if k >= len(table):
            return None
        self._next += 1
        dt = float(table.stamps_ns[k] - table.stamps_ns[max(k - 1, 0)]) * 1e-9
        forward, left, turn = table.deltas[k].tolist()
        motion = Motion(forward, left, turn, np.array(table.covariances[k]), dt)
        path = table.images[k]
        try:
            return RecordedReading(
                stamp_ns=EPOCH_NS + int(table.stamps_ns[k]), motion=motion, rig=self._drive.rig,
                encoded=_encoded(path), driven=True,
            )  # fmt: skip
        except (OSError, DataError, ShapeError) as error:
            raise DataError(f"{path}: can't be used as a panorama: {error}") from error

    def truth(self) -> FolderTruth | None:
        """Return the true pose at the last reading, None where the drive doesn't tell it."""
        table, k = self._drive.table, max(self._next - 1, 0)
        if table.truth is None:
            return None
        x, y, heading = table.truth[k].tolist()
        return FolderTruth(EPOCH_NS + int(table.stamps_ns[k]), x, y, heading)

    def act(self, command: Command) -> None:
        """Do nothing: the drive is over."""

    def stop(self) -> None:
        """Do nothing: nothing moves."""


def _encoded(path: Path) -> bytes:
    """Return an image's bytes. Raises DataError for a kind of file that the log doesn't hold."""
    if path.suffix.lower() not in AS_THEY_ARE:
        raise DataError(f"is none of {', '.join(AS_THEY_ARE)}")
    return regular(path).read_bytes()
