"""The skyline: where the sky or ceiling begins in every column of a panorama (2.6.3.1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.vision.image.ground_line import ground_line


def skyline(panorama: Panorama) -> FloatArray:
    """Return the slope (W,), tan of the elevation, of the lowest point of sky or ceiling; 0 where none is seen.

    It is the ground line of the view turned upside down: what lies beyond it is one surface, alike in itself.
    """
    return panorama.derived("skyline", _skyline)


def _skyline(panorama: Panorama) -> FloatArray:
    rig = panorama.rig
    last = rig.height - 1
    over = Panorama(np.ascontiguousarray(panorama.image[::-1]), None, replace(rig, horizon_row=last - rig.horizon_row))
    line = ground_line(over)
    return np.where(line.seen, (rig.horizon_row - (last - line.rows)) / rig.focal, 0.0)
