"""Eye level of a drive whose rig file doesn't tell it: found in pairs of its views, taken upright where they lean."""

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
from topomap.vision.tilt.lean import Lean
from topomap.vision.tilt.mount import Mount
from topomap.vision.tilt.upright import upright

PAIRS = 8  # more tell little more, and cost half a second each
CHANGED = 0.6
"""Image difference that makes a pair: points have moved, and most are still there."""
FRAMES = 60  # at most from one view of a pair to the other

LOOKS = 60
"""Views by which the camera's lean is found: a camera that leans 3 degrees forward hides eye level, or puts it 5 rows
off (of 100), and within half a row where the lean is taken out."""


def find_eye_level(drive: DriveTable, rig: RecordedRig) -> EyeLevel | None:
    """Return eye level as the drive's images show it, None where they don't; rig: with any horizon_row."""
    pairs, lean = [], _lean(drive, rig)
    for first in np.unique(np.linspace(0, len(drive) - 2, PAIRS).astype(int)).tolist():
        before = upright(_view(drive.images[first], rig), lean)
        for last in range(first + 1, min(first + FRAMES, len(drive))):
            after = upright(_view(drive.images[last], rig), lean)
            if rotation_difference(signature(after), signature(before))[0] > CHANGED:
                pairs.append((before, after, float(drive.deltas[first + 1 : last + 1, 2].sum())))
                break
    return eye_level(pairs)


def _lean(drive: DriveTable, rig: RecordedRig) -> Lean:
    mount = Mount(every=1)
    for k in np.unique(np.linspace(0, len(drive) - 1, LOOKS).astype(int)).tolist():
        mount.see(_view(drive.images[k], rig))
    return mount.lean


def _view(path: Path, rig: RecordedRig) -> Panorama:
    return Panorama.from_recorded(decode(regular(path).read_bytes()), rig)
