"""How much a view's likeness to a place speaks for being there: a likelihood ratio, measured against the map itself."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray

THERE, SPREAD = 0.25, 0.17
"""Likeness (difference over the median difference to the map's places, predicted views among them) of the best view
over a metre driven up to 0.3 m beside the taught route, and its spread: 0.08 to 0.24 in `office-loop`, `room-corridor`
and `hall`, and more where something stands there that didn't."""
CHANGED = 0.08
"""Share of places that don't look as they did: somebody stands there, or a door has been closed."""
WIDEST = 1.5
"""Likeness is at most about this: views that have nothing in common differ by 1.4, a map's median by 0.9 or more."""
BANDWIDTH = 0.08
"""Width over which the map's own likenesses are smoothed: half the spread at the place itself."""
BY_CHANCE = 0.03
"""Share of likenesses that the sample of the map doesn't tell."""
AGAINST, FOR = -3.0, 5.0
"""Bounds of one metre's log likelihood ratio: the errors of neighbouring views hang together, and one may be hidden."""


def log_ratio(likeness: FloatArray, others: FloatArray) -> FloatArray:
    """Return (n,) log of how much likelier views of such likeness are at the place than anywhere on the map.

    likeness (n,): differences over `usual`; others (m,): those of a sample of the map's places. Where half the map
    looks like this, looking like this says little; what is less like it than half the map says no more than that.
    """
    likeness = np.minimum(likeness, 1.0)
    there = (1 - CHANGED) * _normal((likeness - THERE) / SPREAD) / SPREAD + CHANGED / WIDEST
    # nearer than usual is no less like it
    there = np.where(likeness < THERE, (1 - CHANGED) * _normal(np.zeros(1)) / SPREAD + CHANGED / WIDEST, there)
    away = _normal((likeness[:, None] - others[None, :]) / BANDWIDTH).mean(axis=1) / BANDWIDTH
    elsewhere = (1 - BY_CHANCE) * away + BY_CHANCE / WIDEST
    ratio: FloatArray = np.clip(np.log(there / elsewhere), AGAINST, FOR)
    return ratio


def _normal(x: FloatArray) -> FloatArray:
    density: FloatArray = np.exp(-0.5 * np.square(x)) / np.sqrt(2 * np.pi)
    return density
