"""A smooth random field: a value for every place (or way driven) that never changes within a run."""

from __future__ import annotations

import math

import numpy as np

WAVES = 48
"""So many plane waves: their sum is normal to within 2 % of its fourth moment."""


class Field:
    """A stationary random field of zero mean and unit variance over `dimensions`, smooth over `length` [m]."""

    def __init__(self, rng: np.random.Generator, length: float, dimensions: int = 2) -> None:
        # normal wave numbers make the correlation a Gaussian of the length
        self._waves = rng.normal(0.0, 1.0 / length, (WAVES, dimensions))
        self._phases = rng.uniform(0.0, math.tau, WAVES)

    def at(self, *place: float) -> float:
        """Return the value at a place (x, y) [m], or after a way [m] for one dimension."""
        return math.sqrt(2 / WAVES) * float(np.cos(self._waves @ np.array(place) + self._phases).sum())
