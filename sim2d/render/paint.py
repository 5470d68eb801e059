"""Procedural surfaces: each painter fills a canvas of a whole surface from its colour and generator."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from sim2d.render.canvas import TEXELS, Canvas, blank, clouds, disc, hue, rectangle, shade
from sim2d.shapes import Colour

Painter = Callable[[float, float, Colour, np.random.Generator], Canvas]


def plain(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """One colour."""
    return blank(length, height, colour)


def plaster(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Painted wall: stains of two sizes, brighter towards the top, a skirting board."""
    canvas = blank(length, height, colour)
    canvas *= 1 + 0.12 * clouds(rng, canvas, 1.6) + 0.05 * clouds(rng, canvas, 0.3)
    canvas *= np.linspace(1.08, 0.86, canvas.shape[0], dtype=np.float32)[:, None, None]
    rectangle(canvas, (0, length), (0, 0.1), shade(colour, 0.45))
    return canvas


def paper(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Wall in one tone with hardly a stain, over a skirting board: any stretch looks like any other."""
    canvas = blank(length, height, colour)
    canvas *= 1 + 0.02 * clouds(rng, canvas, 1.6)
    canvas *= np.linspace(1.08, 0.86, canvas.shape[0], dtype=np.float32)[:, None, None]
    rectangle(canvas, (0, length), (0, 0.1), shade(colour, 0.45))
    return canvas


def panels(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Panels about 1.2 m wide, each of its own shade, on a dark dado."""
    canvas = plaster(length, height, colour, rng)
    count = max(1, round(length / 1.2))
    width = length / count
    for k in range(count):
        tint = np.float32(1 + rng.uniform(-0.22, 0.22, 3))
        i = slice(round(k * width * TEXELS), round((k + 1) * width * TEXELS) - 1)
        canvas[:, i] *= tint
        rectangle(canvas, ((k + 1) * width - 0.03, (k + 1) * width), (0, height), shade(colour, 0.5))
    dado = canvas[-round(0.9 * TEXELS) :]
    dado *= np.float32(0.72)
    return canvas


def brick(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Courses of bricks, each of its own shade, with stains."""
    canvas = blank(length, height, (0.62, 0.6, 0.56))
    columns = max(1, round(length / 0.3))
    width = length / columns
    for row in range(int(height / 0.12) + 1):
        for k in range(columns):
            x = (k + 0.5 * (row % 2)) * width
            tone = shade(colour, float(rng.uniform(0.7, 1.2)))
            rectangle(canvas, (x, x + width - 0.02), (row * 0.12, row * 0.12 + 0.1), tone)
    canvas *= 1 + 0.15 * clouds(rng, canvas, 1.2)
    return canvas


def wood(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Boards with grain."""
    canvas = blank(length, height, colour)
    grain = np.repeat(rng.uniform(-1, 1, (1, canvas.shape[1], 1)), canvas.shape[0], axis=0).astype(np.float32)
    canvas *= 1 + 0.07 * grain + 0.1 * clouds(rng, canvas, 0.4)
    for x in np.arange(0.0, length, 0.6):
        rectangle(canvas, (float(x), float(x) + 0.02), (0, height), shade(colour, 0.5))
    return canvas


def marble(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Pale stone with dark veins."""
    canvas = blank(length, height, colour)
    field = clouds(rng, canvas, 0.5) + 0.5 * clouds(rng, canvas, 0.2)
    veins = np.exp(-np.square(np.sin(3 * field) * 4))
    canvas *= 1 - 0.3 * veins + 0.1 * clouds(rng, canvas, 1.0)
    return canvas


def concrete(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Cast concrete with bands of different colour, for pillars."""
    canvas = plaster(length, height, colour, rng)
    canvas *= 1 + 0.15 * clouds(rng, canvas, 0.25)
    low = float(rng.uniform(0.3, 0.6))
    rectangle(canvas, (0, length), (low, low + 0.25), hue(rng))
    rectangle(canvas, (0, length), (height - 0.5, height - 0.3), hue(rng))
    return canvas


def books(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A bookcase: shelves of spines in many colours."""
    canvas = blank(length, height, shade(colour, 0.35))
    shelf = height / max(1, round(height / 0.34))
    for z in np.arange(0.0, height - 0.1, shelf):
        x = 0.03
        while x < length - 0.05:
            width = float(rng.uniform(0.03, 0.09))
            if rng.random() > 0.12:
                tall = float(rng.uniform(0.6, 0.88)) * shelf
                rectangle(canvas, (x, x + width), (float(z) + 0.03, float(z) + tall), hue(rng))
            x += width
        rectangle(canvas, (0, length), (float(z), float(z) + 0.03), colour)
    rectangle(canvas, (0, length), (height - 0.03, height), colour)
    return canvas


def drawers(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A chest of drawers with handles."""
    canvas = wood(length, height, colour, rng)
    rows, columns = max(1, round(height / 0.25)), max(1, round(length / 0.5))
    for j in range(rows):
        z = (j + 1) * height / rows
        rectangle(canvas, (0, length), (z - 0.02, z), shade(colour, 0.4))
        for k in range(columns):
            x = (k + 0.5) * length / columns
            rectangle(canvas, (x - 0.07, x + 0.07), (z - 0.14, z - 0.1), (0.15, 0.15, 0.15))
    return canvas


def leaves(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A potted plant: leaves and flowers over a pot of the given colour."""
    canvas = blank(length, height, (0.16, 0.32, 0.12))
    for _ in range(int(140 * length * height) + 20):
        x, z = rng.uniform(0, length), rng.uniform(0.3 * height, height)
        tone = shade((0.3, 0.6, 0.2), float(rng.uniform(0.4, 1.3)))
        disc(canvas, x, z, float(rng.uniform(0.02, 0.06)), hue(rng, 0.4, 1) if rng.random() < 0.08 else tone)
    rectangle(canvas, (0, length), (0, 0.36 * height), colour)
    rectangle(canvas, (0, length), (0.32 * height, 0.36 * height), shade(colour, 0.7))
    return canvas


def speckle(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Terrazzo or carpet: coarse stains and fine speckles."""
    canvas = blank(length, height, colour)
    canvas *= 1 + 0.14 * clouds(rng, canvas, 1.3) + 0.1 * clouds(rng, canvas, 0.25)
    canvas *= 1 + 0.1 * rng.uniform(-1, 1, (*canvas.shape[:2], 1)).astype(np.float32)
    return canvas


def slabs(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Polished stone slabs 0.8 m wide with joints, each of its own shade."""
    canvas = marble(length, height, colour, rng)
    for x in np.arange(0.0, length - 0.1, 0.8):
        for z in np.arange(0.0, height - 0.1, 0.8):
            i, j = round(float(x) * TEXELS), round(float(z) * TEXELS)
            canvas[j : j + 40, i : i + 40] *= np.float32(rng.uniform(0.82, 1.15))
        rectangle(canvas, (float(x), float(x) + 0.02), (0, height), shade(colour, 0.5))
        rectangle(canvas, (0, length), (float(x), float(x) + 0.02), shade(colour, 0.5))
    return canvas


def person(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """Somebody all round, face in front at 0: legs, a coat of the given colour with arms, a head with hair."""
    canvas = blank(length, height, colour)
    skin, trousers, hair = (
        shade((0.95, 0.76, 0.62), float(rng.uniform(0.5, 1.05))),
        hue(rng, 0.05, 0.4),
        hue(rng, 0.05, 0.5),
    )
    rectangle(canvas, (0, length), (0, 0.46 * height), trousers)
    rectangle(canvas, (0, length), (0, 0.04 * height), shade(trousers, 0.4))
    for x in (0.25 * length, 0.75 * length):
        rectangle(canvas, (x - 0.06, x + 0.06), (0, 0.44 * height), shade(trousers, 0.55))
        rectangle(canvas, (x - 0.09, x + 0.09), (0.48 * height, 0.8 * height), shade(colour, 0.7))
        rectangle(canvas, (x - 0.06, x + 0.06), (0.43 * height, 0.48 * height), skin)
    canvas *= 1 + 0.1 * clouds(rng, canvas, 0.2)
    rectangle(canvas, (0, length), (0.84 * height, height), skin)
    rectangle(canvas, (0.2 * length, 0.8 * length), (0.86 * height, height), hair)
    rectangle(canvas, (0, length), (0.94 * height, height), hair)
    return canvas


PAINTERS: Mapping[str, Painter] = {
    "plain": plain,
    "plaster": plaster,
    "paper": paper,
    "panels": panels,
    "brick": brick,
    "wood": wood,
    "marble": marble,
    "concrete": concrete,
    "books": books,
    "drawers": drawers,
    "leaves": leaves,
    "person": person,
    "speckle": speckle,
    "slabs": slabs,
}
