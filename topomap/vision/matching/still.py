"""What stood still between two views: a step pushes everything away from the point it leads to."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import wrap_all

BACK = math.radians(3.0)
"""A bearing that moves towards the diffusion point by more than this [rad] moved by itself, or is a wrong match."""
LEAST = 0.5
"""Less than this share of the matches tells no movement: then all of them count."""


def still(there: FloatArray, here: FloatArray, home: float) -> BoolArray:
    """Return which of the matched goal and current bearings (M,) [rad] may belong to things that stood still.

    home [rad]: a first answer; the step goal -> current led the other way, and a thing at bearing t moves by an angle
    of the sign of sin(t - b), whatever its distance.
    """
    ahead = home + math.pi
    moved = wrap_all(here - there) * np.sign(np.sin(there - ahead))
    kept: BoolArray = moved > -BACK
    return kept if kept.mean() >= LEAST else np.ones(len(there), np.bool_)
