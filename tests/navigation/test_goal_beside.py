"""A goal that lies beside the way is arrived at, not passed by."""

from __future__ import annotations

import math
from pathlib import Path

from topomap.app import runs
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator
from topomap.core.records import Phase

WAREHOUSE = Path(__file__).parents[2] / "examples" / "worlds" / "warehouse.toml"


def test_a_goal_beside_the_aisle_is_driven_to() -> None:
    """The short cut past it lies .35 m beside it, and the view, that changes slowly there, came no nearer."""
    config = load_config(None, ["sim.driver.laps=0.25", "stack.mission.do=goto:41"])
    robot, navigator = runs.open_world(str(WAREHOUSE), 0, config), build_navigator(config.stack)
    places: list[tuple[float, float]] = []
    goal = (math.inf, math.inf)
    while navigator.phase is not Phase.ARRIVED and len(places) < 900:
        reading = robot.sense()
        assert reading is not None
        truth = robot.truth()
        places.append((truth.x, truth.y))
        command, record = navigator.step(reading)
        robot.act(command)
        if any(added.node == 41 for added in record.change.added):
            goal = places[-1]
    assert navigator.phase is Phase.ARRIVED
    assert math.dist(places[-1], goal) < 0.1
