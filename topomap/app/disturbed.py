"""A simulated robot that is moved, turned, carried away, or whose senses fail."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from sim2d.records import SimReading
from sim2d.robot import SimRobot
from topomap.core.arrays import FloatArray
from topomap.core.records import Command

Kind = Literal[
    "none", "turned", "moved", "carried", "carried late", "blind ranges", "zero ranges", "dead odometry",
    "noisy odometry", "very noisy odometry", "black", "frozen",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)
MOVED = 3.0
"""[m] Farthest that a start is moved."""
CARRIED = (2.0, 6.0)
"""[m] How far the robot is carried in mid-run."""
NOISE = {"noisy odometry": (0.03, 0.1), "very noisy odometry": (0.1, 0.3)}
"""[m, rad] Noise of each step."""
LATE = (1.0, 5.0)
"""[m] How near the goal the robot is carried away late: an arrival is claimed wrongly most easily by who has just been
carried on or back, unnoticed, to a place that looks the same."""
FIRST_STEPS = 20
"""Steps before senses fail or the robot is carried: so far all is well."""


@dataclass(frozen=True, slots=True)
class Disturbance:
    """What goes wrong on a journey."""

    kind: Kind = "none"


class Disturbed:
    """Hands on a robot's readings with the disturbance; places (K, 3): where it may be put; target [m]: the goal."""

    def __init__(
        self,
        robot: SimRobot,
        disturbance: Disturbance,
        places: FloatArray,
        target: tuple[float, float],
        rng: np.random.Generator,
    ) -> None:
        self._robot, self._kind, self._rng = robot, disturbance.kind, rng
        self._places = places
        self._steps = 0
        self._frozen: SimReading | None = None
        self._when = int(rng.integers(FIRST_STEPS, 3 * FIRST_STEPS))
        self._target, self._late = target, float(rng.uniform(*LATE)) if self._kind == "carried late" else 0.0
        if self._kind in ("turned", "moved"):
            self._put(0.0, MOVED if self._kind == "moved" else 0.0, rng.uniform(-math.pi, math.pi))

    def sense(self) -> SimReading | None:
        self._steps += 1
        if self._kind == "carried" and self._steps == self._when:
            self._put(*CARRIED, 0.0)
        if self._late and self._away() < self._late:
            self._late = 0.0
            self._put(*CARRIED, 0.0)
        reading = self._robot.sense()
        return None if reading is None else self._spoiled(reading)

    def act(self, command: Command) -> None:
        self._robot.act(command)

    def stop(self) -> None:
        self._robot.rest()

    def _away(self) -> float:
        here = self._robot.truth()
        return math.dist((here.x, here.y), self._target)

    def _put(self, nearest: float, farthest: float, turn: float) -> None:
        """Put the robot somewhere else on the taught route, turned by `turn` [rad]."""
        here = self._robot.truth()
        away = np.hypot(self._places[:, 0] - here.x, self._places[:, 1] - here.y)
        fit = np.flatnonzero((away >= nearest) & (away <= max(farthest, float(away.min()))))
        x, y, heading = self._places[int(self._rng.choice(fit))]
        self._robot.put(
            float(x), float(y), float((here.heading if self._kind in ("carried", "carried late") else heading) + turn)
        )

    def _spoiled(self, reading: SimReading) -> SimReading:
        kind, motion = self._kind, reading.motion
        late = self._steps > self._when
        if kind in NOISE:
            way, turn = self._rng.normal(0.0, NOISE[kind])
            return replace(reading, motion=replace(motion, forward=motion.forward + way, turn=motion.turn + turn))
        if kind == "dead odometry":
            return replace(reading, motion=replace(motion, forward=0.0, turn=0.0))
        if kind in ("blind ranges", "zero ranges") and reading.ranges is not None:
            value = math.nan if kind == "blind ranges" else 0.0
            return replace(reading, ranges=np.full_like(reading.ranges, value))
        if kind == "black" and late:
            return replace(reading, image=np.zeros_like(reading.image))
        if kind == "frozen" and late:
            self._frozen = self._frozen or reading
            return replace(reading, image=self._frozen.image, encoded=self._frozen.encoded)
        return reading
