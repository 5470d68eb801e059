"""Along the office's corridors the odometer's wobble isn't taken for its scale: whole stretches, so `make bench`."""

from __future__ import annotations

import pytest

from topomap.app import runs
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2, 5, 7, 9])
def test_before_a_loop_is_closed_the_scale_stays_what_an_odometers_can_be(seed: int) -> None:
    config = load_config(None, ["stack.mission.then=stop"])
    robot, navigator = runs.open_world("office-loop", seed, config), build_navigator(config.stack)
    for _ in range(320):
        reading = robot.sense()
        assert reading is not None
        command, record = navigator.step(reading)
        assert not record.change.broken
        robot.act(command)
    found = navigator.mapper.optimisation.state.rotation_scale
    assert abs(found.value - robot.true_calibration.rotation_scale) < 3 * found.sigma
    assert found.sigma < 0.06
