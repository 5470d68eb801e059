"""Eye level of a drive whose rig file doesn't tell it: found in pairs of its views."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from topomap.core.encoded import decode
from topomap.core.files import regular
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.datasets.drive_folder.table import DriveTable
from topomap.vision.eye_level import EyeLevel, eye_level
from topomap.vision.image.compare import rotation_difference, signature

PAIRS = 8  # more tell little more, and cost half a second each
CHANGED = 0.6
"""Image difference that makes a pair: points have moved, and most are still there."""
FRAMES = 60  # at most from one view of a pair to the other


def find_eye_level(drive: DriveTable, rig: RecordedRig) -> EyeLevel | None:
    """Return eye level as the drive's images show it, None where they don't; rig: with any horizon_row."""
    pairs = []
    for first in np.unique(np.linspace(0, len(drive) - 2, PAIRS).astype(int)).tolist():
        before = _view(drive.images[first], rig)
        for last in range(first + 1, min(first + FRAMES, len(drive))):
            after = _view(drive.images[last], rig)
            if rotation_difference(signature(after), signature(before))[0] > CHANGED:
                pairs.append((before, after, float(drive.deltas[first + 1 : last + 1, 2].sum())))
                break
    return eye_level(pairs)


def _view(path: Path, rig: RecordedRig) -> Panorama:
    return Panorama.from_recorded(decode(regular(path).read_bytes()), rig)
