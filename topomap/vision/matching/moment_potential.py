"""Convergence points: where a moment's potential is least (3.29-3.31), and the rigid fit of several (fig. 3.2)."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU

FLOOR = 1e-3
"""No landmark is nearer than this [m]: the potential's gradient stays finite for orders below 2."""


def points(metres: FloatArray) -> FloatArray:
    """Return the landmarks (W, 2) [m] of distances (W,) along the columns."""
    angles = np.arange(len(metres)) * (TAU / len(metres))
    return np.asarray(metres[:, np.newaxis] * np.column_stack([np.cos(angles), np.sin(angles)]), np.float64)


def centroid(landmarks: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted mean (2,) of landmarks (N, 2): the convergence point of order 2 (3.9)."""
    return np.asarray(weights @ landmarks / max(float(weights.sum()), 1e-12), np.float64)


def convergence_point(
    landmarks: FloatArray, weights: FloatArray, exponent: float, precision: float = 1e-3, rounds: int = 500
) -> FloatArray:
    """Return the point (2,) where sum C |p - a|^n is least, by Barzilai-Borwein descent (3.30, 3.31).

    landmarks (N, 2) [m], weights (N,) >= 0, exponent n >= 1; it stops at steps below `precision` [m].
    """
    here = centroid(landmarks, weights)
    if exponent == 2.0 or not weights.any():
        return here
    slope = _gradient(here, landmarks, weights, exponent)
    rate = precision / max(float(np.hypot(*slope)), 1e-300)
    for _ in range(rounds):
        step = -rate * slope
        reach = float(np.hypot(*step))
        if reach > 1.0:
            step /= reach
        there = here + step
        next_slope = _gradient(there, landmarks, weights, exponent)
        turn = next_slope - slope
        bend = float(turn @ turn)
        here, slope = there, next_slope
        if bend <= 0.0 or (reach < precision and float(abs(step @ turn)) / bend * float(np.hypot(*slope)) < precision):
            break
        rate = abs(float(step @ turn)) / bend
    return here


def _gradient(at: FloatArray, landmarks: FloatArray, weights: FloatArray, exponent: float) -> FloatArray:
    towards = at - landmarks
    length = np.maximum(np.hypot(towards[:, 0], towards[:, 1]), FLOOR)
    return np.asarray((weights * exponent * length ** (exponent - 2.0)) @ towards, np.float64)


def rigid_fit(current: FloatArray, goal: FloatArray) -> tuple[float, FloatArray, float]:
    """Fit goal (N, 2) = R(psi) current (N, 2) + t: return psi [rad], t (2,), rms residual [m] (fig. 3.2).

    psi is the heading of the current frame in the goal's, t its origin there.
    """
    a, b = current - current.mean(axis=0), goal - goal.mean(axis=0)
    psi = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    turn = np.array([[math.cos(psi), -math.sin(psi)], [math.sin(psi), math.cos(psi)]])
    shift = goal.mean(axis=0) - turn @ current.mean(axis=0)
    residual = goal - current @ turn.T - shift
    return psi, np.asarray(shift, np.float64), float(np.sqrt(np.square(residual).sum(axis=1).mean()))
