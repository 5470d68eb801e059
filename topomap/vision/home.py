"""From one panorama to another in a line."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from topomap.core.arrays import Image
from topomap.core.encoded import decode
from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.aligned_homing import Method
from topomap.vision.contracts import Aligner
from topomap.vision.registry import aligned_homing


def home(current: Panorama, goal: Panorama, method: str | Method | Aligner = "auto") -> HomeVector:
    """Return where the goal lies, seen from the current view: bearing [rad, counter-clockwise from the nose].

    method: a name of the registry or an object of one's own. One that needs a compass takes the automatic choice's
    rotation; a policy, which must move, gives its first move. Raises DataError, ShapeError.
    """
    homing = aligned_homing(method, otherwise="auto")
    if homing.policy is None:
        return homing.home(current, goal).home
    return homing.move(homing.policy.start(goal), current, homing.aligner.align(current, goal).rotation)[1]


def load_panorama(path: Path | str, horizon_row: float | None = None) -> Panorama:
    """Return a panorama from an image file whose centre column looks ahead and whose columns run clockwise.

    horizon_row: the row of eye level, the middle if None. Raises DataError.
    """
    try:
        seen = decode(regular(Path(path)).read_bytes())
    except (OSError, DataError) as error:
        raise DataError(f"{path}: can't be read as an image: {getattr(error, 'strerror', None) or error}") from error
    image: Image = np.ascontiguousarray(seen[:, ::-1])
    height, width = image.shape[:2]
    row = (height - 1) / 2 if horizon_row is None else horizon_row
    rolled = np.roll(image, -(width - 1 - width // 2), axis=1)
    return Panorama(rolled, None, Rig(width, height, row, width / TAU))
