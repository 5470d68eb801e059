"""The scale-plane stack's one side: a panorama's edge columns at several magnifications about the horizon."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import normalised, shrunk


@dataclass(frozen=True, slots=True)
class WarpingSpec:
    """The recipe: columns, rows [pixels] of the small views; phases: how many fractions of a column a
    landmark's shift may have; levels magnifications step^k, k = 1 .. levels, each way; floor: what is added
    to NSAD's denominator, in units of the mean column's, so that empty columns don't shout.
    """

    columns: int = 72
    rows: int = 50
    phases: int = 2
    levels: int = 4
    step: float = 1.08
    floor: float = 0.25


WARPING = WarpingSpec()


@dataclass(frozen=True, slots=True, eq=False)
class WarpingView:
    """What min-warping keeps of a panorama: vertical differences of its columns at each magnification about
    the horizon, edges (levels + 1, phases, R, n) float32, their absolute sums (levels + 1, phases, n), and
    the bearing [rad] of column 0.
    """

    edges: Float32Array
    sums: Float32Array
    first_bearing: float
    spec: WarpingSpec


def warping_view(panorama: Panorama, spec: WarpingSpec) -> WarpingView:
    """Return the panorama as min-warping needs it, computed once per panorama and recipe."""
    return panorama.derived(spec, lambda p: _warping_view(p, spec))


def _warping_view(panorama: Panorama, spec: WarpingSpec) -> WarpingView:
    """Lay column 0 ahead: off the nose, a straight drive's direction would fall between columns, always to one side."""
    width = panorama.rig.width
    columns = max(min(spec.columns, width // spec.phases), 1)
    phases = min(spec.phases, width)
    middle = 0.5 * (width / (columns * phases) - 1.0)
    ahead = round(middle)
    fine = normalised(shrunk(panorama.rolled(ahead), columns * phases, spec.rows))
    wide = _smoothed(fine, phases)
    horizon = (panorama.rig.horizon_row + 0.5) * len(wide) / panorama.rig.height - 0.5
    edges = np.diff(_magnified(wide, horizon, spec), axis=1).reshape(spec.levels + 1, len(wide) - 1, columns, phases)
    edges = np.ascontiguousarray(edges.transpose(0, 3, 1, 2), np.float32)
    return WarpingView(edges, np.abs(edges).sum(axis=2), (middle - ahead) * TAU / width, spec)


def _smoothed(fine: Float32Array, phases: int) -> Float32Array:
    """Return columns (R, n) averaged over `phases` of them about itself; of an even number the ends count half."""
    reach = phases // 2
    weights = [1.0 if abs(k) < reach or phases % 2 else 0.5 for k in range(-reach, reach + 1)]
    total = sum(w * np.roll(fine, -k, axis=1) for w, k in zip(weights, range(-reach, reach + 1), strict=True))
    return np.asarray(total / phases, np.float32)


def _magnified(small: Float32Array, horizon: float, spec: WarpingSpec) -> Float32Array:
    """Return columns (R, n) at each magnification about the horizon, (levels + 1, R, n)."""
    maps = _looked_up(small.shape, horizon, spec)
    found = cv2.remap(small, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found, np.float32).reshape(spec.levels + 1, *small.shape)


@lru_cache(maxsize=16)
def _looked_up(shape: tuple[int, int], horizon: float, spec: WarpingSpec) -> tuple[Float32Array, Float32Array]:
    """Return the columns and rows ((levels + 1) R, n) of an image (R, n) that show at each magnification."""
    rows = [
        horizon + (np.arange(shape[0], dtype=np.float32) - np.float32(horizon)) / np.float32(spec.step**k)
        for k in range(spec.levels + 1)
    ]
    maps = np.meshgrid(np.arange(shape[1], dtype=np.float32), np.concatenate(rows).astype(np.float32))
    return maps[0], maps[1]
