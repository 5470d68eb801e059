"""Relative pose of two range scans, by point-to-line alignment (Censi 2008, with a redescending weight)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import wrap
from topomap.mapping.odometry.scan_kernels import normal_equations, surfaces


class ScanMatchSettings(BaseModel, frozen=True, extra="forbid"):
    """How two scans are laid over one another."""

    sequential: int = Field(8, ge=1, description="rays to either side that make a surface")
    flatness: float = Field(0.1, gt=0, lt=1, description="how much a surface may bend")
    widest: float = Field(0.3, gt=0, description="pairs further apart don't count at first [m]")
    narrowest: float = Field(0.05, gt=0, description="... and in the end [m]")
    iterations: int = Field(12, ge=2, description="steps of the alignment")
    window: int = Field(10, ge=1, description="rays to either side that a point may be paired with")
    min_share: float = Field(0.25, gt=0, le=1, description="share of all rays that must find a partner")
    told: float = Field(0.04, gt=0, lt=1, description="share of the pairs below which a direction is unmeasured")
    sigma: float = Field(0.015, gt=0, description="least error of a pair [m]")


def seen_scans() -> ScanMatchSettings:
    """Return the settings for distances seen by the ground line, which are rougher than measured ones."""
    return ScanMatchSettings(flatness=0.2, widest=0.4, narrowest=0.15, min_share=0.15, sigma=0.04)


@dataclass(frozen=True, slots=True, eq=False)
class ScanMatch:
    """`a_from_b` (3,) of two scans with its covariance (3, 3) and the share of rays that found a partner.

    The covariance is that of independent errors of the pairs: large in
    directions that the surfaces don't constrain, as along a corridor.
    """

    relative: FloatArray
    covariance: FloatArray
    share: float


def match_scans(
    a: Float32Array, b: Float32Array, guess: FloatArray, settings: ScanMatchSettings | None = None
) -> ScanMatch | None:
    """Lay scan b over scan a (both (W,) [m], counter-clockwise from the nose, NaN unmeasured) from a guess (3,) on.

    Returns None where too few rays find a partner.
    """
    s = settings or ScanMatchSettings()
    points, normals = surfaces(a.astype(float), s.sequential, s.flatness)
    moved, moved_normals = surfaces(b.astype(float), s.sequential, s.flatness)
    pose = np.array(guess, float)
    for cutoff in np.geomspace(s.widest, s.narrowest, s.iterations - 2).tolist() + 2 * [s.narrowest]:
        information, gradient, error, used = normal_equations(
            points, normals, moved, moved_normals, pose, cutoff, s.window
        )
        if used < s.min_share * len(a):
            return None
        pose -= _inverse(information, s.told) @ gradient
        pose[2] = wrap(float(pose[2]))
    variance = max(s.sigma**2, error / used)
    return ScanMatch(pose, variance * _inverse(information, s.told, UNMEASURED), used / len(a))


UNMEASURED = 1e6  # the variance of a direction that too few pairs constrain, in pair variances


def _inverse(information: FloatArray, told: float, otherwise: float = 0.0) -> FloatArray:
    """Invert an information (3, 3) in the directions that enough pairs constrain; the others get `otherwise`.

    Because normals are noisy, every direction looks constrained a little, even along a bare corridor, and the position
    along it looks coupled with the turn. So unconstrained directions of the position are removed first: otherwise their
    uncertainty would spread into the turn, which the walls measure well. The turn is scaled by how far it moves the
    points, so that all three directions are measured in pairs.
    """
    arm = np.sqrt(max(information[2, 2] / max(information[0, 0] + information[1, 1], 1e-12), 1e-12))
    scale = np.array([1.0, 1.0, 1.0 / arm])
    pairs = information * np.outer(scale, scale)
    values, directions = np.linalg.eigh(pairs)
    least = told * float(values[-1])
    untold = directions[:2, (values <= least) & (directions[2] ** 2 < 0.5)]
    shifts, _, _ = np.linalg.svd(untold)
    lost, kept = np.zeros((3, untold.shape[1])), np.eye(3)[:, untold.shape[1] :]
    lost[:2], kept[:2, :-1] = np.split(shifts, [untold.shape[1]], axis=1)
    values, directions = np.linalg.eigh(kept.T @ pairs @ kept)
    directions = kept @ directions
    weights = np.where(values > least, 1.0 / np.maximum(values, 1e-12), otherwise)
    inverse: FloatArray = ((directions * weights) @ directions.T + otherwise * lost @ lost.T) * np.outer(scale, scale)
    return inverse
