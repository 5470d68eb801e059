"""A drive's folder, read: its table, its rig, and what had to be assumed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from topomap.core.encoded import decode
from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.recorded import RecordedRig
from topomap.datasets.drive_folder import rig_file, table
from topomap.datasets.drive_folder.eye_level import find_eye_level
from topomap.datasets.drive_folder.table import DriveTable


@dataclass(frozen=True, slots=True)
class DriveFolder:
    """A drive: name, rig and table; notes: what the files left open and what was taken instead."""

    name: str
    rig: RecordedRig
    table: DriveTable
    notes: tuple[str, ...] = ()


def read_folder(folder: Path) -> DriveFolder:
    """Read a folder with `drive.csv`, `rig.json` and images. Raises DataError that names file, field and value."""
    if not folder.is_dir():
        raise DataError(f"{folder}: no such folder")
    drive = table.read_table(folder / table.NAME)
    height, width = _first(drive.images[0])
    said = rig_file.read_rig(folder / rig_file.NAME, width, height)
    notes = [f"odometry: {drive.odometry}"]
    row = (height - 1) / 2
    if said.horizon_row is None:
        found = find_eye_level(drive, said.rig(row))
        row = row if found is None else found.row
        told = (
            "isn't clear in the images: the middle row is taken" if found is None else f"is row {row:.1f} by the images"
        )
        notes.append(f"{rig_file.NAME} tells no horizon_row: eye level {told}")
    if said.camera_height == 0:
        notes.append(f"{rig_file.NAME} tells no camera_height: nothing is measured by the ground line")
    return DriveFolder(folder.resolve().name, said.rig(row), drive, tuple(notes))


def _first(path: Path) -> tuple[int, int]:
    """Return height and width of an image."""
    try:
        height, width = decode(regular(path).read_bytes()).shape[:2]
    except (OSError, DataError) as error:
        raise DataError(f"{path}: can't be read as an image: {error}") from error
    return height, width
