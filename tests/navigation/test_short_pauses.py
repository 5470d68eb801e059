"""The collector's walk over the whole map waits till a drive is over, and has nothing to find in it."""

from __future__ import annotations

import gc

import pytest
from played import Played, taught

from sim2d.records import SimReading
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator
from topomap.core.errors import RobotFault
from topomap.core.records import StepRecord
from topomap.core.robot import Reading
from topomap.navigation.navigator import Navigator
from topomap.navigation.runner import run
from topomap.navigation.short_pauses import NEVER


class Watching:
    def __init__(self, fails: bool = False) -> None:
        self.seen: list[int] = []
        self._fails = fails

    def observe(self, reading: Reading, record: StepRecord) -> None:
        self.seen.append(gc.get_threshold()[2])
        if self._fails:
            raise RobotFault("the observer fails")


@pytest.fixture(scope="module")
def readings() -> list[SimReading]:
    return taught(120)


def navigator() -> Navigator:
    return build_navigator(load_config(None, ()).stack)


def test_the_walk_is_put_off_while_a_robot_drives_and_only_then(readings: list[SimReading]) -> None:
    before, watching = gc.get_threshold(), Watching()
    run(Played(readings[:5]), navigator(), (watching,))
    assert watching.seen == [NEVER] * 5
    assert gc.get_threshold() == before
    with pytest.raises(RobotFault):
        run(Played(readings[:5]), navigator(), (Watching(fails=True),))
    assert gc.get_threshold() == before


def test_a_step_leaves_no_objects_that_hold_one_another(readings: list[SimReading]) -> None:
    """Such would be freed by the walk alone, and pile up until the drive is over."""
    driven = navigator()
    for reading in readings[:20]:
        driven.step(reading)
    gc.collect()
    gc.disable()
    try:
        for reading in readings[20:]:
            driven.step(reading)
        assert gc.collect() < len(readings[20:]) / 10
    finally:
        gc.enable()
    assert len(driven.mapper.map.nodes) > 5
