"""From a wished bearing to wheel commands, sliding along what the ranges show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.records import Command
from topomap.navigation.way_round import way_round

GAIN = 1.6
"""[1/s] Turn rate per bearing error: at steps of 0.25 s the error shrinks by 40 % a step, without swinging over."""
MARGIN = 0.06
"""[m] Free space wanted beside the body: six sigmas of a range of 1 cm noise."""
LOOK_AHEAD = 0.5
"""[m] A direction is free when nothing stands nearer than this: a second's way at 0.4 m/s and a little more."""


class PilotSettings(BaseModel, frozen=True, extra="forbid"):
    """How the robot is steered."""

    speed: float = Field(0.4, gt=0, le=5, description="forward speed limit [m/s]")
    turn_rate: float = Field(0.8, gt=0, le=6, description="turn rate limit [rad/s]")
    body_radius: float = Field(0.2, gt=0, description="radius that must stay free [m]")


class Pilot:
    """Turns a bearing into a command: nearest free direction to the wished one, slow in turns."""

    def __init__(self, settings: PilotSettings, directions: int = 72) -> None:
        self._settings = settings
        self._directions = wrap_all(np.arange(directions) * TAU / directions)

    @property
    def body_radius(self) -> float:
        """Radius that must stay free [m]."""
        return self._settings.body_radius

    def steer(
        self,
        bearing: float,
        ranges: Float32Array | None,
        speed: float | None = None,
        aims: Sequence[tuple[float, float]] = (),
    ) -> Command:
        """Return the command that drives towards `bearing` [rad], at most `speed` [m/s]; ranges (W,) or None.

        aims: points (x ahead, y left) [m] to get to, the nearest first, round what stands on the straight way.
        """
        s = self._settings
        free = bearing if ranges is None else self._free(bearing, ranges, aims)
        turn = float(np.clip(GAIN * free, -s.turn_rate, s.turn_rate))
        ahead = max(0.0, np.cos(free)) ** 2 if abs(free) < 1.2 else 0.0
        return Command(float(min(s.speed, s.speed if speed is None else speed) * ahead), turn)

    def _free(self, bearing: float, ranges: Float32Array, aims: Sequence[tuple[float, float]]) -> float:
        """Return the bearing where the way is free, else that of a way round, else the nearest free one."""
        if float(self._room(np.array([bearing]), ranges)[0]) >= LOOK_AHEAD:
            return bearing
        around = way_round(aims, ranges, self._settings.body_radius + MARGIN) if aims else None
        return self._nearest_free(bearing, ranges) if around is None else around

    def _nearest_free(self, bearing: float, ranges: Float32Array) -> float:
        room = np.minimum(self._room(self._directions, ranges), LOOK_AHEAD)
        detour = np.abs(wrap_all(self._directions - bearing))
        return wrap(float(self._directions[np.argmin(detour + 8.0 * (LOOK_AHEAD - room))]))

    def _room(self, directions: FloatArray, ranges: Float32Array) -> FloatArray:
        """Return how far the body can move along each direction (D,) before it comes too near to a range reading."""
        near = np.flatnonzero(ranges < LOOK_AHEAD + 2 * self._settings.body_radius)
        reach = np.full(len(directions), np.inf)
        if not len(near):
            return reach
        angle = near * TAU / len(ranges) - directions[:, None]
        along, aside = ranges[near] * np.cos(angle), np.abs(ranges[near] * np.sin(angle))
        # what already touches the margin blocks only the ways that lead nearer to it
        clear = self._settings.body_radius + MARGIN
        hit = (aside < clear) & (along > 0)
        touch = along - np.sqrt(np.maximum(clear**2 - aside**2, 0.0))
        nearest: FloatArray = np.where(hit, np.maximum(touch, 0.0), np.inf).min(axis=1)
        return nearest
