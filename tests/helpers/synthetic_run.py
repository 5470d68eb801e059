"""A run made by hand: a room driven round twice with a drifting odometer, closed at every corner, then
home."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2, between, compose
from topomap.core.records import CalibrationState, Candidate, Decision, Estimate, Plan, Verdict
from topomap.core.run_data import NodeData, RunData, TrueCalibration

STEP_NS = 250_000_000
START_NS = 1_000_000_000_000
SIDES = (80, 60, 80, 60)
LAP = sum(SIDES)


def motions(laps: int = 2, extra: int = 60) -> FloatArray:
    """Return the true increments (N-1, 3) of a course of 8 m by 6 m in steps of 0.1 m, a corner in ten
    steps."""
    turns = []
    for index in range(laps * LAP + extra):
        along = index % LAP
        corners = np.cumsum(SIDES)
        turns.append(math.pi / 20 if any(corner - 10 <= along < corner for corner in corners) else 0.0)
    turn = np.array(turns)
    return np.column_stack([np.full_like(turn, 0.1), np.zeros_like(turn), turn])


def integrate(start: FloatArray, steps: FloatArray) -> FloatArray:
    """Return the poses (N, 3) of a start and increments (N-1, 3)."""
    poses = [start]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)


def stamp(step: int) -> int:
    """Return the stamp [ns] of a step."""
    return START_NS + STEP_NS * step


def candidate(run: RunData, query: int, match: int) -> Candidate:
    """Return the candidate that step `query` stood where the node of step `match` was taken, as the truth has
    it."""
    assert run.truth is not None
    relative = Pose2.of(run.truth[match]).to(Pose2.of(run.truth[query]))
    node = next((node.node for node in run.nodes if node.stamp_ns == stamp(match)), match)
    return Candidate(
        stamp(query),
        node,
        stamp(match),
        relative,
        np.diag([0.04, 0.04, 0.001]),
        0.9,
        evidence=Evidence(difference=0.31, odds=3.0, looks=1.0),
    )


def decide(candidate: Candidate, verdict: Verdict = Verdict.ACCEPTED, later: int = 0) -> Decision:
    """Return a decision on a candidate some steps after its query."""
    return Decision(candidate.query_ns + later * STEP_NS, candidate, verdict, f"{verdict}: made up")


def make_run() -> RunData:
    """Return the run: 10 % too much turn, a map that is nearly right, two true closures, one false, one
    refused."""
    rng = np.random.default_rng(7)
    steps = motions()
    start = np.array([-4.0, -3.0, 0.3])
    truth = integrate(start, steps)
    read = steps * np.array([0.95, 1.0, 1.04]) + np.array([0.0, 0.0, 0.0003])
    dead = integrate(np.zeros(3), read)
    exact = between(truth[0], truth)
    final = exact + np.column_stack([0.04 * np.sin(np.arange(len(exact)) / 40)] * 2 + [np.zeros(len(exact))])
    final[0] = 0.0
    online = np.where(np.arange(len(dead))[:, None] < LAP + 5, dead, final)
    count = len(truth)
    image = rng.integers(0, 255, (25, 90, 3), dtype=np.uint8).repeat(4, 0).repeat(8, 1)
    nodes = tuple(NodeData(k, stamp(8 * k), final[8 * k], True, image) for k in range(LAP // 8))
    plan = Plan((room(truth),), ((-1.0, 1.0, 0.4),), ((-1.0, 1.0, "pillar"),))
    run = RunData(
        world="synthetic room", seed=3, config={"mapping": {"threshold": 0.4}, "seed": 3},
        versions={"topomap": "0.1.0", "numpy": np.__version__},
        stamps_ns=stamp(0) + STEP_NS * np.arange(count, dtype=np.int64),
        dead_reckoning=dead, online=online, final=final, truth=truth, plan=plan,
        driven=np.arange(count) < 2 * LAP, contact=np.isin(np.arange(count), [100, 2 * LAP + 5, 2 * LAP + 6]),
        difference=0.05 + 0.4 * ((np.arange(count) % 8) / 8) + 0.02 * rng.random(count),
        place_difference=np.where(np.arange(count) < 100, np.nan, 1.2 - 0.9 * (np.arange(count) > LAP - 20)),
        homing_difference=np.where(np.arange(count) < 2 * LAP, np.nan, 0.3), threshold=0.42,
        nodes=nodes, calibration=believed(), true_calibration=TrueCalibration(1.04, 0.95, 0.003),
        first_closure=(("40 steps before", image), ("at the closure", image), ("the match, node 0", image)),
        stage_ms={"map": 3.0 + rng.random(count), "travel": np.full(count, 2.0)},
        goal_node=7, claimed=True, milestones=(1, 3, 5, 7), graph_hash="3f2a" * 16, steps_per_s=81.0,
    )  # fmt: skip
    return replace(run, decisions=decisions(run))


def believed() -> CalibrationState:
    """Return a calibration with the distance scale not observed."""
    return CalibrationState(Estimate(1.036, 0.008, True), Estimate(1.0, 0.196, False), Estimate(0.0028, 0.0004, True))


def decisions(run: RunData) -> tuple[Decision, ...]:
    """Return decisions in time order."""
    first, second = candidate(run, LAP + 5, 8), candidate(run, LAP + 100, 96)
    false = replace(candidate(run, LAP + 150, 40), relative=Pose2(0.0, 0.0, 0.0))
    return (
        decide(candidate(run, LAP, 200), Verdict.REFUSED),
        decide(first, Verdict.PENDING),
        decide(first, later=4),
        decide(second),
        decide(false),
    )


def room(truth: FloatArray) -> FloatArray:
    """Return walls (5, 2) half a metre outside the true route."""
    low, high = truth[:, :2].min(axis=0) - 0.5, truth[:, :2].max(axis=0) + 0.5
    return np.array([low, [high[0], low[1]], high, [low[0], high[1]], low])
