"""The loop around the navigator: sense, log, step, act, observe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from topomap.core.errors import RobotFault, TopomapError
from topomap.core.records import StepRecord
from topomap.core.robot import Reading, Robot
from topomap.navigation.navigator import Navigator
from topomap.navigation.short_pauses import short_pauses


class Observer(Protocol):
    """Somebody who watches the steps: a recorder, a progress bar; never the stack."""

    def observe(self, reading: Reading, record: StepRecord) -> None: ...


def run(
    robot: Robot,
    navigator: Navigator,
    observers: tuple[Observer, ...] = (),
    stopped: Callable[[], bool] = lambda: False,
    most_steps: int | None = None,
    sensed: Callable[[Reading], None] = lambda _: None,
) -> int:
    """Step until the robot has no more readings, the mission is over or `stopped` says so; return the steps made.

    sensed: takes each reading before the stack does. The wheels are stopped whatever happens. Raises RobotFault, with
    one line, where the robot's driver or a step fails, or the run takes more than `most_steps`.
    """
    steps = 0
    with _stopping(robot), short_pauses():
        while not navigator.over and not stopped() and (reading := _sense(robot, steps)) is not None:
            if most_steps is not None and steps >= most_steps:
                raise RobotFault(f"the run has no end: it was stopped after {steps} steps")
            sensed(reading)
            with _told(f"step {steps}, the reading at {reading.stamp_ns} ns"):
                command, record = navigator.step(reading)
            with _told(f"the robot's act() at step {steps}"):
                robot.act(command)
            steps += 1
            for observer in observers:
                observer.observe(reading, record)
    return steps


@contextmanager
def _stopping(robot: Robot) -> Iterator[None]:
    """Stop the wheels in the end, whatever happens."""
    try:
        yield
    finally:
        with _told("the robot's stop()"):
            robot.stop()


def _sense(robot: Robot, steps: int) -> Reading | None:
    with _told(f"the robot's sense() at step {steps}"):
        return robot.sense()
    return None


@contextmanager
def _told(where: str) -> Iterator[None]:
    """Let every error be a RobotFault that says where it happened."""
    try:
        yield
    except RobotFault:
        raise
    except TopomapError as error:
        raise RobotFault(f"{where}: {error}") from error
    except Exception as error:  # a driver may raise anything
        raise RobotFault(f"{where} failed: {type(error).__name__}: {error}") from error
