"""What tells two places of the same grey apart: the colour of what is seen, whatever its light."""

from __future__ import annotations

import cv2
import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.vision.image.compare import PLACE, shrunk
from topomap.vision.image.displaced import displaced, distances_or_middling

FINER = 2
"""Columns and rows of the picture that is displaced, to one of the small view."""
DARK = 30.0
"""Grey levels, of three channels together, below which a colour is more noise than colour."""
EXACT = 0.05
"""Difference up to which places are of one colour: as seen from the point that was found, a place differs by 0.001 to
0.03 from its own view (0.1 to 0.5 without, up to 0.35 m off), by 0.2 and more from one with another door."""
FAINT = 0.02
"""Variation of colour shares that says nothing: what white balance, light from another side and JPEG leave."""


def unlike(view: Panorama, place: Panorama, rotation: float, point: tuple[float, float]) -> float:
    """Return how unlike in colour a view and a place's are: 0 for the same, 2 for unrelated ones.

    rotation [rad]: the view's heading minus the place's; point [m]: where the place is, ahead and to the left. 0 where
    one of them has no colour, or is of another size.
    """
    here, there = tint(view, point), tint(place)
    if here.shape != there.shape or not here.any() or not there.any():
        return 0.0
    columns = round(rotation * there.shape[1] / TAU)
    apart = float(np.square(here - np.roll(there, -columns, axis=1)).mean())
    varied = float(np.square(here).mean() + np.square(there).mean())
    return max(0.0, 2.0 * apart / (varied + FAINT**2) - EXACT)


def tint(panorama: Panorama, point: tuple[float, float] = (0.0, 0.0)) -> Float32Array:
    """Return the shares (R, C, 2) of red and green in the light of each cell, less their mean, predicted for a point
    [m] ahead and to the left, looking the same way.

    Brightness is out of it, and the colour of the light as a whole. A camera without colour has zeros.
    """
    return panorama.derived(("tint", point), lambda whole: _tint(whole.derived("small colour", _small), point))


def _tint(small: Panorama, point: tuple[float, float]) -> Float32Array:
    there = displaced(small, *point) if any(point) else small
    seen = shrunk(there, PLACE.columns, PLACE.rows, PLACE.blur, colour=True)
    share = seen[:, :, :2] / (seen.sum(axis=2, keepdims=True) + np.float32(DARK))
    told: Float32Array = share - share.mean(axis=(0, 1), keepdims=True)
    return told if np.ptp(small.image, axis=2).any() else np.zeros_like(told)


def _small(whole: Panorama) -> Panorama:
    """Return a view of few pixels, with how far away what each column shows stands in place of its ranges."""
    rig = whole.rig
    columns, rows = min(FINER * PLACE.columns, rig.width), min(FINER * PLACE.rows, rig.height)
    image = np.asarray(cv2.resize(whole.image, (columns, rows), interpolation=cv2.INTER_AREA), np.uint8)
    bearings = np.arange(columns) * (rig.width / columns)
    far = np.interp(bearings, np.arange(rig.width), distances_or_middling(whole), period=rig.width)
    scale = rows / rig.height
    small = RecordedRig(
        columns, rows, (rig.horizon_row + 0.5) * scale - 0.5, rig.focal * scale, rig.camera_height, 0, False
    )
    return Panorama.from_recorded(image, small, far.astype(np.float32))
