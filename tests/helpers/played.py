"""Readings played to the stack as a robot would hand them over, and changed ones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from sim2d import worlds
from sim2d.records import SimReading
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.core.records import Command, StepRecord


class Played:
    """A robot that senses what it is given."""

    def __init__(self, readings: Iterable[SimReading]) -> None:
        self._readings = iter(readings)
        self.commands: list[Command] = []
        self.stopped = False

    def sense(self) -> SimReading | None:
        return next(self._readings, None)

    def act(self, command: Command) -> None:
        self.commands.append(command)

    def stop(self) -> None:
        self.stopped = True


class Kept:
    """An observer that keeps every step."""

    def __init__(self) -> None:
        self.records: list[StepRecord] = []

    def observe(self, reading: object, record: StepRecord) -> None:
        self.records.append(record)


def taught(steps: int, world: str = "room-corridor") -> list[SimReading]:
    """The first readings of a world, seed 0."""
    robot = SimRobot(worlds.load(world), load_config().sim, 0)
    readings = [robot.sense() for _ in range(steps)]
    return [reading for reading in readings if reading is not None]


def moved(reading: SimReading, **values: object) -> SimReading:
    """The reading with another odometry increment."""
    return replace(reading, motion=replace(reading.motion, **values))
