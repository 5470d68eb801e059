"""From one panorama to another in a line."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from topomap.core.arrays import Image
from topomap.core.errors import DataError
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.homing import METHODS
from topomap.vision.homing.auto import Auto
from topomap.vision.homing.needs import check

AUTO = Auto()


def home(current: Panorama, goal: Panorama, method: str = "auto") -> HomeVector:
    """Return where the goal lies, seen from the current view: bearing [rad, counter-clockwise from the nose].

    A method that needs a compass takes the automatic choice's rotation. Raises DataError, ShapeError.
    """
    if method not in METHODS:
        raise DataError(f"no homing method {method!r}; there are {', '.join(METHODS)}")
    chosen = METHODS[method]
    for view in (current, goal):
        check(chosen.needs, view)
    columns = current.columns(AUTO.align(current, goal).rotation) if chosen.needs.compass else 0
    found = chosen.home(chosen.describe(current.rolled(columns)), chosen.describe(goal))
    bearing = wrap(found.bearing - columns * TAU / current.rig.width)
    return HomeVector(bearing, found.distance, found.confidence)


def load_panorama(path: Path | str, horizon_row: float | None = None) -> Panorama:
    """Return a panorama from an image file whose centre column looks ahead and whose columns run clockwise.

    horizon_row: the row of eye level, the middle if None. Raises DataError.
    """
    bgr = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if bgr is None:
        raise DataError(f"{path} can't be read as an image")
    image: Image = np.ascontiguousarray(bgr[:, ::-1, ::-1]).astype(np.uint8, copy=False)
    height, width = image.shape[:2]
    row = (height - 1) / 2 if horizon_row is None else horizon_row
    rolled = np.roll(image, -(width - 1 - width // 2), axis=1)
    return Panorama(rolled, None, Rig(width, height, row, width / TAU))
