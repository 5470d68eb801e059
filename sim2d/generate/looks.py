"""A stock of wall pictures: generated worlds hang them again and again, so their texels are shared."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sim2d.generate.blocks import Edge
from sim2d.shapes import Colour, Decal, Look, Wall

TONES: tuple[tuple[Colour, str], ...] = (
    ((0.78, 0.76, 0.7), "plaster"),
    ((0.62, 0.7, 0.74), "plaster"),
    ((0.72, 0.64, 0.5), "panels"),
    ((0.66, 0.4, 0.3), "brick"),
    ((0.56, 0.66, 0.56), "plaster"),
    ((0.74, 0.74, 0.76), "concrete"),
)


class Stock:
    """Pictures for pieces of wall of `piece` [m]: for each tone a list, from which each piece gets one."""

    def __init__(self, looks: Sequence[Sequence[Look]], height: float, piece: float = 3.0) -> None:
        self._looks, self._height, self._piece = looks, height, piece

    def hang(self, edges: list[Edge], tones: list[int], rng: np.random.Generator) -> tuple[Wall, ...]:
        """Return the walls of edges, cut into pieces, each with a picture of its edge's tone."""
        out: list[Wall] = []
        for edge, tone in zip(edges, tones, strict=True):
            pieces = max(1, math.ceil(math.dist(edge.a, edge.b) / self._piece - 1e-6))
            x, y = (np.linspace(edge.a[k], edge.b[k], pieces + 1).round(6).tolist() for k in (0, 1))
            looks = self._looks[tone % len(self._looks)]
            for k in range(pieces):
                look = looks[int(rng.integers(len(looks)))]
                out.append(Wall(((x[k], y[k]), (x[k + 1], y[k + 1])), self._height, look, f"wall {len(out)}"))
        return tuple(out)


def mixed(rng: np.random.Generator, count: int, piece: float = 3.0) -> list[list[Look]]:
    """Return `count` pictures in each of the tones, the first of each bare."""
    return [[_picture(rng, tone, k, piece) for k in range(count)] for tone in range(len(TONES))]


def _picture(rng: np.random.Generator, tone: int, k: int, piece: float) -> Look:
    colour, texture = TONES[tone]
    shade = float(rng.uniform(0.85, 1.1))
    r, g, b = (min(1.0, shade * c) for c in colour)
    decals = _decals(rng, piece, 1000 * tone + k) if k else ()
    return Look((r, g, b), texture, 10 * tone + k % 3, decals, repeat=piece)


def _decals(rng: np.random.Generator, piece: float, seed: int) -> tuple[Decal, ...]:
    """Return one or two things on a piece of wall: half of them doors."""
    kinds = ("door", "door", "poster", "poster", "board", "window", "radiator", "extinguisher", "curtain")
    kind = kinds[int(rng.integers(len(kinds)))]
    length, base, top = {
        "door": (1.0, 0.0, 2.1), "poster": (0.9, 0.9, 2.0), "board": (1.5, 0.9, 2.0), "window": (1.5, 0.9, 2.1),
        "radiator": (1.3, 0.15, 0.8), "extinguisher": (0.4, 0.7, 1.7), "curtain": (1.4, 0.1, 2.3),
    }[kind]  # fmt: skip
    r, g, b = rng.uniform(0.1, 0.9, 3).tolist()
    start = float(rng.uniform(0.1, piece - length - 0.7))
    main = Decal(kind, start, length, base, top, (r, g, b), seed)
    if rng.random() < 0.5:
        return (main,)
    plate = Decal("poster", start + length + 0.15, 0.4, 1.3, 1.9, (b, r, g), seed + 500)
    return main, plate
