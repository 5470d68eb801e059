"""A way round what stands ahead: the shortest one of two straight pieces that the ranges leave free."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from topomap.core.arrays import BoolArray, Float32Array, FloatArray
from topomap.core.geometry import TAU

FAR = 2.5
"""[m] What stands farther off is not in the way."""
DIRECTIONS = 48
STEPS = (0.25, 0.45, 0.7)
"""[m] Lengths of the first piece that are tried in each direction."""
EVERY = 2
"""Of the ranges every so-manieth is looked at: at 720 rays 2.5 m off they lie 4 cm apart."""
TOUCHING = 0.02
"""[m] What is nearer than the body wants must not come nearer than by this."""

_ANGLES = np.arange(DIRECTIONS) * TAU / DIRECTIONS
_TURNS: FloatArray = np.concatenate(
    [step * np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)]) for step in STEPS], axis=0
)


def way_round(aims: Sequence[tuple[float, float]], ranges: Float32Array, clear: float) -> float | None:
    """Return the bearing [rad] of the first piece of the shortest free way to the first of `aims` that has one.

    aims: points (x ahead, y left) [m]; ranges (W,) [m], NaN where nothing was measured; clear: room that the robot's
    middle needs [m]. None where there is no such way.
    """
    points = _points(ranges)
    nearest = float(np.hypot(points[:, 0], points[:, 1]).min(initial=np.inf))
    begin = _TURNS[_free(np.zeros(2), _TURNS, points, min(clear, nearest - TOUCHING))]
    for aim in aims:
        goal = np.array(aim)
        if not len(begin) or float(np.hypot(*(points - goal).T).min(initial=np.inf)) < clear:
            continue
        onward = _free(goal, begin, points, min(clear, nearest - TOUCHING) if nearest < clear else clear)
        if onward.any():
            fit = begin[onward]
            x, y = fit[int(np.argmin(np.hypot(*fit.T) + np.hypot(*(fit - goal).T)))]
            return float(np.arctan2(y, x))
    return None


def _points(ranges: Float32Array) -> FloatArray:
    """Return what stands near (N, 2) [m] in the robot's frame."""
    angles = np.arange(len(ranges)) * TAU / len(ranges)
    near = np.flatnonzero(ranges < FAR)[::EVERY]
    away = ranges[near].astype(np.float64)
    return np.column_stack([away * np.cos(angles[near]), away * np.sin(angles[near])])


def _free(origin: FloatArray, ends: FloatArray, points: FloatArray, clear: float) -> BoolArray:
    """Return for which of the segments origin-ends (M, 2) no point (N, 2) lies nearer than `clear` [m]."""
    along = ends - origin
    square = np.maximum((along**2).sum(axis=1), 1e-12)
    rest = points - origin
    share = np.clip((rest @ along.T) / square, 0.0, 1.0)
    away = np.hypot(
        rest[:, 0, None] - share * along[None, :, 0], rest[:, 1, None] - share * along[None, :, 1]
    )  # (N, M)
    free: BoolArray = away.min(axis=0, initial=np.inf) >= clear
    return free
