"""H8, matched-filter descent in image distance (Möller, Vardy 2006; 2.5.3.3, 2.5.3.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_camera, vector_home
from topomap.vision.image.compare import normalised, shrunk


@dataclass(frozen=True, slots=True, eq=False)
class Filtered:
    """A low-passed view (R, C) with its change per unit step along x and y, each (R, C), at equal distances."""

    pixels: Float32Array
    along_x: Float32Array
    along_y: Float32Array
    rig: Rig


@dataclass(frozen=True, slots=True)
class MatchedFilterDescent:
    """-sum (C - H) dC with the flow of a step along x and y at equal distances; bearing only.

    dC/dx = -I_t sin t - I_v v cos t, dC/dy = I_t cos t - I_v v sin t, v = f tan e. form "newton" divides by the
    2 x 2 normal matrix. columns, rows, blur [pixels]: the low-pass.
    """

    origin: ClassVar[Origin] = Origin("H8", "2.5.3.4; Möller, Vardy 2006")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    form: Literal["gradient", "newton"] = "newton"
    columns: int = 90
    rows: int = 25
    blur: float = 2.0

    def describe(self, panorama: Panorama) -> Filtered:
        """Return the low-passed view and its flow templates."""
        pixels = normalised(shrunk(panorama, self.columns, self.rows, self.blur))
        rows, columns = pixels.shape
        angles = np.arange(columns) * (TAU / columns) + 0.5 * (TAU / columns - TAU / panorama.rig.width)
        turned = (np.roll(pixels, -1, axis=1) - np.roll(pixels, 1, axis=1)) / (2 * TAU / columns)
        row = (np.arange(rows) + 0.5) * panorama.rig.height / rows - 0.5
        up = (panorama.rig.horizon_row - row)[:, np.newaxis]
        risen = _upward(pixels, panorama.rig.height / rows) * up
        cos, sin = np.cos(angles), np.sin(angles)
        x = (-turned * sin - risen * cos).astype(np.float32)
        return Filtered(pixels, x, (turned * cos - risen * sin).astype(np.float32), panorama.rig)

    def home(self, current: Filtered, goal: Filtered) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        left = (current.pixels - goal.pixels).astype(np.float64)
        templates = np.stack([current.along_x, current.along_y]).reshape(2, -1).astype(np.float64)
        step = np.asarray(-(templates @ left.ravel()), np.float64)
        normal = templates @ templates.T
        power = float(np.trace(normal))
        if power < 1e-9 or not goal.pixels.any():
            return HomeVector(0.0, None, 0.0)
        size = float(np.sqrt(np.square(left).sum() * power)) + 1e-9
        share = min(float(np.hypot(*step)) / size * 4.0, 1.0)
        if self.form == "newton":
            step = np.asarray(np.linalg.solve(normal + 1e-6 * power * np.eye(2), step), np.float64)
        length = float(np.hypot(*step))
        return vector_home(float(step[0]), float(step[1]), length if share > 1e-9 else 1e12, share)


def _upward(pixels: Float32Array, rows_per_pixel: float) -> Float32Array:
    """Return the derivative per row towards the top."""
    if len(pixels) < 2:
        return np.zeros_like(pixels)
    return np.asarray(-np.gradient(pixels, axis=0) / rows_per_pixel, np.float32)
