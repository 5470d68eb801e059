"""Steering and sliding along what is near."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.navigation.pilot import Pilot, PilotSettings


def ranges(bearing: float, distance: float, width: float = 0.6) -> np.ndarray:
    """A free world but for a wall piece at a bearing."""
    angles = np.arange(720) * 2 * math.pi / 720
    off = np.abs(np.angle(np.exp(1j * (angles - bearing))))
    return np.where(off < width, distance / np.cos(np.minimum(off, 1.0)), 8.0).astype(np.float32)


def test_it_drives_straight_to_what_lies_ahead() -> None:
    command = Pilot(PilotSettings()).steer(0.0, None)
    assert command.forward == pytest.approx(0.4)
    assert command.turn == 0.0


@pytest.mark.parametrize("bearing", [-2.0, -0.5, 0.5, 2.0])
def test_it_turns_towards_the_bearing(bearing: float) -> None:
    command = Pilot(PilotSettings()).steer(bearing, None)
    assert math.copysign(1.0, command.turn) == math.copysign(1.0, bearing)
    assert command.forward < 0.4


def test_it_never_drives_into_what_is_close_ahead() -> None:
    command = Pilot(PilotSettings()).steer(0.0, ranges(0.0, 0.3))
    assert abs(command.turn) > 0.5
    assert command.forward < 0.1


def test_a_wall_at_the_side_leaves_the_way_free() -> None:
    command = Pilot(PilotSettings()).steer(0.0, ranges(math.pi / 2, 0.3))
    assert command.forward == pytest.approx(0.4)


def test_it_slides_along_a_wall_that_the_bearing_leads_into() -> None:
    command = Pilot(PilotSettings()).steer(0.5, ranges(0.9, 0.35, 0.7))
    assert command.turn < 0.0


def test_the_speed_limit_of_a_leg_counts() -> None:
    assert Pilot(PilotSettings()).steer(0.0, None, 0.2).forward == pytest.approx(0.2)
