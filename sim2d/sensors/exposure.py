"""The camera's automatic exposure and white balance, which follow the view with a lag."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim2d.config import CameraConfig
from sim2d.shapes import Colour

TARGET = 110.0  # [grey levels] mean that automatic exposure aims at: a little under the middle of 0..255
GAINS = (0.05, 8.0)
BALANCE = (0.5, 2.0)  # how far a channel is lowered or raised: a lamp of 2700 K asks for 1.9 in blue


class Exposure:
    """Gain and white balance: set at once by the first view, later on the way to what the view asks for."""

    def __init__(self, config: CameraConfig) -> None:
        self._config = config
        self._state: NDArray[np.float64] | None = None  # logarithms of gain, red, green, blue

    @property
    def looks(self) -> bool:
        """Whether a look at the view is needed at all."""
        return self._config.exposure == "auto" or self._config.white_balance == "auto"

    def asked(self, probe: NDArray[np.uint8], light: float) -> tuple[float, Colour]:
        """Return the gain and the channel gains that a probe picture (H, W, 3), taken with `light` of gain 1, asks."""
        means = np.maximum(probe.reshape(-1, 3).mean(axis=0), 0.5)
        grey = float(means.mean())
        gain = min(max(light * TARGET / grey, GAINS[0]), GAINS[1]) if self._config.exposure == "auto" else 1.0
        if self._config.white_balance != "auto":
            return gain, (1.0, 1.0, 1.0)
        r, g, b = np.clip(grey / means, *BALANCE)
        return gain, (float(r), float(g), float(b))

    def follow(self, gain: float, balance: Colour, dt: float) -> tuple[float, Colour]:
        """Return the gain and channel gains in force dt [s] after the last call."""
        wanted = np.log([gain, *balance])
        lag = self._config.exposure_lag
        if self._state is None or lag <= 0:
            self._state = wanted
        else:
            self._state = self._state + (1.0 - math.exp(-dt / lag)) * (wanted - self._state)
        out, r, g, b = np.exp(self._state).tolist()
        return out, (r, g, b)
