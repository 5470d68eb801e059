"""Haar-like masks on the cylinder, scored by an integral image that runs around the seam (chapter 4)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import shrunk

_PARTS: tuple[tuple[tuple[float, float, float, float, int], ...], ...] = (
    ((0, 0, 1, 1, 1),),
    ((0, 0, 1 / 2, 1, 1), (1 / 2, 0, 1, 1, -1)),
    ((0, 0, 1, 1 / 2, 1), (0, 1 / 2, 1, 1, -1)),
    ((0, 0, 1 / 3, 1, 1), (1 / 3, 0, 2 / 3, 1, -1), (2 / 3, 0, 1, 1, 1)),
    ((0, 0, 1, 1 / 3, 1), (0, 1 / 3, 1, 2 / 3, -1), (0, 2 / 3, 1, 1, 1)),
    ((0, 0, 1 / 2, 1 / 2, 1), (1 / 2, 0, 1, 1 / 2, -1), (0, 1 / 2, 1 / 2, 1, -1), (1 / 2, 1 / 2, 1, 1, 1)),
)
"""The six types (fig. 4.11), each of rectangles (left, top, right, bottom, sign) as shares of the mask."""


@dataclass(frozen=True, slots=True, eq=False)
class Masks:
    """N masks of up to four rectangles: corners (4, N, 4) left, top, right, bottom [pixels], sign (4, N), 0 where
    unused, and the bearing (N,) [rad] of each centre.
    """

    corners: IntArray
    signs: IntArray
    bearings: FloatArray


@dataclass(frozen=True, slots=True)
class MaskSpec:
    """A random set: how many, from which seed, widths 6-120 and heights 18-60 of 720 x 120 (4.1.2), centres
    within +-10 rows of the horizon; even: centres evenly around instead of at random (4.35), so many `candidates`
    on each direction; kinds: which of the types I-VI (1-6) are drawn; blur (sigma) [columns]: low-pass before (4.34).
    """

    count: int = 1000
    seed: int = 0
    width: tuple[float, float] = (6 / 720, 120 / 720)
    height: tuple[float, float] = (18 / 120, 60 / 120)
    centre: float = 10 / 120
    even: bool = False
    candidates: int = 1
    kinds: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    blur: float = 0.0


WIDE = MaskSpec(width=(120 / 720, 360 / 720), height=(0.5, 0.92))
"""Masks as large as what stays in sight of a place: with three references they are off by 15-19 deg in a1original and
ourlab, where the printed sizes are off by 44-56 and the printed heights alone by 30-36 (seed 0).
"""


@lru_cache(maxsize=8)
def masks(spec: MaskSpec, columns: int, rows: int, horizon: float) -> Masks:
    """Return the masks of a recipe for a panorama of (rows, columns) with eye level at row `horizon`."""
    rng = np.random.default_rng(spec.seed)
    kind = np.asarray(spec.kinds)[rng.integers(0, len(spec.kinds), spec.count)] - 1
    wide = np.maximum(rng.uniform(*spec.width, spec.count) * columns, 2.0)
    high = np.clip(rng.uniform(*spec.height, spec.count) * rows, 2.0, rows)
    column = rng.uniform(0, columns, spec.count)
    if spec.even:
        column = np.asarray(np.arange(spec.count) // spec.candidates * (columns * spec.candidates / spec.count), float)
    row = horizon + 0.5 + rng.uniform(-spec.centre, spec.centre, spec.count) * rows
    corners, signs = np.zeros((4, spec.count, 4), np.int64), np.zeros((4, spec.count), np.int64)
    left, top = column - wide / 2, np.clip(row - high / 2, 0.0, rows - high)
    for k, parts in enumerate(_PARTS):
        for n, (x0, y0, x1, y1, sign) in enumerate(parts):
            mine = kind == k
            box = np.stack([left + x0 * wide, top + y0 * high, left + x1 * wide, top + y1 * high], axis=1)
            corners[n, mine], signs[n, mine] = np.rint(box[mine]).astype(np.int64), sign
    corners[:, :, 2:] = np.maximum(corners[:, :, 2:], corners[:, :, :2] + 1)
    corners[:, :, (1, 3)] = np.clip(corners[:, :, (1, 3)], 0, rows)
    corners[:, :, 1] = np.minimum(corners[:, :, 1], rows - 1)
    corners[:, :, 3] = np.maximum(corners[:, :, 3], corners[:, :, 1] + 1)
    return Masks(corners, signs, (column - 0.5) * TAU / columns)


def scores(panorama: Panorama, spec: MaskSpec) -> FloatArray:
    """Return |mean of the white - mean of the black part| (N,) of every mask (4.1, 4.8), in units of the view's mean.

    So a gain changes nothing; a view of mean 0 and variance 1 would fold type I's scores at the mean.
    """
    rig = panorama.rig
    chosen = masks(spec, rig.width, rig.height, rig.horizon_row)
    integral = integral_image(panorama, spec.blur)
    sums, areas = box_sums(integral, chosen.corners)
    white, black = chosen.signs > 0, chosen.signs < 0
    means = [(sums * part).sum(axis=0) / np.maximum((areas * part).sum(axis=0), 1) for part in (white, black)]
    return np.asarray(np.abs(means[0] - means[1]), np.float64)


def integral_image(panorama: Panorama, blur: float = 0.0) -> FloatArray:
    """Return the integral image (H + 1, W + 1) of the grey view over its mean, computed once per panorama.

    blur (sigma) [columns]: of a low-pass around the seam.
    """
    return panorama.derived(("integral", blur), lambda p: _integral(p, blur))


def _integral(panorama: Panorama, blur: float) -> FloatArray:
    grey = shrunk(panorama, panorama.rig.width, panorama.rig.height, blur).astype(np.float64)
    level = float(grey.mean())
    summed = np.zeros((grey.shape[0] + 1, grey.shape[1] + 1))
    if level > 0.0:
        summed[1:, 1:] = (grey / level).cumsum(axis=0).cumsum(axis=1)
    return summed


def box_sums(integral: FloatArray, corners: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the sums (...) over rectangles (..., 4) and their areas; columns may lie beyond the seam."""
    left, top, right, bottom = np.moveaxis(corners, -1, 0)
    around, columns = integral[:, -1], integral.shape[1] - 1

    def until(row: IntArray, column: IntArray) -> FloatArray:
        turns, rest = np.divmod(column, columns)
        return np.asarray(integral[row, rest] + turns * around[row], np.float64)

    total = until(bottom, right) - until(top, right) - until(bottom, left) + until(top, left)
    return total, (right - left) * (bottom - top)
