"""The driver: follows the designated route, sees the truth, and hands over at the end."""

from __future__ import annotations

import math

import numpy as np

from sim2d.body import MAX_TURN
from sim2d.config import BodyConfig, DriverConfig
from sim2d.path import SPACING, Path

LOOKAHEAD = 0.4  # [m] to the point that is steered at: a second's way
TURNED = 0.06  # [m] so near a point where the path turns back, the robot is there
WINDOW = 0.6  # [m] how far ahead on the path the robot may have got in one step
STEPS_TO_BRAKE = 2.0
STUCK_S = 120.0  # without any way made: people and doors of the shipped worlds block the route for 40 s at most


class Driver:
    """Steers at a point on the path ahead (pure pursuit); `progress` [m] only grows."""

    def __init__(self, path: Path, config: DriverConfig, body: BodyConfig) -> None:
        self.path = path
        self.progress = 0.0
        self._body = body
        self._seen, self._waited = 0.0, 0

    @property
    def laps(self) -> float:
        """Laps driven so far."""
        return self.progress / self.path.lap

    @property
    def done(self) -> bool:
        """Whether the route is driven."""
        return self.path.length - self.progress < 0.02

    @property
    def stuck(self) -> bool:
        """Whether no way has been made for `STUCK_S`."""
        return self._waited * self._body.step > STUCK_S

    def command(self, x: float, y: float, heading: float) -> tuple[float, float]:
        """Return forward [m/s] and turn [rad/s] for the true pose; zeros when the route is over."""
        self._follow(x, y)
        self._waited = self._waited + 1 if self.progress == self._seen else 0
        self._seen = self.progress
        if self.done:
            return 0.0, 0.0
        tx, ty = self._target()
        bearing = math.remainder(math.atan2(ty - y, tx - x) - heading, math.tau)
        if abs(bearing) > 1.2:
            return 0.0, math.copysign(MAX_TURN, bearing)
        # the circle through the robot that touches its heading and meets the target
        curvature = 2 * math.sin(bearing) / max(math.hypot(tx - x, ty - y), 0.05)
        left = self._leg_end() - self.progress
        speed = min(self._body.max_speed, max(0.05, left / (STEPS_TO_BRAKE * self._body.step)))
        speed = min(speed, MAX_TURN / max(abs(curvature), 1e-9))
        return speed, speed * curvature

    def _target(self) -> tuple[float, float]:
        """Return the point to steer at; beyond the end of a leg it lies straight ahead."""
        s, leg = self.progress + LOOKAHEAD, self._leg_end()
        x, y = self.path.at(min(s, leg))
        beyond = max(0.0, s - leg)
        end = self.path.heading(leg - SPACING) if leg < self.path.length else self.path.heading(leg)
        return x + beyond * math.cos(end), y + beyond * math.sin(end)

    def _follow(self, x: float, y: float) -> None:
        """Advance to the nearest point of the path within the window ahead."""
        leg = self._leg_end()
        i, j = np.searchsorted(self.path.along, [self.progress, min(self.progress + WINDOW, leg)])
        near = self.path.points[i : j + 1]
        if len(near):
            best = int(np.argmin(np.hypot(near[:, 0] - x, near[:, 1] - y)))
            self.progress = max(self.progress, float(self.path.along[i + best]))
        if leg < self.path.length and leg - self.progress < TURNED:
            self.progress = leg

    def _leg_end(self) -> float:
        """Return how far the path goes before it turns back or ends [m]."""
        return next((cusp for cusp in self.path.cusps if cusp > self.progress), self.path.length)
