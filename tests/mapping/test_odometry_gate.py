"""The odometry gate and agreement among closures."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.mapping.closures.odometry_gate import OdometryGate
from topomap.mapping.uncertainty.agreement import Agreeing, SupportSettings, support


def candidate(relative: Pose2, heading_variance: float = 0.005) -> Candidate:
    return Candidate(100, 1, 10, relative, np.diag([0.1, 0.1, heading_variance]))


def test_gate_lets_the_stated_share_of_true_closures_pass() -> None:
    rng, gate = np.random.default_rng(0), OdometryGate()
    path = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.05], [0.1, 0.05, 0.04]])
    expected = Pose2(1.0, -2.0, 0.7)
    rotation = np.eye(3)
    c, s = np.cos(0.7), np.sin(0.7)
    rotation[:2, :2] = [[c, -s], [s, c]]
    proposal = candidate(Pose2())
    total = path + proposal.covariance
    passed = []
    for draw in rng.multivariate_normal(np.zeros(3), total, 2000):
        claim = Pose2(expected.x + draw[0], expected.y + draw[1], expected.heading + draw[2])
        passed.append(gate.judge(candidate(claim), expected, path).passed)
    assert 0.98 < np.mean(passed) < 0.998


def test_gate_names_the_contradiction() -> None:
    finding = OdometryGate().judge(candidate(Pose2()), Pose2(6.0, 0.0, 0.0), np.eye(3) * 0.1)
    assert not finding.passed
    assert finding.score > 10
    assert "contradicts" in finding.reason
    assert "6.0 m" in finding.reason


def test_opposite_heading_passes_only_where_heading_isnt_claimed() -> None:
    expected = Pose2(0.1, 0.0, np.pi)
    assert not OdometryGate().judge(candidate(Pose2()), expected, np.eye(3) * 0.05).passed
    assert OdometryGate().judge(candidate(Pose2(), 40.0), expected, np.eye(3) * 0.05).passed


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("blind", [False, True])
def test_a_run_of_true_closures_supports_itself(reverse: bool, blind: bool) -> None:
    """Out and back (or twice the same way) along a line: true pairs agree, strays don't."""
    there = np.column_stack([np.arange(20.0), np.zeros(20), np.zeros(20)])
    again = there[::-1].copy() if reverse else there
    again[:, 2] = np.pi if reverse else 0.0
    poses = np.vstack([there, again])
    j = np.arange(25, 35)
    i = 39 - j if reverse else j - 20
    i = np.append(i, [2, 17])
    j = np.append(j, [33, 24])
    relative = np.zeros((12, 3))
    relative[:, 2] = np.pi if reverse else 0.0
    claims = Agreeing(i, j, relative, np.full(12, blind), np.ones(12))
    found = support(claims, poses, np.arange(40.0) * 1.0, SupportSettings())
    assert (found[:10] >= 4).all()
    assert found[10:].max() < found[:10].min()
