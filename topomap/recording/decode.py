"""The log's records as the stack's: the inverse of `encode`."""

from __future__ import annotations

import numpy as np

from logs import header as head
from logs import records as log
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import CalibrationState, Candidate, Decision, Estimate, Plan, Verdict
from topomap.core.run_data import TrueCalibration


def pose(stored: log.Pose) -> Pose2:
    """Return a pose."""
    return Pose2(stored.x, stored.y, stored.heading)


def decision(stored: log.Closure) -> Decision:
    """Return a verdict with its candidate; raises ValueError for an unknown verdict."""
    candidate = Candidate(
        query_ns=stored.query_ns,
        match=stored.match,
        match_ns=stored.match_ns,
        relative=pose(stored.relative),
        covariance=np.array(stored.covariance, dtype=np.float64).reshape(3, 3),
        similarity=stored.similarity,
        query=stored.query,
        evidence=Evidence.of({score.name: score.value for score in stored.scores}),
    )
    return Decision(stored.stamp_ns, candidate, Verdict(stored.verdict), stored.reason)


def calibration(stored: log.Calibration) -> CalibrationState:
    """Return a calibration."""
    return CalibrationState(
        _estimate(stored.rotation_scale), _estimate(stored.distance_scale), _estimate(stored.curvature)
    )


def true_calibration(header: head.Header) -> TrueCalibration:
    """Return the odometer's true errors."""
    errors = header.errors
    return TrueCalibration(errors.rotation_scale, errors.distance_scale, errors.curvature)


def plan(header: head.Header) -> Plan:
    """Return the world's plan."""
    lines = tuple(np.array(line, dtype=np.float64).reshape(-1, 2) for line in header.plan.polylines)
    return Plan(lines, header.plan.circles, header.plan.labels)


def _estimate(stored: log.Estimate) -> Estimate:
    return Estimate(stored.value, stored.sigma, stored.observed)
