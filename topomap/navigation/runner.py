"""The loop around the navigator: sense, step, act, observe."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from topomap.core.records import StepRecord
from topomap.core.robot import Reading, Robot
from topomap.navigation.navigator import Navigator


class Observer(Protocol):
    """Somebody who watches the steps: a recorder, a progress bar; never the stack."""

    def observe(self, reading: Reading, record: StepRecord) -> None: ...


def run(
    robot: Robot,
    navigator: Navigator,
    observers: tuple[Observer, ...] = (),
    stopped: Callable[[], bool] = lambda: False,
) -> int:
    """Step until the robot has no more readings, the mission is over or `stopped` says so; return the steps made.

    The wheels are stopped whatever happens.
    """
    steps = 0
    try:
        while not navigator.over and not stopped() and (reading := robot.sense()) is not None:
            command, record = navigator.step(reading)
            robot.act(command)
            steps += 1
            for observer in observers:
                observer.observe(reading, record)
    finally:
        robot.stop()
    return steps
