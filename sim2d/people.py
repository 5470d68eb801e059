"""People who walk to and fro: upright cylinders that are seen, hit by rays and bumped into."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pymunk
from numpy.typing import NDArray

from sim2d.errors import WorldError
from sim2d.render import scene as scenes
from sim2d.render.atlas import AtlasBuilder
from sim2d.shapes import Person, Point

SOLID, AGENT = 0b1, 0b10  # pymunk categories: what stops rays and the robot; the robot
REACH = 0.1  # [m] people stop this far from the robot


class Walker:
    """A person on the way: `walked` [m] counts from the start of the route; x, y [m], heading [rad]."""

    def __init__(self, person: Person, tile: int, space: pymunk.Space) -> None:
        if len(person.route) < 2 or not (person.speed >= 0 and person.radius > 0 and person.height > 0):
            raise WorldError(f"person {person.name!r} needs two points of a route, a radius and a height above 0")
        self.person, self.tile, self.walked = person, tile, 0.0
        corners = np.array(person.route, dtype=np.float64)
        self._corners = corners
        self._along = np.concatenate([np.zeros(1), np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
        self._body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self.x, self.y, self.heading = *self.at(0.0), 0.0
        self._body.position = (self.x, self.y)
        shape = pymunk.Circle(self._body, person.radius)
        shape.friction = 0.0
        shape.filter = pymunk.ShapeFilter(categories=SOLID, mask=AGENT)
        space.add(self._body, shape)

    def at(self, walked: float) -> Point:
        """Return the place x, y [m] after so many metres to and fro."""
        total = float(self._along[-1])
        s = total - abs(walked % (2 * total) - total) if total > 0 else 0.0
        return float(np.interp(s, self._along, self._corners[:, 0])), float(
            np.interp(s, self._along, self._corners[:, 1])
        )

    def start(self, seconds: float, dt: float, robot: tuple[float, float, float], along: float) -> None:
        """Set out on a step of dt [s] that begins at `seconds`; wait while the robot (x, y, radius) is in the way.

        along: how far the robot is on its route [m], for those who accompany it.
        """
        self._settle()
        ahead = self._ahead(seconds, dt, along)
        x, y = self.at(ahead)
        space = self.person.radius + robot[2] + REACH
        nearer = math.dist((x, y), robot[:2]) < math.dist((self.x, self.y), robot[:2])
        if nearer and math.dist((x, y), robot[:2]) < space:
            ahead, x, y = self.walked, self.x, self.y
        self._body.velocity = ((x - self.x) / dt, (y - self.y) / dt)
        if (x, y) != (self.x, self.y):
            self.heading = math.atan2(y - self.y, x - self.x)
        self.walked, self.x, self.y = ahead, x, y

    def _ahead(self, seconds: float, dt: float, along: float) -> float:
        """Return the way walked at the end of the step [m]."""
        most = self.person.speed * dt * (seconds >= self.person.start_s)
        if not self.person.marks:
            return self.walked + most
        wished = float(np.interp(along + self.person.lead, self.person.marks, self._along))
        return self.walked + max(-most, min(most, wished - self.walked))

    def _settle(self) -> None:
        """Stand exactly where the last step was to end: sums of small steps would wander off."""
        self._body.position = (self.x, self.y)
        self._body.velocity = (0.0, 0.0)


class People:
    """All walkers of a world."""

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        self.walkers: list[Walker] = []

    def __len__(self) -> int:
        return len(self.walkers)

    @property
    def accompany(self) -> bool:
        """Whether anybody keeps to the robot."""
        return any(walker.person.marks for walker in self.walkers)

    def add(self, persons: Iterable[Person], builder: AtlasBuilder) -> None:
        """Add persons at the start of their routes. Raises WorldError for one that can't walk."""
        for person in persons:
            look = replace(person.look, texture="person") if person.look.texture == "plain" else person.look
            tile = builder.surface(look, math.tau * person.radius, person.height)
            self.walkers.append(Walker(person, tile, self._space))

    def start(self, seconds: float, dt: float, robot: tuple[float, float, float], along: float = 0.0) -> None:
        """Let everybody set out on a step (see `Walker.start`); the space's own steps carry them."""
        for walker in self.walkers:
            walker.start(seconds, dt, robot, along)

    def append_to(self, surfaces: scenes.Surfaces) -> scenes.Surfaces:
        """Return surfaces with a circle for everybody behind them; where it stands is written by `place`."""
        count, solids = len(self.walkers), int(surfaces.solid.max(initial=-1)) + 1
        tiles = np.array([walker.tile for walker in self.walkers], dtype=np.int64)
        tops = np.array([walker.person.height for walker in self.walkers])
        added = scenes.Surfaces(
            np.full(count, scenes.CIRCLE), np.zeros((count, 4)), solids + np.arange(count), tops, tiles,
            np.zeros(count), np.ones(count),
        )  # fmt: skip
        return scenes.Surfaces(*(np.concatenate(pair) for pair in zip(surfaces, added, strict=True)))

    def place(self, line: NDArray[np.float64], along: NDArray[np.float64]) -> None:
        """Write where everybody stands into the last rows of a scene; faces look ahead."""
        first = len(line) - len(self.walkers)
        for k, walker in enumerate(self.walkers, first):
            line[k, 0], line[k, 1], line[k, 2] = walker.x, walker.y, walker.person.radius
            along[k] = -walker.heading * walker.person.radius
