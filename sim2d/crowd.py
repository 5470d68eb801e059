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


def crowd(path: Path, config: PeopleConfig, rng: np.random.Generator) -> tuple[Person, ...]:
    """Return `config.extra` people beside the route; the first ones don't depend on how many there are."""
    return tuple(_person(k, path, config, rng) for k in range(config.extra))


def _person(k: int, path: Path, config: PeopleConfig, rng: np.random.Generator) -> Person:
    length = float(rng.uniform(*STRETCH))
    # nobody stands where the robot starts
    begin = float(rng.uniform(min(1.5, path.length), max(1.6, min(path.length, path.lap) - length)))
    side = ASIDE * (1 if rng.random() < 0.5 else -1)
    corners = []
    for s in np.arange(begin, begin + length, SPACING):
        (x, y), heading = path.at(float(s)), path.heading(float(s))
        corners.append((x - side * math.sin(heading), y + side * math.cos(heading)))
    r, g, b = rng.uniform(0.1, 0.9, 3)
    return Person(
        name=f"walker {k + 1}",
        route=tuple(corners),
        speed=SPEED * float(rng.uniform(0.5, 1.0)),
        look=Look((float(r), float(g), float(b)), "person", 900 + k),
        start_s=float(rng.uniform(0.0, 5.0)),
    )
