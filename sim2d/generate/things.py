"""Things along the walls of generated worlds, on the floor's side and out of the driver's way."""

from __future__ import annotations

import math

import numpy as np

from sim2d.furniture import KINDS, turned_rectangle
from sim2d.generate.blocks import Edge
from sim2d.shapes import Box, Colour, Cylinder, Look

SORTS = ("cupboard", "shelf", "locker", "bench", "cabinet", "machine", "drawers")
CLAY: tuple[Colour, ...] = ((0.62, 0.3, 0.18), (0.85, 0.83, 0.78), (0.25, 0.3, 0.5), (0.4, 0.4, 0.42))
PAINT: tuple[Colour, ...] = ((0.6, 0.2, 0.18), (0.25, 0.42, 0.6), (0.62, 0.6, 0.56), (0.35, 0.5, 0.32))


def along_walls(edges: list[Edge], every: float, rng: np.random.Generator) -> tuple[list[Box], list[Cylinder]]:
    """Return furniture, plants and bins about every so many metres along edges; few looks, used again and again."""
    boxes: list[Box] = []
    rounds: list[Cylinder] = []
    for edge in edges:
        length = math.dist(edge.a, edge.b)
        s = float(rng.uniform(1.0, every))
        while s < length - 1.2:
            if rng.random() < 0.6:
                boxes.append(_box(edge, s, rng, len(boxes)))
            else:
                rounds.append(_round(edge, s, rng, len(rounds)))
            s += float(rng.uniform(0.6, 1.4)) * every
    return boxes, rounds


def _beside(edge: Edge, s: float, off: float) -> tuple[float, float, float]:
    """Return the point s [m] along an edge and `off` [m] to its left, and its direction [rad]."""
    turn = math.atan2(edge.b[1] - edge.a[1], edge.b[0] - edge.a[0])
    c, sin = math.cos(turn), math.sin(turn)
    return edge.a[0] + c * s - sin * off, edge.a[1] + sin * s + c * off, turn


def _box(edge: Edge, s: float, rng: np.random.Generator, number: int) -> Box:
    kind = SORTS[int(rng.integers(len(SORTS)))]
    height, texture, own = KINDS[kind]
    wide, deep = 0.9 + 0.5 * int(rng.integers(2)), 0.35
    x, y, turn = _beside(edge, s, 0.5 * deep + 0.01)
    seed = int(rng.integers(4))
    look = Look(own if seed % 2 else PAINT[(seed + len(kind)) % len(PAINT)], texture, seed)
    return Box(turned_rectangle((x, y), (wide, deep), turn), height, look, f"{kind} {number}")


def _round(edge: Edge, s: float, rng: np.random.Generator, number: int) -> Cylinder:
    tone, seed = CLAY[int(rng.integers(len(CLAY)))], int(rng.integers(3))
    x, y, _ = _beside(edge, s, 0.26)
    if rng.random() < 0.6:
        return Cylinder(x, y, 0.22, 1.2 + 0.3 * (seed % 3), Look(tone, "leaves", seed), f"plant {number}")
    return Cylinder(x, y, 0.18, 0.5, Look(PAINT[seed % len(PAINT)], "plaster", seed), f"bin {number}")
