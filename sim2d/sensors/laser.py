"""The range scanner: distances all round, counter-clockwise from the nose."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim2d.config import LaserConfig
from sim2d.render.raycast import cast
from sim2d.world import World

Ranges = NDArray[np.float64]
URG_FIELD_DEG, URG_STEP_DEG, URG_RANGE = 240.0, 0.36, 4.0  # [degree, degree, m] the Hokuyo URG-04LX's data sheet


class Laser:
    """Measures to the first surface that is high enough; `rng` feeds its noise only.

    The ring measures along every bearing at once. The thesis's scanner takes two opposite shots of 240 degrees in steps
    of 0.36 degrees, nose first, which are then merged to as many ranges as asked for.
    """

    def __init__(self, config: LaserConfig, rng: np.random.Generator, columns: int = 720) -> None:
        """columns: of the camera beside it, as many as ranges where the configuration leaves that open."""
        self._config = config
        self._rng = rng
        rays = config.rays or columns
        self._bearings: Ranges = np.arange(rays, dtype=np.float64) * (math.tau / rays)
        half = int(math.radians(URG_FIELD_DEG) / 2 / math.radians(URG_STEP_DEG) + 1e-9)
        self._shot: Ranges = np.arange(-half, half + 1, dtype=np.float64) * math.radians(URG_STEP_DEG)
        self._range = config.max_range if config.scanner == "ring" else URG_RANGE

    def exact(self, world: World, x: float, y: float, heading: float) -> Ranges:
        """Return the true ranges (R,) [m] at a pose [m, rad], NaN beyond the greatest range."""
        return self._cast(world, x, y, self._bearings + heading)

    def scan(self, world: World, x: float, y: float, heading: float) -> NDArray[np.float32]:
        """Return measured ranges (R,) [m] at a pose [m, rad], NaN where nothing came back."""
        if self._config.scanner == "ring":
            ranges = self._measured(self.exact(world, x, y, heading))
        else:
            shots = [self._measured(self._cast(world, x, y, self._shot + heading + back)) for back in (0.0, math.pi)]
            ranges = self.merged(shots[0], shots[1])
        return ranges.astype(np.float32)

    def merged(self, front: Ranges, rear: Ranges) -> Ranges:
        """Return the ranges (R,) of two opposite shots (S,): the nearest ray of each, their mean where both measure."""
        both = np.stack([self._picked(front, 0.0), self._picked(rear, math.pi)])
        known = ~np.isnan(both)
        count = known.sum(axis=0)
        total = np.where(known, both, 0.0).sum(axis=0)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    def _picked(self, shot: Ranges, facing: float) -> Ranges:
        """Return for every bearing the nearest ray of a shot that faces so, NaN outside its field."""
        bearings = np.remainder(self._bearings - facing + math.pi, math.tau) - math.pi
        index = np.rint(bearings / math.radians(URG_STEP_DEG)).astype(int) + len(shot) // 2
        inside = (index >= 0) & (index < len(shot))
        return np.where(inside, shot[np.clip(index, 0, len(shot) - 1)], np.nan)

    def _cast(self, world: World, x: float, y: float, angles: Ranges) -> Ranges:
        ranges: Ranges = cast(world.scanned(), x, y, angles, self._range, self._config.height)
        return ranges

    def _measured(self, ranges: Ranges) -> Ranges:
        """Return ranges with noise and gaps."""
        ranges = ranges + self._rng.normal(0.0, self._config.noise, len(ranges))
        ranges[self._rng.random(len(ranges)) < self._config.dropout] = np.nan
        ranges[ranges > self._range] = np.nan
        return np.maximum(ranges, 0.0)
