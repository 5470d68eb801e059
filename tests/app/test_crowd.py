"""Amid people who hide half of the view, six of them beside the robot all the way, it finds home and says so."""

from __future__ import annotations

import pytest

from topomap.app.disturbed import Disturbance
from topomap.app.journeys import journeys, teach

CROWD = ["sim.people={extra=6,beside=6}", "sim.driver.lateral_offset=0.2"]


@pytest.mark.slow
@pytest.mark.parametrize(("world", "seed"), [("hall", 2), ("room-corridor", 0)])
def test_home_is_found_amid_a_crowd(world: str, seed: int) -> None:
    home = next(journeys(teach(world, seed, 0, CROWD), 0, [Disturbance()]))
    assert home.home, home.notes[-5:]
    assert home.misled == 0
    assert home.ratio < 1.3
