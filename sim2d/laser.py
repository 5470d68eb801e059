"""The range scanner: distances all round, counter-clockwise from the nose."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim2d.config import LaserConfig
from sim2d.raycast import cast
from sim2d.world import World


class Laser:
    """Measures to the first surface of any height; `rng` feeds its noise only."""

    def __init__(self, config: LaserConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._rng = rng
        self._bearings = np.arange(config.rays) * (math.tau / config.rays)

    def exact(self, world: World, x: float, y: float, heading: float) -> NDArray[np.float64]:
        """Return the true ranges (R,) [m] at a pose [m, rad], NaN beyond the greatest range."""
        ranges: NDArray[np.float64] = cast(world.scene(), x, y, self._bearings + heading, self._config.max_range)
        return ranges

    def scan(self, world: World, x: float, y: float, heading: float) -> NDArray[np.float32]:
        """Return measured ranges (R,) [m] at a pose [m, rad], NaN where nothing came back."""
        ranges = self.exact(world, x, y, heading)
        ranges += self._rng.normal(0.0, self._config.noise, len(ranges))
        ranges[self._rng.random(len(ranges)) < self._config.dropout] = np.nan
        ranges[ranges > self._config.max_range] = np.nan
        return np.maximum(ranges, 0.0).astype(np.float32)
