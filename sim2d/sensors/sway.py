"""A body that sways: it leans when it speeds up or takes a bend, and where the floor is uneven."""

from __future__ import annotations

import math

import numpy as np

from sim2d.config import SwayConfig
from sim2d.sensors.field import Field


class Sway:
    """Tells the lean at a place and speed; the floor's bumps are drawn once and stay where they are."""

    def __init__(self, config: SwayConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._bumps = tuple(Field(rng, config.bump_length) for _ in range(2))
        self._speed = 0.0

    @property
    def moves(self) -> bool:
        """Whether there is anything to lean by."""
        return self._config.per_acceleration_deg > 0 or self._config.bumps_deg > 0

    def lean(self, x: float, y: float, speed: float, turn_rate: float, dt: float) -> tuple[float, float]:
        """Return roll (to the right) and pitch (forward) [rad] at a place [m], speed [m/s], turn rate [rad/s].

        Called once a step of dt [s]: speeding up leans it back, a bend to the left leans it to the right.
        """
        ahead = (speed - self._speed) / dt if dt > 0 else 0.0
        self._speed = speed
        soft = math.radians(self._config.per_acceleration_deg)
        rough = math.radians(self._config.bumps_deg)
        roll, pitch = (rough * bumps.at(x, y) for bumps in self._bumps)
        return roll + soft * speed * turn_rate, pitch - soft * ahead
