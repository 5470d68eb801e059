"""The odometer: what the wheels say about the way, with errors that are drawn once and errors drawn every step."""

from __future__ import annotations

import math

import numpy as np

from sim2d.config import OdometerConfig
from sim2d.records import OdometerReading, TrueCalibration
from sim2d.sensors.field import Field

HALF_TRACK = 0.15  # [m] what the wheels roll per radian of turning on the spot
LOAD_LENGTH = 60.0  # [m] over which a load, a tyre's warmth or a slope comes and goes


class Odometer:
    """Reads arcs; `drift` draws the systematic errors once, `noise` the random ones, `slip` those in contact.

    changes: draws how the systematic errors vary with the floor, place by place, and with the load along the way.
    """

    def __init__(
        self,
        config: OdometerConfig,
        drift: np.random.Generator,
        noise: np.random.Generator,
        slip: np.random.Generator | None = None,
        changes: np.random.Generator | None = None,
    ) -> None:
        self._config = config
        self._driven = 0.0
        changes = np.random.default_rng(0) if changes is None else changes
        self._floor = Field(changes, config.floor_patch)
        self._loads = tuple(Field(changes, LOAD_LENGTH, 1) for _ in range(3))
        self._noise = noise
        self._slip = slip
        factor = drift.uniform(1 - config.spread, 1 + config.spread, 3)
        self.calibration = TrueCalibration(
            rotation_scale=1 + (config.rotation_scale - 1) * float(factor[0]),
            distance_scale=1 + (config.distance_scale - 1) * float(factor[1]),
            curvature=config.curvature * float(factor[2]),
        )

    def read(
        self,
        forward: float,
        turn: float,
        dt: float,
        blocked: float = 0.0,
        contact: bool = False,
        place: tuple[float, float] = (0.0, 0.0),
    ) -> OdometerReading:
        """Return the reading of a true arc: forward [m], turn [rad], taken in dt [s].

        blocked: what the wheels were told to drive beyond the true way [m]; contact: whether they may slip; place:
        where the floor is driven on (x, y) [m].
        """
        config = self._config
        truth = self._errors(forward, place)
        travel = abs(forward) + HALF_TRACK * abs(turn)
        sigma_forward = config.forward_noise * math.sqrt(travel)
        sigma_turn = math.radians(
            math.hypot(config.turn_noise_deg * math.sqrt(travel), config.turn_noise_per_rad_deg * math.sqrt(abs(turn)))
        )
        draws = self._noise.standard_normal(2)
        slipped, twist = (config.slip * blocked, self._twist()) if contact else (0.0, 0.0)
        rolled = forward + slipped
        return OdometerReading(
            forward=truth.distance_scale * rolled + sigma_forward * float(draws[0]),
            left=0.0,
            turn=truth.rotation_scale * turn + truth.curvature * rolled + sigma_turn * float(draws[1]) + twist,
            covariance=config.declared * _covariance(sigma_forward, sigma_turn),
            dt=dt,
        )

    def _errors(self, forward: float, place: tuple[float, float]) -> TrueCalibration:
        """Return the systematic errors on this floor, under the load of this part of the way."""
        mean, config = self.calibration, self._config
        self._driven += abs(forward)
        if not (config.floor or config.load):
            return mean
        rotation, distance, curvature = (1 + config.load * load.at(self._driven) for load in self._loads)
        floor = config.floor * self._floor.at(*place) if config.floor else 0.0
        return TrueCalibration(
            rotation_scale=1 + (mean.rotation_scale - 1) * rotation,
            distance_scale=(1 + (mean.distance_scale - 1) * distance) * (1 + floor),
            curvature=mean.curvature * curvature,
        )

    def _twist(self) -> float:
        """Return a turn that is read though it didn't happen [rad]."""
        return 0.0 if self._slip is None else math.radians(self._config.slip_turn_deg) * self._slip.standard_normal()


def joined(first: OdometerReading, second: OdometerReading) -> OdometerReading:
    """Return two increments as one: its arc is as long and turns as far as both together."""
    return OdometerReading(
        forward=first.forward + second.forward,
        left=first.left + second.left,
        turn=first.turn + second.turn,
        covariance=first.covariance + second.covariance,
        dt=first.dt + second.dt,
    )


def _covariance(sigma_forward: float, sigma_turn: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return (3, 3) of forward, left, turn; floors keep a standstill invertible."""
    sideways = 0.25 * sigma_forward
    return np.diag(np.square(np.maximum([sigma_forward, sideways, sigma_turn], [1e-4, 1e-4, 1e-5])))
