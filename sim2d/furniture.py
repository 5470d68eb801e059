"""Furniture by kind: how high it is and how it looks."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sim2d.shapes import Box, Colour, Look, Point

# kind: height [m], texture, colour
KINDS: Mapping[str, tuple[float, str, Colour]] = {
    "bed": (0.55, "plaster", (0.7, 0.72, 0.8)),
    "bench": (0.45, "wood", (0.6, 0.45, 0.3)),
    "bookcase": (2.0, "books", (0.5, 0.33, 0.2)),
    "cabinet": (1.3, "drawers", (0.62, 0.64, 0.66)),
    "chair": (0.85, "wood", (0.3, 0.32, 0.36)),
    "counter": (1.1, "panels", (0.6, 0.5, 0.38)),
    "crate": (0.45, "wood", (0.75, 0.6, 0.25)),
    "cupboard": (1.8, "drawers", (0.65, 0.67, 0.7)),
    "desk": (0.74, "wood", (0.72, 0.58, 0.4)),
    "drawers": (0.9, "drawers", (0.8, 0.7, 0.55)),
    "dresser": (1.15, "drawers", (0.5, 0.3, 0.18)),
    "locker": (1.9, "panels", (0.35, 0.5, 0.62)),
    "machine": (1.85, "books", (0.75, 0.2, 0.2)),
    "monitor": (1.2, "plaster", (0.12, 0.14, 0.2)),
    "partition": (1.6, "panels", (0.5, 0.55, 0.66)),
    "screen": (1.7, "panels", (0.78, 0.6, 0.42)),
    "shelf": (1.2, "books", (0.45, 0.3, 0.2)),
    "sofa": (0.8, "plaster", (0.55, 0.22, 0.2)),
    "table": (0.75, "wood", (0.7, 0.55, 0.38)),
}


def turned_rectangle(at: Point, size: Point, turn: float = 0.0) -> tuple[Point, ...]:
    """Return the corners of a rectangle of size (w, d) [m] about its middle, turned by `turn` [rad]."""
    c, s = math.cos(turn), math.sin(turn)
    halves = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = [(0.5 * i * size[0], 0.5 * j * size[1]) for i, j in halves]
    return tuple((at[0] + c * x - s * y, at[1] + s * x + c * y) for x, y in corners)


def furniture(
    kind: str, at: Point, size: Point, seed: int, turn: float = 0.0, name: str = "", colour: Colour | None = None
) -> Box:
    """Return a piece of furniture of size (w, d) [m] about its middle, turned by `turn` [rad]."""
    height, texture, own = KINDS[kind]
    return Box(turned_rectangle(at, size, turn), height, Look(colour or own, texture, seed), name or kind)
