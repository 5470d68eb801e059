"""The tests that a closure candidate passes on the graph, each with a score and a reason in plain words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.special import chdtri

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.mapping.optimizer.problem import UNKNOWN_HEADING


@dataclass(frozen=True, slots=True)
class Finding:
    """What one test found: its name, whether the candidate passed, its score, and why."""

    test: str
    passed: bool
    score: float
    reason: str


class GateSettings(BaseModel):
    """When odometry contradicts a closure."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    probability: float = Field(default=0.99, gt=0.5, lt=1, description="share of true closures the gate lets pass")


class OdometryGate:
    """Refuses a closure that odometry can't explain, by its Mahalanobis distance."""

    def __init__(self, settings: GateSettings | None = None) -> None:
        self._s = settings or GateSettings()

    def judge(self, candidate: Candidate, expected: Pose2, path_covariance: FloatArray) -> Finding:
        """Compare a candidate's `match_from_query` with the map's.

        expected: the same relative pose as the map has it; path_covariance (3, 3): of expected, systematic
        errors included (`Chain.covariance`, `Chain.covariance_via`). The score is the distance in sigmas.
        """
        error = expected.to(candidate.relative).array()
        dof = 2 if candidate.covariance[2, 2] > UNKNOWN_HEADING else 3
        total = (candidate.covariance + path_covariance)[:dof, :dof]
        c, s = math.cos(expected.heading), math.sin(expected.heading)
        error[:2] = c * error[0] - s * error[1], s * error[0] + c * error[1]
        chi2 = float(error[:dof] @ np.linalg.solve(total, error[:dof]))
        limit = float(chdtri(dof, 1 - self._s.probability))
        return self._finding(math.sqrt(chi2), math.sqrt(limit), error, dof)

    def _finding(self, sigmas: float, limit: float, error: FloatArray, dof: int) -> Finding:
        passed = sigmas <= limit
        off = f"{math.hypot(error[0], error[1]):.1f} m"
        if dof == 3:
            off += f" and {abs(math.degrees(error[2])):.0f} degrees"
        verb = "allows" if passed else "contradicts"
        reason = f"odometry {verb} it: {off} off, {sigmas:.1f} sigmas (at most {limit:.1f})"
        return Finding("odometry", passed, sigmas, reason)
