"""Tests that let a claim pass or refuse it: odometry's gate, and company."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, wrap
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.odds import mahalanobis


@dataclass(frozen=True, slots=True)
class Supported:
    """Refuses a claim that too few of its neighbours agree with."""

    name: str = "support"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return np.where(knowledge.support >= 1.0, 0.0, -np.inf)


@dataclass(frozen=True, slots=True)
class Gate:
    """Refuses a claim that odometry can't explain; probability: share of true ones that pass."""

    probability: float
    name: str = "gate"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        chi2, _ = mahalanobis(claims, knowledge.poses, knowledge.errors)
        return np.where(chi2 <= self._limit(claims), 0.0, -np.inf)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say how far a single claim is off what odometry says."""
        chi2, limit = float(mahalanobis(claims, knowledge.poses, knowledge.errors)[0][0]), float(self._limit(claims)[0])
        missed = between(knowledge.poses[claims.i], knowledge.poses[claims.j])[0] - claims.relative[0]
        off = f"{math.hypot(missed[0], missed[1]):.1f} m"
        if not claims.blind[0]:
            off += f" and {abs(math.degrees(wrap(float(missed[2])))):.0f} degrees"
        verb = "allows" if chi2 <= limit else "contradicts"
        return f"odometry {verb} it: {off} off, {math.sqrt(chi2):.1f} sigmas (at most {math.sqrt(limit):.1f})"

    def _limit(self, claims: Claims) -> FloatArray:
        return np.asarray(chdtri(np.where(claims.blind, 2, 3), 1 - self.probability))
