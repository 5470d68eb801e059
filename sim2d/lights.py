"""How bright every place is: lamps and windows, seen or hidden, summed over a grid once per hour of the day."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim2d.kernel import kernel

LEAST = 0.22  # what reaches every corner by way of walls and ceiling, of all the light there is


class Glow(NamedTuple):
    """Brightness over a grid: field (ny, nx, 4): of the floor, of an upright surface on average, and how much more it
    gets facing x and y; origin x, y [m], cell [m]. Where it isn't lit, all places are alike."""

    lit: bool
    field: NDArray[np.float32]
    x: float
    y: float
    cell: float


def even() -> Glow:
    """Return the light that is the same everywhere."""
    return Glow(False, np.ones((2, 2, 4), np.float32), 0.0, 0.0, 1.0)


@kernel
def _sample(glow: Glow, x: float, y: float, layer: int) -> float:
    """Return a layer of the field at x, y [m], interpolated, held at its edges."""
    ny, nx = glow.field.shape[:2]
    u = min(max((x - glow.x) / glow.cell - 0.5, 0.0), nx - 1.001)
    v = min(max((y - glow.y) / glow.cell - 0.5, 0.0), ny - 1.001)
    i, j = int(u), int(v)
    fu, fv = u - i, v - j
    low = (1 - fu) * glow.field[j, i, layer] + fu * glow.field[j, i + 1, layer]
    high = (1 - fu) * glow.field[j + 1, i, layer] + fu * glow.field[j + 1, i + 1, layer]
    return float((1 - fv) * low + fv * high)


@kernel
def glow_at(glow: Glow, x: float, y: float, layer: int) -> float:
    """Return the brightness, at most 1, of the floor (layer 0) or the ceiling (1) at x, y [m]."""
    return min(1.0, _sample(glow, x, y, layer))


@kernel
def glow_on(glow: Glow, x: float, y: float, nx: float, ny: float, dx: float, dy: float) -> float:
    """Return the brightness, at most 1, of an upright surface with normal n at x, y [m], seen along d."""
    if nx * dx + ny * dy > 0:
        nx, ny = -nx, -ny
    # taken a little before the surface: the cells behind it are lit from another room
    px, py = x + 0.6 * glow.cell * nx, y + 0.6 * glow.cell * ny
    bright = _sample(glow, px, py, 1) + nx * _sample(glow, px, py, 2) + ny * _sample(glow, px, py, 3)
    return min(1.0, max(0.1, bright))
