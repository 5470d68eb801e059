"""A world's light at an hour of the day: which lamps and windows there are, and how bright they make every place."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim2d.render.hours import LAMP_COLOUR, lamp_level, sky_colour, sky_level, sun
from sim2d.render.lights import Glow, add_light, add_sun, even
from sim2d.render.scene import Scene
from sim2d.shapes import Colour, Light, Point, Spec, Wall

CELL, CELLS = 0.25, 250_000  # [m], at most so many
LEAST = 0.3  # what reaches every corner by way of walls and ceiling
PIECE = 0.8  # [m] a window lights like a lamp in the middle of each piece of it


@dataclass(frozen=True, slots=True)
class Daylight:
    """Brightness of every place, the gain that makes 1 of it, and the mean colour of the light (r, g, b)."""

    glow: Glow
    gain: float = 1.0
    tint: Colour = (1.0, 1.0, 1.0)


EVEN = Daylight(even())


def daylight_at(spec: Spec, scene: Scene, hour: float) -> Daylight:
    """Return the light in a world at an hour, from its own lights or else its ceiling's lamps and its windows."""
    low = scene.origin
    size = scene.cells * scene.cell
    cell = max(CELL, math.sqrt(float(size[0] * size[1]) / CELLS))
    shape = (*(np.ceil(size[::-1] / cell).astype(int) + 1), 4)
    lights = spec.lights or (*_lamps(spec, scene), *_windows(spec))
    lamps, sky = np.zeros(shape), np.zeros(shape)
    for light in lights:
        _add(lamps if light.kind == "lamp" else sky, scene, low, cell, light)
    inside = lamps[..., 0][lamps[..., 0] > 1e-3] if lamps.any() else sky[..., 0][sky[..., 0] > 1e-3]
    scale = 0.85 / float(np.median(inside)) if len(inside) else 1.0
    lamps *= scale * lamp_level(hour)
    sky *= scale * sky_level(hour)
    tint = _tint(lamps, sky, hour)
    field = lamps + sky
    field[..., :2] += LEAST * max(lamp_level(hour) if lamps.any() else 0.0, sky_level(hour) if sky.any() else 0.0, 0.15)
    _add_sun(field, scene, low, cell, lights, hour)
    # twice as bright as usual is still told apart
    glow = Glow(True, (0.5 * field).astype(np.float32), float(low[0]), float(low[1]), cell)
    return Daylight(glow, 2.0, tint)


def _add(field: NDArray[np.float64], scene: Scene, low: NDArray[np.float64], cell: float, light: Light) -> None:
    """Add a lamp, or a window piece by piece."""
    strength = light.strength * sum(light.colour) / 3
    if light.kind == "lamp":
        add_light(field, scene, low[0], low[1], cell, light.x, light.y, light.z, strength, 0.0, 0.0)
        return
    length = math.dist(light.a, light.b)
    pieces = max(1, round(length / PIECE))
    nx, ny = (light.b[1] - light.a[1]) / length, (light.a[0] - light.b[0]) / length
    for k in range(pieces):
        share = (k + 0.5) / pieces
        x, y = (a + share * (b - a) for a, b in zip(light.a, light.b, strict=True))
        bright = 2.0 * strength * length / pieces * (light.top - light.sill)
        add_light(field, scene, low[0], low[1], cell, x, y, 0.5 * (light.sill + light.top), bright, nx, ny)


def _add_sun(
    field: NDArray[np.float64],
    scene: Scene,
    low: NDArray[np.float64],
    cell: float,
    lights: tuple[Light, ...],
    hour: float,
) -> None:
    """Add the sun's patches behind the windows."""
    azimuth, height = sun(hour)
    if height > 0:
        for light in lights:
            if light.kind == "window":
                frame = np.array([*light.a, *light.b, light.sill, light.top])
                add_sun(field, scene, low[0], low[1], cell, frame, azimuth, math.tan(height), sky_level(hour))


def _tint(lamps: NDArray[np.float64], sky: NDArray[np.float64], hour: float) -> Colour:
    """Return the mean colour of the light, half of it corrected by the camera's white balance."""
    a, b = float(lamps[..., 0].sum()), float(sky[..., 0].sum())
    share = b / (a + b) if a + b > 0 else 0.0
    mixed = [(1 - share) * lamp + share * day for lamp, day in zip(LAMP_COLOUR, sky_colour(hour), strict=True)]
    r, g, b = (math.sqrt(c / max(mixed)) for c in mixed)
    return r, g, b


def _lamps(spec: Spec, scene: Scene) -> list[Light]:
    """Return the lamps that hang under the ceiling, within the world's bounds."""
    step, first = spec.ceiling.lamps, spec.ceiling.first_lamp
    if step <= 0:
        return []
    low, high = scene.origin, scene.origin + scene.cells * scene.cell
    xs, ys = (first + step * np.arange(math.ceil((low[k] - first) / step), (high[k] - first) / step) for k in (0, 1))
    return [Light(float(x), float(y), spec.ceiling_height) for x in xs for y in ys]


def _windows(spec: Spec) -> list[Light]:
    """Return a light for every window on a straight wall."""
    out = []
    for wall in spec.walls:
        for decal in wall.look.decals:
            if decal.kind == "window" and len(wall.points) == 2:
                a, b = _on(wall, decal.start), _on(wall, decal.start + decal.length)
                z = 0.5 * (decal.base + decal.top)
                x, y = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
                out.append(Light(x, y, z, 1.0, kind="window", a=a, b=b, sill=decal.base, top=decal.top))
    return out


def _on(wall: Wall, along: float) -> Point:
    (ax, ay), (bx, by) = wall.points[0], wall.points[1]
    share = along / math.dist(wall.points[0], wall.points[1])
    return ax + share * (bx - ax), ay + share * (by - ay)
