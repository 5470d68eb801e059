"""A view in which hidden columns are filled from those beside them."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.recorded import Spans


def filled(panorama: Panorama, spans: Spans) -> Panorama:
    """Return the view (H, W, 3) with each span faded from the column before it to the one behind it, row by row.

    A bar hides what stands behind it either way; as it is, its edges would be the sharpest of the view, and turn with
    the robot. The ranges stay: the scanner isn't the camera.
    """
    if not spans:
        return panorama
    return panorama.derived(("filled", spans), lambda hidden: _filled(hidden, spans))


def columns_of(spans: Spans, width: int) -> tuple[tuple[int, int], ...]:
    """Return the first column and the number of columns of a view `width` wide that each span touches."""
    unit, tiny = TAU / width, 1e-4
    touched = []
    for start, extent in spans:
        first = math.floor(start / unit + 0.5 + tiny)
        last = math.ceil((start + extent) / unit + 0.5 - tiny) - 1
        touched.append((first % width, min(last - first + 1, width - 2)))
    return tuple(touched)


def _filled(panorama: Panorama, spans: Spans) -> Panorama:
    image = panorama.image.copy()
    width = panorama.rig.width
    for first, count in columns_of(spans, width):
        share = (np.arange(1, count + 1) / (count + 1))[None, :, None]
        before, behind = (panorama.image[:, [column % width]] for column in (first - 1, first + count))
        faded = (1.0 - share) * before + share * behind
        image[:, np.arange(first, first + count) % width] = np.rint(faded).astype(np.uint8)
    return Panorama(image, panorama.ranges, panorama.rig)
