"""H17, the distance along every bearing: measured, from the ground line, by polynomial, or taken as equal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.errors import DataError
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.ground_line import LEAST, ground_line, ground_ranges

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
    line, rig = ground_line(panorama), panorama.rig
    good = line.seen & (line.rows - rig.horizon_row >= LEAST)
    fitted = polynomial(rig.height - 0.5 - line.rows, *fitted_coefficients(rig))
    return filled(np.where(good, fitted, np.nan).astype(np.float32))


def filled(ranges: Float32Array) -> Distances:
    """Return ranges (W,) with the unmeasured directions interpolated around the circle; all zero if none is."""
    good = np.isfinite(ranges) & (ranges > 0) & (ranges < FAR)
    if not good.any():
        return Distances(np.zeros(len(ranges)), 0.0)
    measured = np.flatnonzero(good)
    metres = np.interp(np.arange(len(ranges)), measured, ranges[measured].astype(np.float64), period=len(ranges))
    return Distances(metres, len(measured) / len(ranges))


PRINTED = (0.10, 0.05, 0.000143, 0.0000018)
"""(5.1) in metres, whose coefficients are printed in reverse order: of the thesis's own mirror."""


def polynomial(rows_up: FloatArray, *coefficients: float) -> FloatArray:
    """Return the distance [m] of a ground line `rows_up` (...) pixels above the lowest row: a cubic (5.1).

    coefficients [m]: of rows_up^0 and so on; none: as printed, d [cm] = 10 + 5 d_r + 0.0143 d_r^2 + 0.00018 d_r^3.
    """
    return np.asarray(np.polynomial.polynomial.polyval(rows_up, coefficients or PRINTED), np.float64)


@lru_cache(maxsize=8)
def fitted_coefficients(rig: Rig) -> tuple[float, ...]:
    """Return the cubic's coefficients [m] for a rig: least squares of the ratio to its floor's true distances."""
    rows = np.arange(rig.horizon_row + LEAST, rig.height, 0.5)
    if len(rows) < 4:
        return (0.0, 0.0, 0.0, 0.0)
    true = rig.camera_height * rig.focal / (rows - rig.horizon_row)
    powers = np.vander(rig.height - 0.5 - rows, 4, increasing=True)
    return tuple(np.linalg.lstsq(powers / true[:, np.newaxis], np.ones(len(rows)), rcond=None)[0].tolist())
