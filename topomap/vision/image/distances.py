"""H17, the distance along every bearing: measured, from the ground line, by polynomial, or taken as equal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.errors import DataError
from topomap.core.panorama import Panorama
from topomap.vision.image.ground_line import ground_line, ground_ranges

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
    if source == "ground":
        return filled(ground_ranges(panorama))
    return Distances(polynomial(panorama.rig.height - 0.5 - ground_line(panorama).rows), 1.0)


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
