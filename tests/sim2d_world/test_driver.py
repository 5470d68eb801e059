"""The driver on lines that turn back on the spot, and in the worlds of this package."""

from __future__ import annotations

import math

import pytest

from sim2d import worlds
from sim2d.body import Body
from sim2d.config import BodyConfig, DriverConfig
from sim2d.driver import Driver
from sim2d.path import of_route
from sim2d.shapes import Ground, Look, Route, Spec
from sim2d.world import World


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
