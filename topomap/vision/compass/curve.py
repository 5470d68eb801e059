"""The least value of a curve over rotations, to a fraction of its step."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.records import Alignment
from topomap.vision.image.compare import parabola


def least(curve: FloatArray, prior: float | None, window: float) -> Alignment:
    """Return the rotation [rad] where a curve (N,) over rotations 0 .. 2 pi is least, within prior +- window."""
    count = len(curve)
    allowed = curve if prior is None else np.where(_near(count, prior, window), curve, np.inf)
    k = int(allowed.argmin())
    around = curve[[(k - 1) % count, k, (k + 1) % count]]
    offset, low = parabola(*around[:, np.newaxis])
    return Alignment(wrap((k + float(offset[0])) * TAU / count), float(low[0]))


def _near(count: int, prior: float, window: float) -> BoolArray:
    angles = np.arange(count, dtype=np.float64) * (TAU / count) - prior
    return np.asarray(np.abs(wrap_all(angles)) <= max(window, TAU / count), np.bool_)
