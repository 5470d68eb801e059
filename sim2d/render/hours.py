"""The day outside and inside by the hour: how bright the sky and the lamps are, and where the sun stands."""

from __future__ import annotations

import math

import numpy as np

from sim2d.shapes import Colour

_SKY = ((0, 5, 6, 8, 12, 14, 18, 20, 21.5, 24), (0.0, 0.02, 0.3, 0.75, 1.0, 1.0, 0.7, 0.12, 0.01, 0.0))
_LAMPS = ((0, 6, 8, 12, 16, 18, 20, 24), (1.0, 0.6, 0.3, 0.25, 0.3, 0.6, 1.0, 1.0))
_SKY_COLOURS = (
    (0, 6, 9, 14, 18, 20, 24),
    (0.6, 1.0, 1.0, 0.98, 1.0, 0.75, 0.6),
    (0.7, 0.85, 0.98, 1.0, 0.94, 0.8, 0.7),
)
LAMP_COLOUR: Colour = (1.0, 0.95, 0.86)
DAWN, DUSK, HIGHEST = 5.5, 20.5, math.radians(55)


def sky_level(hour: float) -> float:
    """Return how bright the sky is at an hour of the day, 1 in the afternoon."""
    return float(np.interp(hour % 24, *_SKY))


def lamp_level(hour: float) -> float:
    """Return how far the lamps are turned up, 1 at night."""
    return float(np.interp(hour % 24, *_LAMPS))


def sky_colour(hour: float) -> Colour:
    """Return the colour of the light from outside."""
    hours, red, green = _SKY_COLOURS
    blue = 0.7 if hour % 24 < 7 else 1.0
    return float(np.interp(hour % 24, hours, red)), float(np.interp(hour % 24, hours, green)), blue


def sun(hour: float) -> tuple[float, float]:
    """Return where the sun stands [rad]: direction on the plan (east is x, north is y) and height, 0 at night."""
    share = (hour % 24 - DAWN) / (DUSK - DAWN)
    return -math.pi * share, max(0.0, HIGHEST * math.sin(math.pi * share)) if 0 < share < 1 else 0.0
