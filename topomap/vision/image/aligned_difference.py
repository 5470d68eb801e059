"""The difference of two views once the rotation between them is known."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import ARRIVAL, SignatureSpec, signature


def aligned_difference(current: Panorama, goal: Panorama, rotation: float, spec: SignatureSpec = ARRIVAL) -> float:
    """Return the rms difference of two views after the current one is rolled by `rotation` [rad].

    The roll is exact to fractions of a column (a phase shift of the spectrum). 0 same, about 1.4 unrelated.
    """
    a, b = signature(current, spec), signature(goal, spec)
    rows, columns = a.pixels.shape
    frequency = np.arange(a.spectrum.shape[1])
    weights = np.where((frequency == 0) | (2 * frequency == columns), 1.0, 2.0)
    phase = np.exp(-1j * frequency * (rotation % TAU)) * weights
    overlap = float(np.real(a.spectrum * np.conj(b.spectrum) * phase).sum()) / (rows * columns**2)
    power = float(np.square(a.pixels).mean() + np.square(b.pixels).mean())
    return math.sqrt(max(power - 2.0 * overlap, 0.0))
