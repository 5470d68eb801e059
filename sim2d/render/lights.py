"""How bright every place is: lamps and windows, seen or hidden, summed over a grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim2d.render.kernel import kernel
from sim2d.render.raycast import FloatArray, nearest
from sim2d.render.scene import Scene

REACH = 14.0  # [m] no light is seen to light anything beyond
SCREEN = 1.5  # [m] lower things cast no shadow


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


@kernel
def add_light(
    field: FloatArray, scene: Scene, x0: float, y0: float, cell: float,
    x: float, y: float, z: float, strength: float, nx: float, ny: float,
) -> None:  # fmt: skip
    """Add a light at x, y, z [m] to a field (ny, nx, 4) as in Glow, where it is seen; n: a window's normal or 0."""
    i0, i1 = max(0, int((x - REACH - x0) / cell)), min(field.shape[1], int((x + REACH - x0) / cell) + 1)
    j0, j1 = max(0, int((y - REACH - y0) / cell)), min(field.shape[0], int((y + REACH - y0) / cell) + 1)
    for j in range(j0, j1):
        for i in range(i0, i1):
            px, py = x0 + (i + 0.5) * cell, y0 + (j + 0.5) * cell
            far = np.hypot(x - px, y - py) + 1e-6
            dx, dy = (x - px) / far, (y - py) / far
            if far > REACH or nearest(scene, px, py, dx, dy, far - 0.05, SCREEN) < np.inf:
                continue
            r = np.hypot(far, z)
            facing = abs(nx * dx + ny * dy) if nx != 0.0 or ny != 0.0 else 1.0
            bright = strength * facing / (1 + r * r / 6)
            # of max(0, n . d) over all normals n the mean is 1/pi; half of n . d is what differs from it
            field[j, i, 0] += bright * max(z, 0.3) / r
            field[j, i, 1] += bright * (0.15 + 0.32 * far / r)
            field[j, i, 2] += 0.5 * bright * dx * far / r
            field[j, i, 3] += 0.5 * bright * dy * far / r


@kernel
def add_sun(
    field: FloatArray, scene: Scene, x0: float, y0: float, cell: float, frame: FloatArray,
    azimuth: float, rise: float, strength: float,
) -> None:  # fmt: skip
    """Add the sun through a window `frame`: ax, ay, bx, by, sill, top [m]; rise: tangent of the sun's height."""
    dx, dy = np.cos(azimuth), np.sin(azimuth)
    ex, ey = frame[2] - frame[0], frame[3] - frame[1]
    cross = dx * ey - dy * ex
    if abs(cross) < 1e-9:
        return
    for j in range(field.shape[0]):
        for i in range(field.shape[1]):
            px, py = frame[0] - (x0 + (i + 0.5) * cell), frame[1] - (y0 + (j + 0.5) * cell)
            t, u = (px * ey - py * ex) / cross, (px * dy - py * dx) / cross
            if t < 0.0 or u < 0.0 or u > 1.0 or not frame[4] <= t * rise <= frame[5]:
                continue
            if nearest(scene, x0 + (i + 0.5) * cell, y0 + (j + 0.5) * cell, dx, dy, t - 0.05, 0.5) == np.inf:
                field[j, i, 0] += 1.2 * strength
                field[j, i, 1] += 0.25 * strength
