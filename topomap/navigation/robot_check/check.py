"""Asks a robot for some readings and lets every check look at them."""

from __future__ import annotations

from collections.abc import Callable

from topomap.core.records import Command
from topomap.core.robot import Reading, Robot
from topomap.navigation.robot_check.arrays import check_covariance, check_encoded, check_image, check_ranges
from topomap.navigation.robot_check.directions import check_directions
from topomap.navigation.robot_check.finding import Finding, Findings, Readings
from topomap.navigation.robot_check.numbers import check_fields, check_motion, check_rig, check_stamps

TURN = Command(0.0, 0.3)
ROLL = Command(0.1, 0.0)
FIRST = (check_fields, check_rig, check_image)
"""Where one of these finds something the others can't look."""
THEN = (check_encoded, check_ranges, check_covariance, check_stamps, check_motion)


def check_robot(robot: Robot, readings: int = 200, drive: bool = False) -> tuple[Finding, ...]:
    """Return what a robot's driver does wrong, a line each; nothing where all is well.

    readings: how many to take; the robot should turn and roll forward in them, by its own driver, by hand, or where
    `drive` is set by commands from here: on the spot at 0.3 rad/s in the first half, then forward at 0.1 m/s (keep the
    floor ahead free) till the bumper is pressed. The wheels are stopped at the end. A faulty driver raises nothing
    here: it is a finding.
    """
    seen, found = _gather(robot, readings, drive)
    if not seen:
        return tuple(found)
    for check in FIRST:
        found += _guarded(check, seen)
        if found:
            return tuple(found)
    for check in THEN:
        found += _guarded(check, seen)
    return (*found, *_guarded(lambda kept: check_directions(kept, found), seen))


def _guarded(check: Callable[[Readings], Findings], seen: Readings) -> Findings:
    """Return what a check finds; what it stumbles over is a finding too."""
    try:
        return check(seen)
    except Exception as error:
        return [Finding("reading", f"can't be looked at: {type(error).__name__}: {error}")]


def _gather(robot: Robot, count: int, drive: bool) -> tuple[Readings, Findings]:
    seen: Readings = []
    found: Findings = []
    try:
        for k in range(count):
            reading = robot.sense()
            if reading is None:
                break
            seen.append(reading)
            robot.act(_command(reading, k, count) if drive else Command())
    except Exception as error:
        found.append(Finding("sense or act", f"raises {type(error).__name__}: {error}"))
    finally:
        found += _stopped(robot)
    if not seen and not found:
        found.append(Finding("sense", "returns None at once: there is no reading to look at"))
    return seen, found


def _command(reading: Reading, k: int, count: int) -> Command:
    if 2 * k < count:
        return TURN
    return Command() if reading.contact else ROLL


def _stopped(robot: Robot) -> Findings:
    try:
        robot.stop()
    except Exception as error:
        return [Finding("stop", f"raises {type(error).__name__}: {error}; it must always stop the wheels")]
    return []
