"""The stack's records as the log's: pure conversions, each value made a plain Python number."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np

from logs import header as head
from logs import records as log
from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.core.records import CalibrationState, Decision, Estimate, MapChange, NodeAdded, Plan, Travel, Verdict
from topomap.core.robot import PlanReading, Reading, RigReading, Truth
from topomap.core.run_data import TrueCalibration

POINT_STRIDE = 4


def run_header(
    world: str,
    rig: RigReading,
    seed: int | None = None,
    config: Mapping[str, object] | None = None,
    versions: Mapping[str, str] | None = None,
    start: Truth | None = None,
    true_calibration: TrueCalibration | None = None,
    plan: PlanReading | None = None,
    replayed: bool = False,
) -> head.Header:
    """Return the log's header of a run; start: the true pose at the first step, where it is known."""
    known = true_calibration or TrueCalibration()
    return head.Header(
        world=world,
        rig=_rig(rig),
        seed=seed,
        config=json.dumps(config or {}, indent=1),
        versions=dict(versions or {}),
        start=None if start is None else log.Pose(float(start.x), float(start.y), float(start.heading)),
        errors=head.Errors(known.rotation_scale, known.distance_scale, known.curvature),
        plan=_plan(plan or Plan()),
        replayed=replayed,
    )


def _rig(rig: RigReading) -> head.Rig:
    return head.Rig(
        width=int(rig.width),
        height=int(rig.height),
        horizon_row=float(rig.horizon_row),
        focal=float(rig.focal),
        camera_height=float(rig.camera_height),
        forward_column=int(rig.forward_column),
        clockwise=bool(rig.clockwise),
    )


def _plan(plan: PlanReading) -> head.Plan:
    return head.Plan(
        tuple(tuple((float(x), float(y)) for x, y in line) for line in plan.polylines),
        tuple((float(x), float(y), float(r)) for x, y, r in plan.circles),
        tuple((float(x), float(y), str(text)) for x, y, text in plan.labels),
    )


def pose(pose: Pose2) -> log.Pose:
    """Return a pose for the log."""
    return log.Pose(float(pose.x), float(pose.y), float(pose.heading))


def row(values: FloatArray) -> tuple[float, ...]:
    """Return the values of an array of any shape, row by row."""
    flat: list[float] = np.asarray(values, dtype=np.float64).reshape(-1).tolist()
    return tuple(flat)


def odometry(reading: Reading) -> log.Odometry:
    """Return a reading's increment."""
    motion = reading.motion
    return log.Odometry(
        forward=float(motion.forward),
        left=float(motion.left),
        turn=float(motion.turn),
        covariance=row(motion.covariance),
        dt=float(motion.dt),
        contact=bool(reading.contact),
        driven=bool(reading.driven),
        scanned=reading.ranges is not None,
    )


def points(reading: Reading) -> log.Points:
    """Return every fourth ray's end point, for the viewers' point cloud; the scan keeps all rays."""
    assert reading.ranges is not None
    ranges = reading.ranges[::POINT_STRIDE]
    bearings = np.arange(0, len(reading.ranges), POINT_STRIDE) * (2 * np.pi / len(reading.ranges))
    known = np.isfinite(ranges)
    ranges, bearings = ranges[known], bearings[known]
    return log.Points(np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings)], axis=1).astype(np.float32))


def difference(change: MapChange, travel: Travel) -> log.ImageDifference:
    """Return a step's image differences."""
    difference, threshold, homing = (
        float(change.difference),
        float(change.threshold),
        float(travel.difference),
    )
    if change.place is None:
        return log.ImageDifference(difference, threshold, homing=homing)
    place = change.place
    return log.ImageDifference(
        difference, threshold, float(place.difference), int(place.node), float(place.rotation), homing
    )


def node(node: NodeAdded) -> log.Node:
    """Return a node that was added."""
    return log.Node(node.node, node.stamp_ns, pose(node.pose), bool(node.snapshot), node.reason)


def final_node(node: int, stamp_ns: int, where: Pose2, snapshot: bool) -> log.Node:
    """Return a node of the finished map."""
    return log.Node(int(node), int(stamp_ns), pose(where), bool(snapshot), "")


def closure(decision: Decision) -> log.Closure:
    """Return a verdict on a closure candidate."""
    candidate = decision.candidate
    return log.Closure(
        stamp_ns=decision.stamp_ns,
        verdict=decision.verdict.value,
        reason=decision.reason,
        query_ns=candidate.query_ns,
        query=candidate.query,
        match=candidate.match,
        match_ns=candidate.match_ns,
        relative=pose(candidate.relative),
        covariance=row(candidate.covariance),
        similarity=float(candidate.similarity),
        scores=scores(candidate.evidence.measured()),
    )


def scores(values: Mapping[str, float]) -> tuple[log.Score, ...]:
    """Return named numbers."""
    return tuple(log.Score(name, float(value)) for name, value in values.items())


def home_vector(travel: Travel) -> log.HomeVector:
    """Return the home vector of a step that has one."""
    assert travel.home is not None
    home = travel.home
    distance = None if home.distance is None else float(home.distance)
    return log.HomeVector(travel.milestone, float(home.bearing), distance, float(home.confidence))


def calibration(state: CalibrationState) -> log.Calibration:
    """Return a calibration."""
    return log.Calibration(_estimate(state.rotation_scale), _estimate(state.distance_scale), _estimate(state.curvature))


def _estimate(estimate: Estimate) -> log.Estimate:
    return log.Estimate(float(estimate.value), float(estimate.sigma), bool(estimate.observed))


def level(verdict: Verdict) -> log.Level:
    """Return how loud a verdict is said."""
    return log.Level.INFO if verdict in (Verdict.ACCEPTED, Verdict.WITHDRAWN) else log.Level.DEBUG


def sentence(decision: Decision) -> str:
    """Return a verdict as a line for people."""
    candidate = decision.candidate
    query = "here" if candidate.query is None else f"node {candidate.query}"
    return f"{query} with node {candidate.match} {decision.verdict.value}: {decision.reason}"
