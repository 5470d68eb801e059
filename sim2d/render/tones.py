"""The camera's tone curves: what a weighted colour becomes as a byte."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim2d.render.texel import TONES
from sim2d.shapes import Colour


def tone_curves(gain: float = 1.0, tint: Colour = (1.0, 1.0, 1.0)) -> NDArray[np.uint8]:
    """Return the curves of red, green and blue one after the other, (3 x 4096,): linear, cut at white."""
    grey = (np.arange(TONES) + 0.5) / 8
    curves = [np.clip(grey * gain * channel + 0.5, 0, 255).astype(np.uint8) for channel in tint]
    return np.concatenate(curves)
