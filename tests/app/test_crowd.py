"""Amid people who hide half of the view, six of them beside the robot all the way, it finds home or says it didn't."""

from __future__ import annotations

import pytest

from topomap.app.disturbed import Disturbance
from topomap.app.journeys import journeys, teach
from topomap.bench.journeys import tally

CROWD = ["sim.people={extra=6,beside=6}", "sim.driver.lateral_offset=0.2"]


@pytest.mark.slow
@pytest.mark.parametrize(("world", "least"), [("hall", 3), ("room-corridor", 5)])
def test_home_is_found_amid_a_crowd(world: str, least: int) -> None:
    """Of `real-weather.toml`'s ten ways home amid them none was claimed while whole views alone were compared."""
    made = [next(journeys(teach(world, seed, 0, CROWD), 0, [Disturbance()])) for seed in range(5)]
    counted = tally(made)
    assert counted.false == 0
    assert sum(one.home for one in made) >= least, [one.last for one in made]
