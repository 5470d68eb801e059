"""Feature points of a panorama as directions in space, and those of two views that belong together."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig


@dataclass(frozen=True, slots=True)
class KeypointSpec:
    """The recipe: most, how many SIFT points (Lowe 2004); columns, of the view they are sought in; contrast, the
    least of a point; margin [pixels] at the seam.
    """

    most: int = 400
    columns: int = 720
    contrast: float = 0.015
    margin: int = 32


@dataclass(frozen=True, slots=True, eq=False)
class Keypoints:
    """bearings (N,) [rad]; slopes (N,), tan of the elevation; looks (N, 128) unit vectors; rig."""

    bearings: FloatArray
    slopes: FloatArray
    looks: Float32Array
    rig: Rig

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.bearings)


def keypoints(panorama: Panorama, spec: KeypointSpec) -> Keypoints:
    """Return the panorama's feature points, found across the seam, computed once per panorama and recipe."""
    return panorama.derived(spec, lambda p: _keypoints(p, spec))


def _keypoints(panorama: Panorama, spec: KeypointSpec) -> Keypoints:
    rig = panorama.rig
    grey = cv2.cvtColor(panorama.image, cv2.COLOR_RGB2GRAY)
    shrink = max(rig.width / spec.columns, 1.0)
    if shrink > 1.0:
        size = (spec.columns, max(round(rig.height / shrink), 1))
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    columns = grey.shape[1]
    margin = min(spec.margin, columns)
    wide = np.concatenate([grey[:, -margin:], grey, grey[:, :margin]], axis=1)
    found, looks = _detected(wide, spec)
    places = np.array([point.pt for point in found], np.float64).reshape(-1, 2) - (margin, 0)
    own = (places[:, 0] >= 0) & (places[:, 0] < columns)
    places = (places + 0.5) * (rig.width / columns, rig.height / len(grey)) - 0.5
    order = np.lexsort((places[own, 1], places[own, 0]))  # OpenCV's threads find them in any order
    places, looks = places[own][order], looks[own][order]
    root = np.sqrt(looks / np.maximum(looks.sum(axis=1, keepdims=True), 1e-9))
    slopes = (rig.horizon_row - places[:, 1]) / rig.focal
    return Keypoints(places[:, 0] * (TAU / rig.width), slopes, root.astype(np.float32), rig)


def _detected(wide: Image, spec: KeypointSpec) -> tuple[list[cv2.KeyPoint], Float32Array]:
    if min(wide.shape) < 16:
        return [], np.empty((0, 128), np.float32)
    found, looks = cv2.SIFT.create(spec.most, contrastThreshold=spec.contrast).detectAndCompute(wide, None)
    return list(found), np.asarray(looks if looks is not None else np.empty((0, 128)), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """Matched points (M, 4): goal bearing and slope, current bearing and slope; weight (M,) in [0, 0.5]."""

    rays: FloatArray
    weight: FloatArray


def matched_keypoints(current: Keypoints, goal: Keypoints) -> Matches:
    """Return the points that are each other's most alike (Arandjelović, Zisserman 2012: Hellinger distance).

    The weight is how much better the best partner is than the second best, up to 0.5.
    """
    if len(current) < 2 or len(goal) < 2:
        return Matches(np.empty((0, 4)), np.empty(0))
    unlike = 2.0 - 2.0 * (goal.looks @ current.looks.T)
    partner, back = unlike.argmin(axis=1), unlike.argmin(axis=0)
    g = np.flatnonzero(back[partner] == np.arange(len(goal)))
    c = partner[g]
    two = np.partition(unlike[g], 1, axis=1)
    weight = np.clip(1.0 - two[:, 0] / np.maximum(two[:, 1], 1e-9), 0.0, 0.5).astype(np.float64)
    rays = np.stack([goal.bearings[g], goal.slopes[g], current.bearings[c], current.slopes[c]], axis=1)
    return Matches(rays, weight)
