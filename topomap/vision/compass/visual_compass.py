"""A1, the visual compass: the rotation at which two pictures differ least (2.6)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.compare import Signature, SignatureSpec, parabola, signature, squared_differences
from topomap.vision.matching.difference_kernels import absolute_differences

_SHARP = SignatureSpec(columns=180, rows=25, blur=0.0)


@dataclass(frozen=True, slots=True)
class VisualCompass:
    """argmin over shifts k of the difference of goal and roll(current, k), to a fraction of a column (2.6).

    spec: the pictures compared; form: squared differences, by Fourier transform, or absolute ones, as
    printed; window [rad]: how far from a prior to search. The residual is the rms (ssd) or mean absolute
    (sad) difference.
    """

    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = False
    spec: SignatureSpec = _SHARP
    form: Literal["ssd", "sad"] = "ssd"
    window: float = math.radians(45.0)

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        return Origin("A1", "2.6; Zeil et al. 2003" if self.form == "ssd" else "2.6, as printed")

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the rotation [rad] of least difference, within prior +- window where there is a prior.

        Raises ShapeError.
        """
        same_views(current, goal)
        curve = self.curve(signature(current, self.spec), signature(goal, self.spec))
        columns = len(curve)
        allowed = curve if prior is None else np.where(self._near(columns, prior), curve, np.inf)
        k = int(allowed.argmin())
        around = curve[[(k - 1) % columns, k, (k + 1) % columns]]
        offset, low = parabola(*around[:, np.newaxis])
        residual = max(float(low[0]), 0.0)
        return Alignment(
            wrap((k + float(offset[0])) * TAU / columns),
            math.sqrt(residual) if self.form == "ssd" else residual,
        )

    def curve(self, current: Signature, goal: Signature) -> FloatArray:
        """Return the mean squared or absolute difference (C,) at every shift of the current picture."""
        if self.form == "ssd":
            squares: FloatArray = squared_differences(current, goal.spectrum[np.newaxis])[0]
            return squares
        return np.asarray(absolute_differences(current.pixels, goal.pixels), np.float64)

    def _near(self, columns: int, prior: float) -> BoolArray:
        angles = np.arange(columns, dtype=np.float64) * (TAU / columns) - prior
        near: BoolArray = np.abs(wrap_all(angles)) <= max(self.window, TAU / columns)
        return near


VISUAL_COMPASS = VisualCompass()
