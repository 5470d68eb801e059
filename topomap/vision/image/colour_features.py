"""Colour features of the horizon: what moments, pixel-wise landmarks and convergence points weigh bearings with."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama

Feature = Literal["equal", "red", "green", "blue", "rgb", "grey", "value", "hsv", "hsv-threshold", "bright"]
_CHANNEL = {"red": 0, "green": 1, "blue": 2}
HALF_ROWS = 0.1
"""Half height of the horizon band as a share of the panorama's height."""


def features(panorama: Panorama, feature: Feature) -> FloatArray:
    """Return the feature along the horizon (F, W) in [0, 1]; F independent models vote together (3.17-3.23).

    equal: 1; red, green, blue; rgb: three models; grey: the mean of the three; hsv: three models, hue without
    its wrap; value: the largest of the three; hsv-threshold: 1 where sqrt(H^2 + S^2 + V^2) > 50, else 0 (3.16 d);
    bright: grey above its median, else 0 (the cut-off of 3.1.2).
    """
    return panorama.derived(("features", feature), lambda p: _features(p, feature))


def _features(panorama: Panorama, feature: Feature) -> FloatArray:
    if feature == "equal":
        return np.ones((1, panorama.rig.width))
    colours = horizon(panorama)
    if feature in _CHANNEL:
        return np.asarray(colours[_CHANNEL[feature]][np.newaxis], np.float64)
    if feature == "rgb":
        return colours
    if feature == "value":
        return np.asarray(colours.max(axis=0, keepdims=True), np.float64)
    if feature in ("hsv", "hsv-threshold"):
        pixels = colours.T.astype(np.float32)[np.newaxis]
        hsv = cv2.cvtColor(pixels, cv2.COLOR_RGB2HSV)[0].T.astype(np.float64)
        shares = np.asarray(hsv / np.array([[360.0], [1.0], [1.0]]), np.float64)
        return shares if feature == "hsv" else _over(shares)
    grey = np.asarray(colours.mean(axis=0, keepdims=True), np.float64)
    return grey if feature == "grey" else np.asarray(np.where(grey > np.median(grey), grey, 0.0), np.float64)


HSV_THRESHOLD = 0.5
"""3.16 d prints 50 without a unit: per cent of each of H, S and V, as 50 of 255 would leave nothing out."""


def _over(shares: FloatArray) -> FloatArray:
    """Return 1 where the length of (H, S, V) (3, W) in [0, 1] exceeds the threshold, else 0: (1, W)."""
    return np.asarray(np.sqrt(np.square(shares).sum(axis=0, keepdims=True)) > HSV_THRESHOLD, np.float64)


def horizon(panorama: Panorama) -> FloatArray:
    """Return the mean colour of the horizon band, (3, W) in [0, 1]."""
    middle, half = panorama.rig.horizon_row, HALF_ROWS * panorama.rig.height
    first = min(max(round(middle - half), 0), panorama.rig.height - 1)
    band = panorama.image[first : max(round(middle + half) + 1, first + 1)]
    return np.ascontiguousarray(band.mean(axis=0, dtype=np.float64).T / 255.0)
