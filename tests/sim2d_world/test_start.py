"""Where the simulator sets the robot."""

from __future__ import annotations

import math

import pytest

from sim2d import worlds
from sim2d.config import SimConfig
from sim2d.errors import WorldError
from sim2d.robot import SimRobot


def robot(**parts: object) -> SimRobot:
    return SimRobot(worlds.load("room-corridor"), SimConfig.model_validate(parts), 0)


def test_it_stands_where_it_is_set_and_has_its_wheels() -> None:
    own = robot(start={"x": 2.0, "y": 1.5, "heading_deg": 90.0}, driver={"teaches": False})
    first = own.sense()
    assert first is not None
    assert not first.driven
    truth = own.truth()
    assert (truth.x, truth.y) == (2.0, 1.5)
    assert truth.heading == pytest.approx(math.pi / 2)
    assert own.expected_steps == 1


def test_the_driver_goes_on_from_a_way_along_the_route() -> None:
    own, whole = robot(start={"along": 5.0}), robot()
    first = own.sense()
    assert first is not None
    assert first.driven
    assert math.hypot(own.truth().x - whole.truth().x, own.truth().y - whole.truth().y) > 1.0
    x, y = own.truth().x, own.truth().y
    for _ in range(8):
        own.sense()
    assert 0.2 < math.hypot(own.truth().x - x, own.truth().y - y) < 0.9


@pytest.mark.parametrize(
    ("start", "said"), [({"place": "moon"}, "no such place; there are"), ({"along": 1e6}, "m long")]
)
def test_a_start_that_is_not(start: dict[str, object], said: str) -> None:
    with pytest.raises(WorldError, match=said):
        robot(start=start)


@pytest.mark.parametrize("start", [{"x": 1.0}, {"x": 1.0, "y": 1.0, "along": 2.0}, {"place": "a", "along": 0.0}])
def test_a_start_that_is_two_or_half_of_one(start: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="give"):
        robot(start=start)
