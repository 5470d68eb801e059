"""The ground line: where the floor ends in every column of a panorama, and how far off that is.

What lies below the line is one floor, alike in itself and unlike what stands just above it; the line goes on from
column to column and breaks only where one thing stands before another. The thesis's rule (5.1.1.2), the strongest
contrast of the halves above and below, takes a skirting board's upper edge for the floor's end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import BoolArray, Float32Array, FloatArray
from topomap.core.panorama import Panorama
from topomap.vision.image.seam import seam

BAND = 3  # rows above a line that are held against the floor below it
GREY = 10.0  # difference that is noise in any floor [grey levels]
FEW = 20  # rows of floor that are believed by half: a few rows are alike anywhere
CLEAR = 2.0  # contrast over the floor's own variance from which on a line is seen
STRONG = 3.0  # log contrast beyond which a line is no surer
BEND, BREAK = 0.15, 0.8  # what a row up or down costs, and a break, in units of a sure line
LEAST = 4.0  # rows below eye level nearer than which a distance means nothing


OFF = 0.25
"""[rows] By which all lines of a place may be off the same way: their medians were 0 to 0.6 rows off at 1.4 to 10 m in
five worlds, 0.23 rows (rms)."""


@dataclass(frozen=True, slots=True, eq=False)
class GroundLine:
    """rows (W,): the boundary above the first row of floor; seen (W,): where there is one."""

    rows: FloatArray
    seen: BoolArray


def ground_line(panorama: Panorama) -> GroundLine:
    """Return where the floor ends (H17), computed once per panorama."""
    return panorama.derived("ground line", _ground_line)


def ground_ranges(panorama: Panorama) -> Float32Array:
    """Return the distance (W,) [m] to where the floor ends, NaN where that isn't seen or too near the horizon.

    All NaN where the rig doesn't tell the camera's height.
    """
    return panorama.derived("ground ranges", _ground_ranges)


def way_bias(panorama: Panorama) -> float:
    """Return the share by which a way driven comes out wrong, measured by ground ranges as usual in this view; infinity
    where there are none.

    A line off by some rows puts what is r away off by r^2 times as much, and what is twice as far by four times.
    """
    ranges, rig = ground_ranges(panorama), panorama.rig
    if not np.isfinite(ranges).any():
        return math.inf
    return OFF * 2.0 * float(np.nanmedian(ranges)) / (rig.camera_height * rig.focal)


def _ground_ranges(panorama: Panorama) -> Float32Array:
    line, rig = ground_line(panorama), panorama.rig
    below = line.rows - rig.horizon_row
    good = line.seen & (below >= LEAST) & (rig.camera_height > 0.0)
    return np.where(good, rig.camera_height * rig.focal / np.maximum(below, LEAST), np.nan).astype(np.float32)


def _ground_line(panorama: Panorama) -> GroundLine:
    first = max(int(panorama.rig.horizon_row) + 1, BAND)
    if first > panorama.rig.height - 3:
        return GroundLine(
            np.full(panorama.rig.width, panorama.rig.height - 0.5), np.zeros(panorama.rig.width, np.bool_)
        )
    contrast = _contrast(panorama, first)
    path = seam(np.minimum(np.log1p(contrast), STRONG) / STRONG, BEND, BREAK)
    return GroundLine(path + first - 0.5, contrast[path, np.arange(len(path))] >= CLEAR)


def _contrast(panorama: Panorama, first: int) -> FloatArray:
    """Return (R, W), for the rows from `first` on, how unlike what stands above each is to a floor from it on down."""
    image = cv2.GaussianBlur(panorama.image, (0, 0), 0.7, borderType=cv2.BORDER_REPLICATE).astype(np.float32)
    below = image[first:]
    rows = np.arange(len(below), 0, -1, dtype=np.float32)[:, np.newaxis, np.newaxis]
    mean = np.cumsum(below[::-1], axis=0)[::-1] / rows
    variance = np.maximum(np.cumsum(below[::-1] ** 2, axis=0)[::-1] / rows - mean**2, 0.0)
    summed = np.cumsum(np.concatenate([np.zeros((1, *image.shape[1:])), image[first - BAND :]]), axis=0)
    above = (summed[BAND : BAND + len(below)] - summed[: len(below)]) / BAND
    unlike = ((above - mean) ** 2).sum(axis=2) / (variance.sum(axis=2) + GREY**2)
    return np.asarray(unlike * (rows / (rows + FEW))[:, :, 0])
