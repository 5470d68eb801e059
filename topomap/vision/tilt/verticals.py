"""A camera's lean by one view: what stands upright in the world leans the other way in the picture.

An edge that stands upright at bearing phi runs from row to row sideways by roll cos phi + pitch sin phi (in angles), to
first order at any elevation. The edges that run nearly upright vote for both, robustly; how much sectors of the view
disagree says how sure that is. It holds where walls, doors, furniture, trunks or people stand, and no motion, ranges or
second view are needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.tilt.lean import Lean

COLUMNS = 720
"""Of the view that is looked at: a larger one tells no more for its time."""
EDGE = 8.0
"""[grey levels a pixel] Least gradient of an edge, after a slight blur: ten times the noise of a usual camera."""
STEEPEST = 0.2
"""An edge that runs sideways by more a row isn't upright, even for a camera that leans by ten degrees."""
WIDTHS = (0.2, 0.1, 0.1, 0.1)
"""Sideways run a row off the fit that quarters an edge's vote, from round to round."""
SECTORS = 36
"""Of the view, taken to err independently of one another: an upright edge is longer than wide."""
ASKEW = math.radians(0.5)
"""[rad] By how much the upright things of one sector lean together, at least."""
WORST = 100.0  # how much better one direction of lean is seen than the other, at most
FEWEST = 60  # edge pixels, as two edges of 30 rows have


@dataclass(frozen=True, slots=True, eq=False)
class LeanReading:
    """What one view says: the lean, and the covariance (2, 2) of roll and pitch [rad^2]."""

    lean: Lean
    covariance: FloatArray

    @property
    def sigma(self) -> float:
        """The larger axis of the error [rad]."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance)[-1]))


def lean_of(panorama: Panorama) -> LeanReading | None:
    """Return how the camera leans by the upright edges of its view (H, W, 3), None where it shows too few."""
    grey = _grey(panorama)
    stretch = panorama.rig.width / (TAU * panorama.rig.focal)
    return _fitted(_edges(grey, EDGE, STEEPEST), grey.shape[1] - 2, stretch)


def _grey(panorama: Panorama) -> Float32Array:
    """Return the view (H, W + 2) in grey, blurred, with a column on either side from beyond the seam."""
    grey = cv2.cvtColor(panorama.image, cv2.COLOR_RGB2GRAY)
    if panorama.rig.width > COLUMNS:
        shrink = COLUMNS / panorama.rig.width
        grey = cv2.resize(grey, (COLUMNS, max(round(len(grey) * shrink), 1)), interpolation=cv2.INTER_AREA)
    ring = cv2.copyMakeBorder(grey, 0, 0, min(4, grey.shape[1]), min(4, grey.shape[1]), cv2.BORDER_WRAP)
    soft = cv2.GaussianBlur(ring.astype(np.float32), (3, 3), 0.7, borderType=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(soft[:, 3:-3], np.float32)


@njit(cache=True)
def _edges(grey: Float32Array, least: float, steepest: float) -> FloatArray:
    """Return (n, 3) column, sideways run a row, and squared gradient of the pixels on nearly upright edges."""
    rows, columns = grey.shape
    found = np.empty((rows * columns, 3))
    n = 0
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            x = 10.0 * (grey[i, j + 1] - grey[i, j - 1])
            x += 3.0 * (grey[i - 1, j + 1] - grey[i - 1, j - 1] + grey[i + 1, j + 1] - grey[i + 1, j - 1])
            if abs(x) < 32.0 * least:
                continue
            y = 10.0 * (grey[i + 1, j] - grey[i - 1, j])
            y += 3.0 * (grey[i + 1, j - 1] - grey[i - 1, j - 1] + grey[i + 1, j + 1] - grey[i - 1, j + 1])
            if abs(y) < steepest * abs(x):
                found[n, 0], found[n, 1], found[n, 2] = j - 1, y / x, (x / 32.0) ** 2
                n += 1
    return found[:n]


@njit(cache=True)
def _sums(edges: FloatArray, cosines: FloatArray, sines: FloatArray, roll: float, pitch: float, width: float,
          sectors: int) -> FloatArray:  # fmt: skip
    """Return (sectors, 5) the weighted normal equations of each sector about a lean."""
    sums = np.zeros((sectors, 5))
    columns = len(cosines)
    for k in range(len(edges)):
        j = int(edges[k, 0])
        c, s = cosines[j], sines[j]
        miss = edges[k, 1] - roll * c - pitch * s
        # a strong edge is no more upright than a middling one
        square = edges[k, 2]
        weight = square * square / (square + 900.0) / (1.0 + (miss / width) ** 2) ** 2
        row = sums[j * sectors // columns]
        row[0] += weight * c * c
        row[1] += weight * c * s
        row[2] += weight * s * s
        row[3] += weight * c * miss
        row[4] += weight * s * miss
    return sums


def _fitted(edges: FloatArray, columns: int, stretch: float) -> LeanReading | None:
    """Return the lean by edges (n, 3); stretch: columns a radian over rows a radian."""
    if len(edges) < FEWEST:
        return None
    bearings = np.arange(columns) * (TAU / columns)
    cosines, sines = stretch * np.cos(bearings), stretch * np.sin(bearings)
    lean = np.zeros(2)
    for width in WIDTHS:
        sums = _sums(edges, cosines, sines, float(lean[0]), float(lean[1]), width, SECTORS)
        normal, right = _normal(sums.sum(axis=0)), sums[:, 3:].sum(axis=0)
        if np.linalg.cond(normal) > WORST:
            return None
        lean = lean + np.linalg.solve(normal, right)
    inverse = np.linalg.inv(normal)
    own = sums[:, [[0, 1], [1, 2]]]
    spread = sums[:, 3:].T @ sums[:, 3:] + ASKEW**2 * np.einsum("kij,kjl->il", own, own)
    covariance = inverse @ spread @ inverse
    return LeanReading(Lean(float(lean[0]), float(lean[1])), np.asarray(covariance + covariance.T) / 2.0)


def _normal(sums: FloatArray) -> FloatArray:
    return np.array([[sums[0], sums[1]], [sums[1], sums[2]]])
