"""A leaning camera's view as an upright one would have it."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from topomap.core.arrays import Image
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.tilt.lean import Lean

STEP = math.radians(0.05)
"""[rad] Leans are taken out to a twentieth of a degree, a tenth of a pixel of 720 columns, so that maps are reused."""


def upright(panorama: Panorama, lean: Lean) -> Panorama:
    """Return the view (H, W, 3) with the lean taken out; rows that the camera didn't see repeat the last one it saw.

    The ranges stay: the scanner isn't the camera.
    """
    roll, pitch = round(lean.roll / STEP), round(lean.pitch / STEP)
    if not roll and not pitch:
        return panorama
    return panorama.derived(("upright", roll, pitch), lambda leaning: _turned(leaning, roll, pitch))


def _turned(panorama: Panorama, roll: int, pitch: int) -> Panorama:
    where = _maps(panorama.rig, roll, pitch)
    ring = np.concatenate([panorama.image, panorama.image[:, :1]], axis=1)
    image = cv2.remap(ring, *where, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return Panorama(image.astype(np.uint8, copy=False), panorama.ranges, panorama.rig)


@lru_cache(maxsize=32)
def _maps(rig: Rig, roll: int, pitch: int) -> tuple[Image, Image]:
    """Return for every pixel of the upright view (H, W) its column and row in the leaning one, as OpenCV packs them."""
    bearings = np.arange(rig.width) * (TAU / rig.width)
    up = (rig.horizon_row - np.arange(rig.height, dtype=np.float64))[:, np.newaxis] / rig.focal
    cr, sr, cp, sp = (f(angle * STEP) for angle in (roll, pitch) for f in (math.cos, math.sin))
    # x ahead, y left, z up: first back about y by the pitch, then about x by the roll
    ahead, above = cp * np.cos(bearings) - sp * up, sp * np.cos(bearings) + cp * up
    left, above = cr * np.sin(bearings) + sr * above, cr * above - sr * np.sin(bearings)
    columns = np.mod(np.arctan2(left, ahead) * (rig.width / TAU), rig.width)
    rows = rig.horizon_row - rig.focal * above / np.hypot(ahead, left)
    # in whole pixels and thirty-seconds OpenCV is twice as fast
    return cv2.convertMaps(columns.astype(np.float32), rows.astype(np.float32), cv2.CV_16SC2)
