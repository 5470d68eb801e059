"""The odometry gate and agreement among closures."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.gates import Gate
from topomap.mapping.closures.robot_tests import GATE
from topomap.mapping.uncertainty.agreement import Agreeing, SupportSettings, support

OWN = np.diag([0.1, 0.1, 0.005])


def passes(gate: Gate, claimed: Pose2, expected: Pose2, errors: np.ndarray, own: np.ndarray = OWN) -> bool:
    """Whether a claim passes beside a map that begins at the origin and has the place at `expected`."""
    claim, knowledge = asked(claimed, expected, errors, own)
    return bool(gate.weigh(claim, knowledge)[0] == 0.0)


def asked(claimed: Pose2, expected: Pose2, errors: np.ndarray, own: np.ndarray = OWN) -> tuple[Claims, Knowledge]:
    poses = np.array([[0.0, 0.0, 0.0], expected.array()])
    return Claims.of_one(0, 1, claimed, own), Knowledge.of_one(poses, errors)


@pytest.mark.parametrize("share", [GATE, 0.99])
def test_gate_lets_the_stated_share_of_true_closures_pass(share: float) -> None:
    rng, gate = np.random.default_rng(0), Gate(share)
    errors = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.04]])
    expected = Pose2(0.0, 0.0, 0.7)
    passed = [
        passes(gate, Pose2(draw[0], draw[1], 0.7 + draw[2]), expected, errors)
        for draw in rng.multivariate_normal(np.zeros(3), errors + OWN, 3000)
    ]
    assert abs(np.mean(passed) - share) < 3 * np.sqrt(share * (1 - share) / 3000)


def test_gate_names_the_contradiction() -> None:
    claim, knowledge = asked(Pose2(), Pose2(6.0, 0.0, 0.0), np.eye(3) * 0.1)
    assert not passes(Gate(GATE), Pose2(), Pose2(6.0, 0.0, 0.0), np.eye(3) * 0.1)
    assert Gate(GATE).reason(claim, knowledge).startswith("odometry contradicts it: 6.0 m and 0 degrees off")
    claim, knowledge = asked(Pose2(), Pose2(0.1, 0.0, 0.0), np.eye(3) * 0.1)
    assert Gate(GATE).reason(claim, knowledge).startswith("odometry allows it: 0.1 m")


def test_opposite_heading_passes_only_where_heading_isnt_claimed() -> None:
    expected = Pose2(0.1, 0.0, np.pi)
    assert not passes(Gate(0.99), Pose2(), expected, np.eye(3) * 0.05)
    assert passes(Gate(0.99), Pose2(), expected, np.eye(3) * 0.05, np.diag([0.1, 0.1, 40.0]))


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
