"""The driver on lines that turn back on the spot, and in the worlds of this package."""

from __future__ import annotations

import math

import pytest

from sim2d import worlds
from sim2d.body import Body
from sim2d.config import BodyConfig, DriverConfig, SimConfig
from sim2d.driver import STUCK_S, Driver
from sim2d.errors import WorldError
from sim2d.path import of_route
from sim2d.robot import SimRobot
from sim2d.shapes import Ground, Look, Route, Spec
from sim2d.world import World
from sim2d.worlds.room import room_corridor


def drive(world: World, route: Route, laps: float | None = None) -> tuple[Driver, float, bool]:
    """Drive a route; return the driver, the largest distance off it [m] and whether something was touched."""
    path = of_route(route, laps)
    body = Body(world, BodyConfig(), *path.at(0.0), path.heading(0.0))
    driver = Driver(path, DriverConfig(), BodyConfig())
    off, contact = 0.0, False
    for _ in range(round(path.length * 14) + 100):
        command = driver.command(body.x, body.y, body.heading)
        if driver.done:
            break
        body.advance(*command, 0.25)
        off = max(off, math.dist((body.x, body.y), path.at(driver.progress)))
        contact |= body.contact
    return driver, off, contact


def field(route: Route) -> World:
    ground = Ground(Look((0.5, 0.5, 0.5), "plain"))
    return World(Spec("field", route, ground, ground, 2.5))


@pytest.mark.parametrize(
    "route",
    [
        Route(((0, 0), (4, 0)), 2),
        Route(((0, 0), (3, 0), (3, 3), (0, 3)), 3, both_ways=True),
        Route(((0, 0), (3, 0), (3, 3), (0, 3)), 1.5, both_ways=True),
    ],
)
def test_lines_that_turn_back_are_driven_to_their_end(route: Route) -> None:
    driver, off, _ = drive(field(route), route)
    assert driver.done
    assert off < 0.3
    assert len(driver.path.cusps) >= 1


@pytest.mark.parametrize("name", ["ourlab", "a1original", "screen", "arboreal", "hall1", "cylinders"])
def test_the_small_worlds_are_driven_without_contact(name: str) -> None:
    world = worlds.load(name)
    driver, off, contact = drive(world, world.spec.route)
    assert driver.done
    assert not contact
    assert off < 0.25


def test_a_driver_who_makes_no_way_is_stuck_after_two_minutes() -> None:
    body = BodyConfig()
    driver = Driver(of_route(room_corridor().route), DriverConfig(), body)
    x, y = driver.path.at(0.0)
    calls = 0
    while not driver.stuck and calls < 2000:
        driver.command(x, y, 0.0)
        calls += 1
    assert calls * body.step == pytest.approx(STUCK_S, abs=3 * body.step)
    driver.command(*driver.path.at(0.4), 0.0)
    assert not driver.stuck, "way is made"


def test_a_route_that_cannot_be_driven_ends_in_one_line() -> None:
    config = SimConfig(driver=DriverConfig(lateral_offset=3.0))
    robot = SimRobot(World(room_corridor()), config, 0)

    def all_the_way() -> None:
        for _ in range(20 * robot.expected_steps):
            robot._move()

    with pytest.raises(WorldError, match=r"stuck for 120 s at x = .*: the route can't be driven so"):
        all_the_way()
