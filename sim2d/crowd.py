"""More people: walkers along stretches of the robot's route, drawn from their own substream."""

from __future__ import annotations

import math

import numpy as np

from sim2d.config import PeopleConfig
from sim2d.path import Path
from sim2d.shapes import Look, Person

SPEED = 0.8  # [m/s] their greatest: a slow walk
ASIDE = 0.55  # [m] beside the route they walk: a robot of 0.2 m radius passes
STRETCH = (2.0, 8.0)  # [m] of the route that one of them walks
SPACING = 0.5  # [m] between the corners of a walk
BESIDE = (0.6, 1.0)  # [m] aside of the robot walk those who accompany it: nearer they would stand in its way
AHEAD = 1.5  # [m] at most before or behind it
HURRY = 1.5  # times the robot's speed, so that they keep up on the outside of a bend


def crowd(path: Path, config: PeopleConfig, rng: np.random.Generator, speed: float = 0.4) -> tuple[Person, ...]:
    """Return `config.extra` people beside the route, and `config.beside` beside the robot on its way.

    speed: the robot's [m/s]. The first of each kind don't depend on how many there are.
    """
    company = rng.spawn(1)[0]
    walkers = [_person(k, path, config, rng) for k in range(config.extra)]
    return (*walkers, *(_companion(k, path, speed, company) for k in range(config.beside)))


def _companion(k: int, path: Path, speed: float, rng: np.random.Generator) -> Person:
    """Return somebody who walks along the whole route aside of the robot, a little ahead or behind."""
    side = float(rng.uniform(*BESIDE)) * (1 if rng.random() < 0.5 else -1)
    lead = float(rng.uniform(-AHEAD, AHEAD))
    r, g, b = rng.uniform(0.1, 0.9, 3)
    return Person(
        name=f"companion {k + 1}",
        route=_beside(path, 0.0, path.length, side),
        speed=HURRY * speed,
        look=Look((float(r), float(g), float(b)), "person", 950 + k),
        marks=tuple(np.arange(0.0, path.length, SPACING).tolist()),
        lead=lead,
    )


def _beside(path: Path, begin: float, end: float, side: float) -> tuple[tuple[float, float], ...]:
    """Return the corners of a walk along the path from `begin` to `end` [m], `side` [m] to its left."""
    corners = []
    for s in np.arange(begin, end, SPACING):
        (x, y), heading = path.at(float(s)), path.heading(float(s))
        corners.append((x - side * math.sin(heading), y + side * math.cos(heading)))
    return tuple(corners)


def _person(k: int, path: Path, config: PeopleConfig, rng: np.random.Generator) -> Person:
    length = float(rng.uniform(*STRETCH))
    # nobody stands where the robot starts
    begin = float(rng.uniform(min(1.5, path.length), max(1.6, min(path.length, path.lap) - length)))
    side = ASIDE * (1 if rng.random() < 0.5 else -1)
    r, g, b = rng.uniform(0.1, 0.9, 3)
    return Person(
        name=f"walker {k + 1}",
        route=_beside(path, begin, begin + length, side),
        speed=SPEED * float(rng.uniform(0.5, 1.0)),
        look=Look((float(r), float(g), float(b)), "person", 900 + k),
        start_s=float(rng.uniform(0.0, 5.0)),
    )
