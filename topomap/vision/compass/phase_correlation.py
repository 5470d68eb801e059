"""A3, A4: phase correlation of row sums or rows, also on the scale-plane stack (Kuglin, Hines 1975; 2.6.4.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.vision.compass.curve import least
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.compare import normalised, shrunk


@dataclass(frozen=True, slots=True)
class PhaseCorrelation:
    """The rotation at which the whitened cross spectrum of two views peaks (2.6.4.4).

    form: of the "sum" over the rows, or of the single "rows", added up; levels: magnifications step^k either way
    that are tried (0: A3, else A4); floor: what share of the mean power a frequency needs to count. The residual
    is 1 minus the peak, 0 for the same view.
    """

    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = False
    form: Literal["sum", "rows"] = "rows"
    levels: int = 0
    step: float = 1.08
    columns: int = 180
    rows: int = 25
    floor: float = 0.1
    window: float = math.radians(45.0)

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        return Origin("A4" if self.levels else "A3", "2.6.4.4; Kuglin, Hines 1975")

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the rotation [rad] of the highest peak. Raises ShapeError."""
        same_views(current, goal)
        curves = [
            1.0 - self._correlation(self._view(current, max(-k, 0)), self._view(goal, max(k, 0)))
            for k in range(-self.levels, self.levels + 1)
        ]
        found = [least(curve, prior, self.window) for curve in curves]
        return min(found, key=lambda alignment: alignment.residual)

    def _view(self, panorama: Panorama, level: int) -> Float32Array:
        """Return the small view magnified by step^level about the horizon, (R, C); row sums: (1, C)."""
        key = ("phase", self, level)
        return panorama.derived(key, lambda p: self._made(p, level))

    def _made(self, panorama: Panorama, level: int) -> Float32Array:
        small = normalised(shrunk(panorama, self.columns, self.rows, 0.5))
        if level:
            small = magnified(small, self.step**level, panorama)
        return small if self.form == "rows" else np.asarray(small.mean(axis=0, keepdims=True), np.float32)

    def _correlation(self, current: Float32Array, goal: Float32Array) -> FloatArray:
        product = np.fft.rfft(goal, axis=1) * np.conj(np.fft.rfft(current, axis=1))
        product[:, 0] = 0.0
        size = np.abs(product)
        whitened = product / (size + self.floor * float(size.mean()) + 1e-9)
        columns = goal.shape[1]
        curve = np.fft.irfft(whitened, n=columns, axis=1).sum(axis=0)
        top = float(np.sum(np.abs(whitened) * np.where(np.arange(whitened.shape[1]) * 2 == columns, 1, 2))) / columns
        return np.asarray(curve / max(top, 1e-9), np.float64)


def magnified(small: Float32Array, factor: float, panorama: Panorama) -> Float32Array:
    """Return a small view (R, C) with its rows magnified about the horizon."""
    horizon = (panorama.rig.horizon_row + 0.5) * len(small) / panorama.rig.height - 0.5
    rows = horizon + (np.arange(len(small)) - horizon) / factor
    maps = np.meshgrid(np.arange(small.shape[1], dtype=np.float32), rows.astype(np.float32))
    wide = cv2.remap(small, maps[0], maps[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(wide, np.float32)
