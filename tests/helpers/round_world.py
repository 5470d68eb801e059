"""A robot of a test's own, in a round room of coloured stripes: fits `Robot` and knows nothing of sim2d."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from topomap import Command, Motion, Reading, Rig

RIG = Rig.cylinder(180, 40, camera_height=0.5)
STEP_NS = 100_000_000
ROOM, LAP = 3.0, 60  # [m] radius, steps


class RoundRobot:
    """Drives round a circle of 1.5 m radius; `number` makes the kind of float that its driver hands over."""

    def __init__(self, steps: int, number: Callable[[float], float] = float, fails_at: int = -1) -> None:
        self._steps, self._number, self._fails_at = steps, number, fails_at
        self._wall = np.random.default_rng(1).integers(40, 220, (90, 3), dtype=np.uint8).repeat(4, axis=0)
        self._step = -1
        self.stops = 0

    def sense(self) -> Reading | None:
        self._step += 1
        if self._step == self._fails_at:
            raise OSError("the camera is gone")
        if self._step >= self._steps:
            return None
        turn = self._number(math.tau / LAP)
        motion = Motion(self._number(1.5 * math.tau / LAP), self._number(0.0), turn,
                        np.diag([1e-4, 1e-6, 1e-5]), self._number(0.1))  # fmt: skip
        heading = self._step * math.tau / LAP
        image, ranges = self._view(1.5 * math.sin(heading), -1.5 * math.cos(heading), heading)
        return Reading(stamp_ns=(self._step + 1) * STEP_NS, motion=motion, rig=RIG, image=image, ranges=ranges,
                       driven=self._step < self._steps - 2)  # fmt: skip

    def act(self, command: Command) -> None:
        pass

    def stop(self) -> None:
        self.stops += 1

    def _view(self, x: float, y: float, heading: float) -> tuple[np.ndarray, np.ndarray]:
        bearings = (RIG.forward_column - np.arange(RIG.width)) * math.tau / RIG.width
        far = self._distance(x, y, heading + bearings)
        hit = np.arctan2(y + far * np.sin(heading + bearings), x + far * np.cos(heading + bearings))
        image = np.full((RIG.height, RIG.width, 3), 90, np.uint8)
        rows = np.arange(RIG.height)[:, None]
        seen = (rows < RIG.horizon_row + RIG.focal * 0.5 / far) & (rows > RIG.horizon_row - RIG.focal * 1.0 / far)
        colours = self._wall[np.round(hit * 360 / math.tau).astype(int) % 360]
        image[seen] = np.broadcast_to(colours, image.shape)[seen]
        around = np.arange(RIG.width) * math.tau / RIG.width
        return image, self._distance(x, y, heading + around)

    @staticmethod
    def _distance(x: float, y: float, towards: np.ndarray) -> np.ndarray:
        along = x * np.cos(towards) + y * np.sin(towards)
        return -along + np.sqrt(along**2 + ROOM**2 - x**2 - y**2)
