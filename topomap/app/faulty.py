"""A simulated robot with one fault of a sensor, of the odometer, of the clock or of its driver, from some step on."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, get_args

import cv2
import numpy as np

from sim2d.records import SimReading, SimTruth
from sim2d.robot import SimRobot
from topomap.core.arrays import Float32Array, Image
from topomap.core.records import Command
from topomap.core.robot import Reading

Fault = Literal[
    "black image", "white image", "frozen image", "static image", "half covered image", "image of another size",
    "broken image file", "ranges 0", "ranges NaN", "ranges infinite", "ranges negative", "ranges cut short",
    "odometer dead", "odometer NaN", "odometer huge", "odometer reversed", "odometer noisy", "contact stuck",
    "stamp repeated", "stamps backwards", "clock leaps", "sense raises", "sense hangs", "sense returns text",
    "act raises", "act hangs", "stop raises",
]  # fmt: skip
FAULTS: tuple[Fault, ...] = get_args(Fault)
HANGS_S = 3600.0
LEAP_NS = 3600 * 10**9
Spoil = Callable[[SimReading, np.random.Generator], SimReading]


class FaultyRobot:
    """Hands on a robot's readings and commands with a fault; when: the phase it waits for, after: steps of it.

    way: driven behind the fault [m]; stops: how often the wheels were stopped.
    """

    def __init__(self, robot: SimRobot, fault: Fault, when: Literal["teaching", "way home"], after: int) -> None:
        self._robot, self._fault, self._home, self._after = robot, fault, when == "way home", after
        self._rng = np.random.default_rng(0)
        self._kept: SimReading | None = None
        self.way, self.stops, self.faulty = 0.0, 0, False

    def sense(self) -> Reading | None:
        before = self._robot.truth()
        reading = self._robot.sense()
        if reading is None:
            return None
        if reading.driven != self._home:
            self._after -= 1
        if self.faulty:
            now = self._robot.truth()
            self.way += float(np.hypot(now.x - before.x, now.y - before.y))
        self.faulty = self.faulty or self._after < 0
        return self._spoilt(reading) if self.faulty else reading

    def act(self, command: Command) -> None:
        if self.faulty and self._fault == "act raises":
            raise OSError(5, "Input/output error")
        if self.faulty and self._fault == "act hangs":
            time.sleep(HANGS_S)
        self._robot.act(command)

    def stop(self) -> None:
        self.stops += 1
        self._robot.stop()
        if self.faulty and self._fault == "stop raises":
            raise OSError(19, "No such device")

    def truth(self) -> SimTruth:
        """Return the true pose, which the stack never sees."""
        return self._robot.truth()

    def _spoilt(self, reading: SimReading) -> Reading:
        if self._fault == "sense raises":
            raise OSError(110, "Connection timed out")
        if self._fault == "sense hangs":
            time.sleep(HANGS_S)
        if self._fault == "sense returns text":
            return "no reading"  # type: ignore[return-value]  # what a driver does wrong
        self._kept = self._kept or reading
        if self._fault == "frozen image":
            return replace(reading, image=self._kept.image, encoded=self._kept.encoded)
        if self._fault == "stamp repeated":
            return replace(reading, stamp_ns=self._kept.stamp_ns)
        if self._fault == "stamps backwards":
            return replace(reading, stamp_ns=2 * self._kept.stamp_ns - reading.stamp_ns)
        spoil = SPOILT.get(self._fault)
        return reading if spoil is None else spoil(reading, self._rng)


def _shows(image: Image) -> Callable[[SimReading], SimReading]:
    """Return what gives a reading another picture, with the file that a camera would have made of it."""
    return lambda reading: replace(reading, image=image, encoded=_file(image))


def _file(image: Image) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def _grey(value: int) -> Spoil:
    return lambda reading, _: _shows(np.full_like(reading.image, value))(reading)


def _static(reading: SimReading, rng: np.random.Generator) -> SimReading:
    return _shows(rng.integers(0, 256, reading.image.shape, np.uint8))(reading)


def _half(reading: SimReading, _: np.random.Generator) -> SimReading:
    image = reading.image.copy()
    image[:, : image.shape[1] // 2] = 0
    return _shows(image)(reading)


def _smaller(reading: SimReading, _: np.random.Generator) -> SimReading:
    return _shows(np.ascontiguousarray(reading.image[::2, ::2]))(reading)


def _ranges(change: Callable[[Float32Array], Float32Array]) -> Spoil:
    return lambda reading, _: replace(reading, ranges=None if reading.ranges is None else change(reading.ranges))


def _moved(change: Callable[[SimReading, np.random.Generator], tuple[float, float]]) -> Spoil:
    def spoil(reading: SimReading, rng: np.random.Generator) -> SimReading:
        forward, turn = change(reading, rng)
        return replace(reading, motion=replace(reading.motion, forward=forward, turn=turn))

    return spoil


SPOILT: dict[Fault, Spoil] = {
    "black image": _grey(0),
    "white image": _grey(255),
    "static image": _static,
    "half covered image": _half,
    "image of another size": _smaller,
    "broken image file": lambda r, _: replace(
        r, image=np.zeros_like(r.image), encoded=r.encoded[: len(r.encoded) // 3]
    ),
    "ranges 0": _ranges(np.zeros_like),
    "ranges NaN": _ranges(lambda r: np.full_like(r, np.nan)),
    "ranges infinite": _ranges(lambda r: np.full_like(r, np.inf)),
    "ranges negative": _ranges(lambda r: -r),
    "ranges cut short": _ranges(lambda r: r[: len(r) // 3]),
    "odometer dead": _moved(lambda r, _: (0.0, 0.0)),
    "odometer NaN": _moved(lambda r, _: (float("nan"), r.motion.turn)),
    "odometer huge": _moved(lambda r, _: (1e6, r.motion.turn)),
    "odometer reversed": _moved(lambda r, _: (-r.motion.forward, -r.motion.turn)),
    "odometer noisy": _moved(
        lambda r, rng: (r.motion.forward + rng.normal(0, 0.2), r.motion.turn + rng.normal(0, 0.5))
    ),
    "contact stuck": lambda r, _: replace(r, contact=True),
    "clock leaps": lambda r, _: replace(r, stamp_ns=r.stamp_ns + LEAP_NS),
}
