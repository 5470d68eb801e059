"""office-loop: 2 m wide corridors in a ring with a door that looks like every other one every 3 m."""

from __future__ import annotations

import math
from dataclasses import replace

from sim2d.shapes import Cylinder, Decal, Ground, Look, Point, Route, Spec, Wall, rectangle

LENGTH, DEPTH, HEIGHT, HALF = 42.0, 24.0, 2.6, 1.0  # [m] centre line, ceiling, half the corridor's width
PITCH = 3.0  # [m] from door to door
WALLPAPER = (0.78, 0.76, 0.7)


def office_loop() -> Spec:
    """Return two laps of a ring of 130 m and 20 m of the third, so that home is some way off."""
    outer = rectangle(-HALF, -HALF, LENGTH + HALF, DEPTH + HALF)
    inner = rectangle(HALF, HALF, LENGTH - HALF, DEPTH - HALF)
    route = Route(ring=((3.0, 0.0), (LENGTH, 0.0), (LENGTH, DEPTH), (0.0, DEPTH), (0.0, 0.0)), laps=2.15, radius=0.7)
    return Spec(
        name="office-loop",
        purpose="a long ring of look-alike doors: closing loops among false friends",
        route=route,
        routes={"both-ways": replace(route, both_ways=True)},
        floor=Ground(Look((0.36, 0.4, 0.46), "speckle", 3), tile=3.0, gloss=0.1),
        ceiling=Ground(Look((0.85, 0.85, 0.83), "plain", 4), tile=3.0, lamps=3.0, first_lamp=0.0),
        ceiling_height=HEIGHT,
        walls=(*_ring("outer", outer, 100), *_ring("inner", inner, 200)),
        cylinders=_things(),
        goal=(3.0, 0.0),
        labels=((LENGTH / 2, DEPTH / 2, "offices"),),
    )


def _ring(name: str, corners: tuple[Point, ...], seed: int) -> tuple[Wall, ...]:
    """Return the four walls of one side, so that equal stretches look alike."""
    pairs = zip(corners, corners[1:] + corners[:1], strict=True)
    return tuple(_wall(f"{name} {k}", a, b, seed + k) for k, (a, b) in enumerate(pairs))


def _wall(name: str, a: Point, b: Point, seed: int) -> Wall:
    """Return a wall of doors, with a few posters and extinguishers that tell stretches apart."""
    length = math.dist(a, b)
    doors = [
        Decal("door", PITCH * k + 1.0, 1.0, 0.0, 2.1, (0.5, 0.36, 0.22), 1) for k in range(int((length - 1) // PITCH))
    ]
    return Wall((a, b), HEIGHT, Look(WALLPAPER, "paper", 5, (*doors, *_marks(seed, len(doors)))), name)


def _marks(seed: int, doors: int) -> list[Decal]:
    """Return the few things that differ, between doors."""
    marks = []
    for k in range(2 + seed % 3, doors, 4):
        at = PITCH * k + 2.3
        number = seed * 50 + k
        tone = ((number * 37) % 97 / 97, (number * 53) % 89 / 89, (number * 71) % 83 / 83)
        if (seed + k) % 3 == 0:
            marks.append(Decal("extinguisher", at, 0.4, 0.7, 1.7, tone, 2))
        else:
            marks.append(Decal("poster", at, 0.7 + 0.1 * (k % 4), 1.0, 1.9, tone, number))
    return marks


def _things() -> tuple[Cylinder, ...]:
    """Return the few bins and plants in the corners."""
    clay = (0.6, 0.3, 0.2)
    return (
        Cylinder(LENGTH + 0.75, -0.75, 0.2, 1.3, Look(clay, "leaves", 31), "plant"),
        Cylinder(-0.75, DEPTH + 0.75, 0.2, 0.9, Look((0.3, 0.3, 0.35), "leaves", 32), "plant"),
        Cylinder(LENGTH + 0.8, DEPTH + 0.8, 0.15, 0.5, Look((0.2, 0.3, 0.6), "plaster", 33), "bin"),
    )
