"""The robot's body: a round differential drive that collides and slides."""

from __future__ import annotations

import math

import pymunk

from sim2d.config import BodyConfig
from sim2d.world import ROBOT, STATIC, World

MAX_TURN = 0.8  # [rad/s] at 0.25 s a step it turns by 11 degrees
SUBSTEP = 0.0125  # [s] 5 mm at full speed: far less than the radius, so nothing is tunnelled through


class Body:
    """A disc in the world's space at x, y [m], heading [rad, not wrapped]."""

    def __init__(self, world: World, config: BodyConfig, x: float, y: float, heading: float) -> None:
        self._space = world.space
        self._config = config
        self.heading = heading
        self.contact = False
        self._body = pymunk.Body(1.0, float("inf"))
        self._body.position = (x, y)
        shape = pymunk.Circle(self._body, config.radius)
        shape.friction = 0.0
        shape.filter = pymunk.ShapeFilter(categories=ROBOT, mask=STATIC)
        world.space.add(self._body, shape)

    @property
    def x(self) -> float:
        """World x [m]."""
        return float(self._body.position.x)

    @property
    def y(self) -> float:
        """World y [m]."""
        return float(self._body.position.y)

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return self._config.radius

    def put(self, x: float, y: float, heading: float) -> None:
        """Set the body down somewhere else."""
        self._body.position = (x, y)
        self.heading = heading

    def wanted(self, forward: float, dt: float) -> float:
        """Return the way [m] that a command would drive in dt [s] with nothing in the way."""
        return _held(forward, self._config.max_speed) * dt

    def advance(self, forward: float, turn: float, dt: float) -> tuple[float, float]:
        """Drive for dt [s] at forward [m/s], turn [rad/s], held to the limits; return the true arc (m, rad)."""
        forward = _held(forward, self._config.max_speed)
        turn = _held(turn, MAX_TURN)
        count = max(1, round(dt / SUBSTEP))
        way, self.contact = 0.0, False
        for _ in range(count):
            way += self._substep(forward, turn, dt / count)
        return way, turn * dt

    def _substep(self, forward: float, turn: float, dt: float) -> float:
        """Move once and return the way made along the heading [m]."""
        middle = self.heading + 0.5 * turn * dt
        c, s = math.cos(middle), math.sin(middle)
        x, y = self.x, self.y
        self._body.velocity = (forward * c, forward * s)
        self._space.step(dt)
        self.heading += turn * dt
        self._body.each_arbiter(self._touch)
        return (self.x - x) * c + (self.y - y) * s

    def _touch(self, _arbiter: pymunk.Arbiter) -> None:
        self.contact = True


def _held(value: float, limit: float) -> float:
    """Return the value within +-limit; what is not a number stands still."""
    return max(-limit, min(limit, value)) if math.isfinite(value) else 0.0
