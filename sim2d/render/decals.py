"""Flat things on walls: each painter returns the canvas of one decal from its size, colour and generator."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sim2d.render.canvas import TEXELS, Canvas, blank, clouds, disc, hue, rectangle, shade
from sim2d.render.paint import Painter
from sim2d.shapes import Colour


def door(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A door leaf in its frame, with a handle and a plate."""
    canvas = blank(length, height, shade(colour, 0.55))
    rectangle(canvas, (0.07, length - 0.07), (0, height - 0.07), colour)
    rectangle(canvas, (0.2, length - 0.2), (0.25, 0.45 * height), shade(colour, 0.85))
    rectangle(canvas, (0.2, length - 0.2), (0.55 * height, height - 0.3), shade(colour, 0.85))
    rectangle(canvas, (length - 0.22, length - 0.12), (0.98, 1.04), (0.1, 0.1, 0.1))
    return canvas


def poster(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A poster of large random shapes in a light margin."""
    canvas = blank(length, height, (0.92, 0.91, 0.88))
    rectangle(canvas, (0.04, length - 0.04), (0.04, height - 0.04), colour)
    for _ in range(5):
        x, z = rng.uniform(0.1, 0.8) * length, rng.uniform(0.1, 0.8) * height
        if rng.random() < 0.5:
            disc(canvas, float(x), float(z), float(rng.uniform(0.1, 0.25)) * min(length, height), hue(rng, 0, 1))
        else:
            w, h = rng.uniform(0.1, 0.5) * length, rng.uniform(0.05, 0.3) * height
            rectangle(canvas, (float(x), float(min(length - 0.05, x + w))), (float(z), float(z + h)), hue(rng, 0, 1))
    return canvas


def window(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A window: bright sky over far trees, frame and cross bars of the given colour."""
    canvas = blank(length, height, (0.78, 0.88, 1.0))
    sky = np.linspace(1.0, 0.88, canvas.shape[0], dtype=np.float32)[:, None, None]
    canvas *= sky + 0.06 * clouds(rng, canvas, 0.5)
    trees = 0.25 * height * (1 + 0.5 * clouds(rng, canvas, 0.35)[0, :, 0])
    heights = (canvas.shape[0] - np.arange(canvas.shape[0])[:, None]) / TEXELS
    canvas[heights < trees[None, :]] = np.asarray((0.3, 0.42, 0.25), dtype=np.float32)
    panes = max(1, round(length / 0.8))
    for k in range(panes + 1):
        x = k * (length - 0.06) / panes
        rectangle(canvas, (x, x + 0.06), (0, height), colour)
    for z in (0.0, 0.65 * height, height - 0.06):
        rectangle(canvas, (0, length), (z, z + 0.06), colour)
    return canvas


def board(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A writing board with a few lines of script and a frame."""
    canvas = blank(length, height, (0.45, 0.45, 0.45))
    rectangle(canvas, (0.05, length - 0.05), (0.05, height - 0.05), colour)
    ink = (0.9, 0.9, 0.85) if sum(colour) < 1.5 else (0.1, 0.15, 0.5)
    for z in np.arange(0.2, height - 0.15, 0.16):
        x = float(rng.uniform(0.1, 0.4))
        while x < length * float(rng.uniform(0.6, 0.9)):
            word = float(rng.uniform(0.06, 0.3))
            rectangle(canvas, (x, min(x + word, length - 0.1)), (float(z), float(z) + 0.06), ink)
            x += word + 0.06
    return canvas


def aircon(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """An air conditioner: a pale case with dark slats."""
    canvas = blank(length, height, (0.93, 0.93, 0.9))
    for z in np.arange(0.05, 0.5 * height, 0.06):
        rectangle(canvas, (0.08, length - 0.08), (float(z), float(z) + 0.03), (0.25, 0.25, 0.27))
    rectangle(canvas, (length - 0.2, length - 0.1), (0.7 * height, 0.8 * height), (0.1, 0.7, 0.2))
    return canvas


def radiator(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A radiator: upright ribs."""
    canvas = blank(length, height, colour)
    for x in np.arange(0.04, length, 0.1):
        rectangle(canvas, (float(x), float(x) + 0.04), (0.04, height - 0.04), shade(colour, 0.5))
    return canvas


def extinguisher(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A fire extinguisher on a white backing, with its sign."""
    canvas = blank(length, height, (0.9, 0.9, 0.9))
    rectangle(canvas, (0.25 * length, 0.75 * length), (0.05, 0.55 * height), (0.8, 0.05, 0.05))
    rectangle(canvas, (0.4 * length, 0.6 * length), (0.55 * height, 0.62 * height), (0.1, 0.1, 0.1))
    rectangle(canvas, (0.15 * length, 0.85 * length), (0.7 * height, 0.95 * height), (0.8, 0.1, 0.1))
    return canvas


def curtain(length: float, height: float, colour: Colour, rng: np.random.Generator) -> Canvas:
    """A curtain with folds."""
    canvas = blank(length, height, colour)
    folds = np.sin(np.arange(canvas.shape[1]) / TEXELS * 40 + 2 * clouds(rng, canvas, 0.5)[0, :, 0])
    canvas *= (1 + 0.3 * folds.astype(np.float32))[None, :, None]
    return canvas


DECALS: Mapping[str, Painter] = {
    "door": door,
    "poster": poster,
    "window": window,
    "board": board,
    "aircon": aircon,
    "radiator": radiator,
    "extinguisher": extinguisher,
    "curtain": curtain,
}
