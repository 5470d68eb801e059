"""H23, automatic landmark selection: which columns of the horizon count as landmarks (5.1.2.1), and by colour."""

from __future__ import annotations

import cv2
import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IndexArray
from topomap.core.geometry import TAU, wrap_all
from topomap.core.panorama import Panorama
from topomap.vision.image.colour_features import horizon

_COUNTS = 24


def equalised(values: FloatArray) -> FloatArray:
    """Return values (N,) after histogram equalisation: ranks in [0, 1], equal values sharing one."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(counts) - 0.5 * counts)[inverse] / len(values), np.float64)


def landmark_count(current: FloatArray, goal: FloatArray, least: int = 50) -> int:
    """Return how many of the brightest columns (W,) to keep in both views: the count of the highest score.

    For each of the current view's k brightest columns, its three nearest in equalised colour among the goal's k
    brightest count where they lie less than 180 degrees off, the nearer the more; the score is divided by k^2.
    """
    width = len(goal)
    here, there = np.argsort(-current, kind="stable"), np.argsort(-goal, kind="stable")
    counts = np.unique(np.linspace(min(least, width), width, _COUNTS).astype(np.int64))
    scores = [_score(current[here[:k]], here[:k], goal[there[:k]], there[:k], width) / k**2 for k in counts]
    return int(counts[int(np.argmax(scores))])


def _score(current: FloatArray, here: IndexArray, goal: FloatArray, there: IndexArray, width: int) -> float:
    order = np.argsort(goal, kind="stable")
    sorted_goal = goal[order]
    at = np.clip(np.searchsorted(sorted_goal, current), 1, max(len(goal) - 2, 1))
    nearest = np.clip(at[:, np.newaxis] + np.array([-1, 0, 1]), 0, len(goal) - 1)
    apart = np.abs(wrap_all((there[order][nearest] - here[:, np.newaxis]) * (TAU / width)))
    return float(np.sum(1.0 - apart / np.pi))


def selected(panorama: Panorama, count: int) -> BoolArray:
    """Return which columns (W,) are the `count` brightest of the equalised horizon."""
    order = np.argsort(-equalised(horizon(panorama).mean(axis=0)), kind="stable")
    chosen: BoolArray = np.zeros(panorama.rig.width, np.bool_)
    chosen[order[:count]] = True
    return chosen


def coloured(panorama: Panorama, saturation: float, value: float, rows: float) -> FloatArray:
    """Return the share (W,) of each column's pixels within +-rows/2 of the height about the horizon that are
    saturated and bright enough to be a landmark's (HSV; 5.1.1.1).
    """
    height = panorama.rig.height
    cut = min(round(0.5 * (1.0 - rows) * height), (height - 1) // 2)
    hsv = cv2.cvtColor(np.ascontiguousarray(panorama.image[cut : height - cut]), cv2.COLOR_RGB2HSV)
    chosen = (hsv[:, :, 1] >= 255.0 * saturation) & (hsv[:, :, 2] >= 255.0 * value)
    return np.asarray(chosen.mean(axis=0), np.float64)
