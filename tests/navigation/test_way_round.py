"""Ways round what stands ahead, by ranges and after a contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.core.records import Command
from topomap.navigation.manoeuvres.back_off import FORGET, SPEED, STEPS, BackOff
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.way_round import way_round

CLEAR = 0.26
ANGLES = np.arange(720) * math.tau / 720


def wall_with_gap(ahead: float, left: float, right: float) -> np.ndarray:
    """Ranges before a wall across the way, `ahead` [m], that is open from y = right to y = left."""
    with np.errstate(divide="ignore"):
        ranges = np.where(np.cos(ANGLES) > 1e-3, ahead / np.maximum(np.cos(ANGLES), 1e-3), 9.0)
    y = ahead * np.tan(ANGLES)
    open_ = (np.cos(ANGLES) > 1e-3) & (y < left) & (y > right)
    return np.where(open_, 9.0, np.minimum(ranges, 9.0)).astype(np.float32)


AIM = ((1.2, 0.0),)


def test_a_gap_beside_the_straight_way_is_gone_through() -> None:
    left = way_round(AIM, wall_with_gap(0.6, 1.0, 0.1), CLEAR)
    right = way_round(AIM, wall_with_gap(0.6, -0.1, -1.0), CLEAR)
    assert left is not None
    assert right is not None
    assert left == pytest.approx(-right, abs=0.15)
    assert 0.3 < left < 1.6


def test_a_gap_that_is_too_narrow_is_none() -> None:
    assert way_round(AIM, wall_with_gap(0.6, 0.6, 0.2), CLEAR) is None
    assert way_round(AIM, wall_with_gap(0.6, 0.0, 0.0), CLEAR) is None


def test_an_aim_inside_of_something_is_passed_over_for_the_next() -> None:
    ranges = wall_with_gap(0.8, 1.2, 0.2)
    assert way_round(((0.8, -0.3),), ranges, CLEAR) is None
    assert way_round(((0.8, -0.3), (1.4, 0.4)), ranges, CLEAR) is not None


def test_where_nothing_stands_the_way_leads_ahead() -> None:
    found = way_round(AIM, np.full(720, np.nan, np.float32), CLEAR)
    assert found == pytest.approx(0.0, abs=0.15)


def test_the_pilot_goes_straight_where_it_can_and_round_where_it_cant() -> None:
    pilot = Pilot(PilotSettings())
    assert pilot.steer(0.0, wall_with_gap(2.0, 0.0, 0.0), aims=AIM).turn == 0.0
    assert pilot.steer(0.0, wall_with_gap(0.6, 1.0, 0.1), aims=AIM).turn > 0.3
    assert pilot.steer(0.0, wall_with_gap(0.6, -0.1, -1.0), aims=AIM).turn < -0.3


def test_a_contact_backs_off_once_and_what_was_touched_is_gone_round() -> None:
    after = BackOff(0.2)
    here = Pose2(1.0, 1.0, math.pi / 2)
    assert after.step(False, here, 0.0, True) is None
    assert [after.step(True, here, 0.1 * k, True) for k in range(STEPS)] == [Command(-SPEED)] * STEPS
    assert after.step(False, here, 1.0, True) is None
    back = Pose2(1.0, 0.7, math.pi / 2)
    ranges = after.ranges(None, back)
    assert ranges is not None
    assert np.nanmin(ranges) == pytest.approx(0.53, abs=0.01)
    assert abs(Pilot(PilotSettings()).steer(0.0, ranges, aims=AIM).turn) > 0.3
    measured = np.full(720, 5.0, np.float32)
    merged = after.ranges(measured, back)
    assert merged is not None
    assert merged[0] == pytest.approx(0.53, abs=0.01)
    assert merged[360] == 5.0
    assert measured[0] == 5.0


def test_what_was_touched_is_forgotten_after_some_way() -> None:
    after = BackOff(0.2)
    after.step(True, Pose2(), 0.0, True)
    after.step(False, Pose2(), FORGET + 0.1, False)
    assert after.ranges(None, Pose2()) is None


def test_something_that_touches_a_robot_that_stands_is_no_obstacle() -> None:
    after = BackOff(0.2)
    assert after.step(True, Pose2(), 0.0, False) is None
    assert after.ranges(None, Pose2()) is None
