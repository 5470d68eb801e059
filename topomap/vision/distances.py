"""H17, the distance along every bearing: measured, from the ground line, by polynomial, or taken as equal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from topomap.errors import DataError
from topomap.geometry import FloatArray
from topomap.types import Float32Array
from topomap.vision.panorama import Panorama

Source = Literal["range", "ground", "polynomial", "equal"]
FAR = 50.0
"""Ranges [m] beyond this are the sensor's way of saying nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Distances:
    """metres (W,), one for every column, gaps interpolated; share in [0, 1] of the columns that were measured."""

    metres: FloatArray
    share: float


def distances(panorama: Panorama, source: Source) -> Distances:
    """Return the distance along every column (H17), computed once per panorama. Raises DataError without ranges."""
    return panorama.derived(("distances", source), lambda p: _distances(p, source))


def _distances(panorama: Panorama, source: Source) -> Distances:
    if source == "equal":
        return Distances(np.ones(panorama.rig.width), 1.0)
    if source == "range":
        if panorama.ranges is None:
            raise DataError("this homing method needs measured ranges, and the panorama has none")
        return filled(panorama.ranges)
    rows = ground_rows(panorama)
    below = np.maximum(rows - panorama.rig.horizon_row, 1.0)
    if source == "ground":
        return Distances(panorama.rig.camera_height * panorama.rig.focal / below, 1.0)
    return Distances(polynomial(panorama.rig.height - 1 - rows), 1.0)


def filled(ranges: Float32Array) -> Distances:
    """Return ranges (W,) with the unmeasured directions interpolated around the circle; all zero if none is."""
    good = np.isfinite(ranges) & (ranges > 0) & (ranges < FAR)
    if not good.any():
        return Distances(np.zeros(len(ranges)), 0.0)
    measured = np.flatnonzero(good)
    metres = np.interp(np.arange(len(ranges)), measured, ranges[measured].astype(np.float64), period=len(ranges))
    return Distances(metres, len(measured) / len(ranges))


def polynomial(rows_up: FloatArray) -> FloatArray:
    """Return the distance [m] of a ground line `rows_up` (...) pixels above the lowest row.

    (5.1), whose coefficients are printed in reverse order: d [cm] = 10 + 5 d_r + 0.0143 d_r^2 + 0.00018 d_r^3.
    """
    metres: FloatArray = (10.0 + 5.0 * rows_up + 0.0143 * rows_up**2 + 0.00018 * rows_up**3) / 100.0
    return metres


def ground_rows(panorama: Panorama) -> FloatArray:
    """Return the row (W,) of each column where the floor ends: the strongest horizontal edge below the horizon.

    The edge is where the mean colour above and below differs most (5.1.1.2), smoothed along the bearing.
    """
    first = min(int(panorama.rig.horizon_row) + 1, panorama.rig.height - 1)
    below = panorama.image[first:].astype(np.float32)
    count = len(below)
    if count < 3:
        return np.full(panorama.rig.width, float(panorama.rig.height - 1))
    summed = np.cumsum(below, axis=0)
    size = np.arange(1, count, dtype=np.float32)[:, np.newaxis, np.newaxis]
    # mean above minus mean below, times the square root of their sizes' product
    contrast = summed[:-1] * (count / np.sqrt(size * (count - size))) - summed[-1] * np.sqrt(size / (count - size))
    highest = _smooth(np.abs(contrast).sum(axis=2)).argmax(axis=0)
    return np.asarray(highest + (first + 0.5), np.float64)


def _smooth(score: Float32Array) -> Float32Array:
    pad = min(8, score.shape[1])
    wrapped = np.concatenate([score[:, -pad:], score, score[:, :pad]], axis=1)
    return np.asarray(cv2.blur(wrapped, (9, 1))[:, pad : pad + score.shape[1]], np.float32)
