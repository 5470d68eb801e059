"""Planar epipolar geometry: the direction and rotation of a level movement from matched points.

A point seen x_H from the direction alpha of the movement goal -> current at slope v_H, and x_C = x_H + y at slope v_C
after it, keeps its height and its distance from the line of movement: v_H sin x_C = v_C sin x_H; and it moves away
from the direction of movement (y has the sign of sin x_H). Robust votes over both; no point's distance assumed.
The essential matrix of planar motion (Ortín, Montiel 2001) on a cylinder.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap
from topomap.vision.image.keypoints import Matches

SLACK = 0.03
"""How far [rad] a point may move the wrong way before it hardly counts."""


@njit(cache=True)
def votes(
    rays: FloatArray, weight: FloatArray, alphas: FloatArray, turns: FloatArray, sigma: float, slack: float
) -> FloatArray:
    """Return the summed robust votes (A, T) of matches (M, 4), (M,) for directions and rotations [rad].

    sigma: a residual [rad] that halves a vote.
    """
    result = np.zeros((len(alphas), len(turns)))
    sin_t, cos_t = np.sin(turns), np.cos(turns)
    sin_g, cos_g, sin_p, cos_p = np.sin(rays[:, 0]), np.cos(rays[:, 0]), np.sin(rays[:, 2]), np.cos(rays[:, 2])
    narrow, strict = 1.0 / (sigma * sigma), 1.0 / (slack * slack)
    for a in range(len(alphas)):
        sin_a, cos_a = math.sin(alphas[a]), math.cos(alphas[a])
        row = result[a]
        for m in range(len(weight)):
            sin_h, cos_h = sin_g[m] * cos_a - cos_g[m] * sin_a, cos_g[m] * cos_a + sin_g[m] * sin_a
            sin_0, cos_0 = sin_p[m] * cos_a - cos_p[m] * sin_a, cos_p[m] * cos_a + sin_p[m] * sin_a
            v_h, v_c, share = rays[m, 1], rays[m, 3], weight[m]
            own = sin_h * sin_h + v_c * v_c * cos_h * cos_h + 1e-9
            side = 1.0 if sin_h > 0.0 else -1.0
            for t in range(len(turns)):
                sin_c, cos_c = sin_0 * cos_t[t] + cos_0 * sin_t[t], cos_0 * cos_t[t] - sin_0 * sin_t[t]
                miss = v_h * sin_c - v_c * sin_h
                size = own + sin_c * sin_c + v_h * v_h * cos_c * cos_c
                back = max((cos_c * sin_h - sin_c * cos_h) * side, 0.0)
                across = max(min(-sin_c * side, sin_h * side), 0.0)
                wrong = max(back, across)
                row[t] += share / (1.0 + miss * miss * narrow / size + wrong * wrong * strict)
    return result


@dataclass(frozen=True, slots=True)
class EpipolarSpec:
    """The search: directions, rotations over the full circle; sigmas [rad], from coarse to fine; peaks followed."""

    directions: int = 48
    rotations: int = 72
    sigmas: tuple[float, ...] = (0.03, 0.015, 0.008, 0.005)
    peaks: int = 3


@dataclass(frozen=True, slots=True)
class Movement:
    """What the matches say: direction of goal -> current in the goal's frame [rad], rotation [rad], support, the
    votes as a share of the weights; contrast, how much of it other directions don't have; points, the votes.
    """

    direction: float
    rotation: float
    support: float
    contrast: float
    points: float


def movement(matches: Matches, prior: float | None, window: float, spec: EpipolarSpec) -> Movement:
    """Return the movement with most votes, rotation within prior +- window [rad] where there is a prior."""
    total = float(matches.weight.sum())
    if len(matches.weight) < 3 or total <= 0.0:
        return Movement(0.0, prior or 0.0, 0.0, 0.0, 0.0)
    alphas, turns = _grid(prior, window, spec)
    coarse = votes(matches.rays, matches.weight, alphas, turns, spec.sigmas[0], SLACK)
    found = [_refined(matches, alphas[a], turns[t], spec) for a, t in _peaks(coarse, spec.peaks)]
    score, direction, rotation = max(found)
    others = votes(matches.rays, matches.weight, alphas, np.array([rotation]), spec.sigmas[-1], SLACK)
    contrast = 1.0 - float(others.mean()) / max(score, 1e-12)
    return Movement(wrap(direction), wrap(rotation), score / total, max(contrast, 0.0), 2.0 * score)


def _grid(prior: float | None, window: float, spec: EpipolarSpec) -> tuple[FloatArray, FloatArray]:
    alphas = np.arange(spec.directions, dtype=np.float64) * (TAU / spec.directions)
    step = TAU / spec.rotations
    if prior is None or window >= math.pi:
        return alphas, np.arange(spec.rotations, dtype=np.float64) * step
    half = max(math.ceil(window / step), 1)
    return alphas, prior + np.arange(-half, half + 1, dtype=np.float64) * (window / half)


def _peaks(score: FloatArray, count: int) -> list[tuple[int, int]]:
    left, peaks = score.copy(), []
    for _ in range(count):
        a, t = divmod(int(left.argmax()), score.shape[1])
        peaks.append((a, t))
        rows = np.arange(a - 2, a + 3) % score.shape[0]
        left[np.ix_(rows, np.arange(max(t - 2, 0), min(t + 3, score.shape[1])))] = -1.0
    return peaks


def _refined(matches: Matches, direction: float, rotation: float, spec: EpipolarSpec) -> tuple[float, float, float]:
    """Climb from a coarse peak; return votes, direction, rotation."""
    score, reach, swing = 0.0, TAU / spec.directions, TAU / spec.rotations
    offsets = np.linspace(-1.0, 1.0, 9)
    for sigma in (*spec.sigmas, spec.sigmas[-1]):
        around = votes(
            matches.rays, matches.weight, direction + reach * offsets, rotation + swing * offsets, sigma, SLACK
        )
        a, t = divmod(int(around.argmax()), 9)
        score = float(around[a, t])
        direction, rotation = direction + reach * float(offsets[a]), rotation + swing * float(offsets[t])
        reach, swing = 0.4 * reach, 0.4 * swing
    return score, direction, rotation
