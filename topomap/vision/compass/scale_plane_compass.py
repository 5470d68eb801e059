"""A2, the visual compass on the scale-plane stack (Horst, Möller 2017; 2.6.4.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.errors import ShapeError
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.vision.compass.curve import least
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, WarpingView, warping_view
from topomap.vision.matching.warping_kernels import scale_planes


@dataclass(frozen=True, slots=True)
class ScalePlaneCompass:
    """argmin over rotations of the summed NSAD, each column at its best vertical magnification (2.6.4.4).

    spec: the small views; window [rad]: how far from a prior to search. The residual is the mean NSAD.
    """

    origin: ClassVar[Origin] = Origin("A2", "2.6.4.4; Horst, Möller 2017")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = False
    spec: WarpingSpec = WARPING
    window: float = math.radians(45.0)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the rotation [rad] of least difference. Raises ShapeError."""
        return least(self.curve(warping_view(current, self.spec), warping_view(goal, self.spec)), prior, self.window)

    def curve(self, current: WarpingView, goal: WarpingView) -> FloatArray:
        """Return the mean NSAD (n P,) at rotations of 0, 1/P, .. columns."""
        if current.edges.shape != goal.edges.shape:
            raise ShapeError(f"views differ in shape: {current.edges.shape} and {goal.edges.shape}")
        levels, phases, _, n = goal.edges.shape
        floor = self.spec.floor * float(goal.sums[0, 0].mean() + current.sums[0, 0].mean())
        planes = scale_planes(goal.edges, current.edges, goal.sums, current.sums, floor)
        best: Float32Array = planes.reshape(2 * levels - 1, phases, n, 2 * n).min(axis=0)
        rows = np.arange(n)
        curve = np.empty((n, phases))
        for turn in range(n):
            # the last axis runs over minus the current column: goal column i meets current column i - turn - p/P
            for phase in range(phases):
                whole = turn + (1 if phase else 0)
                curve[turn, phase] = best[(phases - phase) % phases, rows, (whole - rows) % n].mean(dtype=np.float64)
        return np.asarray(curve.ravel(), np.float64)
