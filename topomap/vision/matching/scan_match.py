"""Relative pose of two range scans, by point-to-line alignment (Censi 2008, with a redescending weight)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.vision.matching.scan_kernels import inverted, laid_over, surfaces


@dataclass(frozen=True, slots=True)
class Surfaces:
    """How well a scan's surfaces are known.

    flatness: how much a surface may bend; widest, narrowest: pairs further apart don't count at first and in the end
    [m]; min_share: of all rays that must find a partner; sigma: least error of a pair [m].
    """

    flatness: float
    widest: float
    narrowest: float
    min_share: float
    sigma: float


MEASURED = Surfaces(flatness=0.1, widest=0.3, narrowest=0.05, min_share=0.25, sigma=0.015)
"""By ranges of 1 cm noise: closures are measured from starts 0.25 m apart, and five sigmas are the end."""
SEEN = Surfaces(flatness=0.2, widest=0.4, narrowest=0.15, min_share=0.15, sigma=0.04)
"""By the ground line, which is rougher: a row of the default camera is 3 cm of floor at 1.5 m."""
NEIGHBOURS = 8
"""Rays to either side that make a surface: 8 degrees of 720 rays, 0.2 m of a wall at 1.5 m."""
WINDOW = 10
"""Rays to either side that a point may be paired with: 5 degrees of 720, an odometry or compass error."""
ITERATIONS = 12
"""Steps of the alignment; the last two at the narrowest cutoff."""
TOLD = 0.04
"""A direction that a smaller share of the pairs tells isn't told: along bare corridors noisy normals feign a little."""


@dataclass(frozen=True, slots=True, eq=False)
class ScanMatch:
    """`a_from_b` (3,) of two scans with its covariance (3, 3) and the share of rays that found a partner.

    The covariance is that of independent errors of the pairs: large in
    directions that the surfaces don't constrain, as along a corridor.
    """

    relative: FloatArray
    covariance: FloatArray
    share: float


def match_scans(a: Float32Array, b: Float32Array, guess: FloatArray, surfaced: Surfaces = MEASURED) -> ScanMatch | None:
    """Lay scan b over scan a (both (W,) [m], counter-clockwise from the nose, NaN unmeasured) from a guess (3,) on.

    Returns None where too few rays find a partner.
    """
    s = surfaced
    points, normals = _surfaces(a.astype(float).tobytes(), s.flatness)
    moved, moved_normals = _surfaces(b.astype(float).tobytes(), s.flatness)
    pose, information, error, used = laid_over(
        points, normals, moved, moved_normals, np.array(guess, float), _cutoffs(s.widest, s.narrowest), WINDOW, TOLD,
        s.min_share * len(a),
    )  # fmt: skip
    if used < 0:
        return None
    variance = max(s.sigma**2, error / used)
    return ScanMatch(pose, variance * inverted(information, TOLD, UNMEASURED), used / len(a))


@lru_cache(maxsize=32)
def _surfaces(scan: bytes, flatness: float) -> tuple[FloatArray, FloatArray]:
    """Return the points and normals of a scan (W,) float64: one scan is laid over many, from several guesses each."""
    found: tuple[FloatArray, FloatArray] = surfaces(np.frombuffer(scan).copy(), NEIGHBOURS, flatness)
    return found


UNMEASURED = 1e6  # the variance of a direction that too few pairs constrain, in pair variances


@cache
def _cutoffs(widest: float, narrowest: float) -> FloatArray:
    return np.append(np.geomspace(widest, narrowest, ITERATIONS - 2), [narrowest, narrowest])
