"""An odometer that counts nothing, turns that no view shows, ways that no wheels can make."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from played import moved, taught

from sim2d.records import SimReading
from topomap.core.panorama import Panorama
from topomap.core.records import Command
from topomap.core.robot import Reading
from topomap.mapping.odometry.increments import Calibration
from topomap.navigation.odometry_check import BAD, OdometryCheck, Restated

READINGS = [replace(reading, driven=False) for reading in taught(70)]
CALIBRATION = Calibration(rotation_scale=1.04, curvature=0.0, distance_scale=0.95)


def checked(readings: list[SimReading], commands: list[Command] | None = None) -> tuple[list[Reading], OdometryCheck]:
    """What becomes of readings, each the answer to a command: what the driver of the lesson did."""
    check = OdometryCheck(0.4)
    told = commands or [did(reading) for reading in READINGS]
    out = [
        check.checked(reading, Panorama.from_reading(reading), command, CALIBRATION)
        for reading, command in zip(readings, told, strict=True)
    ]
    return out, check


def did(reading: SimReading) -> Command:
    return Command(reading.motion.forward / 0.25 / 0.95, reading.motion.turn / 0.25)


def test_a_good_odometer_is_left_alone() -> None:
    out, check = checked(READINGS)
    assert all(after is before for after, before in zip(out, READINGS, strict=True))
    assert check.amiss == ""


def test_a_dead_one_is_noticed_at_its_first_step_and_replaced() -> None:
    dead = [*READINGS[:20], *(moved(reading, forward=0.0, turn=0.0) for reading in READINGS[20:])]
    out, check = checked(dead)
    assert [isinstance(reading, Restated) for reading in out] == [False] * 20 + [True] * 50
    assert "odometry dead" in check.amiss
    for true, told in zip(READINGS[20:], out[20:], strict=True):
        assert told.motion.forward == pytest.approx(true.motion.forward, abs=0.01)
        assert told.motion.turn == pytest.approx(true.motion.turn, abs=0.05)
        assert np.linalg.eigvalsh(told.motion.covariance).min() > 0
    assert out[30].stamp_ns == READINGS[30].stamp_ns
    assert out[30].encoded == READINGS[30].encoded


def alike_both_ways(reading: SimReading) -> list[SimReading]:
    """Views in a corridor that look a little more alike turned round than as the robot stands."""
    half = reading.image[:, : reading.image.shape[1] // 2].astype(np.int16)
    coarse = np.random.default_rng(0).integers(-40, 41, (half.shape[0] // 10, half.shape[1] // 20, 3))
    noise = np.repeat(np.repeat(coarse, 10, axis=0), 20, axis=1)
    front, back = half.astype(np.uint8), np.clip(half + noise, 0, 255).astype(np.uint8)
    ways = np.concatenate([front, back], axis=1), np.concatenate([back, front], axis=1)
    return [replace(moved(reading, forward=0.0, turn=0.0), image=ways[k % 2]) for k in range(12)]


@pytest.mark.parametrize("turn", [0.0, 0.8, -0.8])
def test_a_corridor_that_looks_alike_both_ways_turns_nobody_round(turn: float) -> None:
    out, check = checked(alike_both_ways(READINGS[10]), [Command(0.3, turn)] * 12)
    assert check.dead
    assert all(abs(told.motion.turn) < 0.1 for told in out)


def test_a_robot_that_is_held_fast_has_no_dead_odometer() -> None:
    held = [moved(READINGS[10], forward=0.0, turn=0.0)] * 20
    out, check = checked(held, [Command(0.4)] * 20)
    assert not any(isinstance(reading, Restated) for reading in out)
    assert check.amiss == ""


def test_turns_that_no_view_shows_are_the_views() -> None:
    rng = np.random.default_rng(0)
    noisy = [moved(reading, turn=reading.motion.turn + rng.normal(0.0, 0.3)) for reading in READINGS]
    out, check = checked(noisy)
    restated = [k for k, reading in enumerate(out) if isinstance(reading, Restated)]
    assert BAD <= restated[0] <= 8
    for k in restated:
        assert out[k].motion.turn == pytest.approx(READINGS[k].motion.turn, abs=0.05)
    assert "its turns can't be" in check.amiss


def amid_people(reading: SimReading, step: int, share: float) -> SimReading:
    """A view of which people who walk past, 12 degrees a step, hide a share."""
    image = reading.image.copy()
    rows, columns, _ = image.shape
    coarse = np.random.default_rng(5).integers(0, 256, (rows // 10, columns // 20, 3), dtype=np.uint8)
    people = np.repeat(np.repeat(coarse, 10, axis=0), 20, axis=1)[:, : round(share * columns)]
    at = (np.arange(people.shape[1]) + step * columns // 30) % columns
    image[: people.shape[0], at] = people
    return replace(reading, image=image)


@pytest.mark.parametrize("share", [0.2, 0.27, 0.3])
def test_people_who_hide_a_third_of_the_view_say_nothing_against_the_odometer(share: float) -> None:
    """The turn that they show explains the whole view little better than the odometer's."""
    out, check = checked([amid_people(reading, k, share) for k, reading in enumerate(READINGS)])
    assert not any(isinstance(reading, Restated) for reading in out)
    assert check.amiss == ""


def test_turns_that_no_view_shows_are_found_though_people_hide_a_third_of_it() -> None:
    rng = np.random.default_rng(0)
    noisy = [moved(amid_people(reading, k, 0.3), turn=reading.motion.turn + rng.normal(0.0, 0.3))
             for k, reading in enumerate(READINGS)]  # fmt: skip
    _, check = checked(noisy)
    assert "its turns can't be" in check.amiss


def test_ways_that_no_wheels_can_make_are_the_commands() -> None:
    rng = np.random.default_rng(1)
    noisy = [moved(reading, forward=reading.motion.forward + rng.normal(0.0, 0.1)) for reading in READINGS]
    out, check = checked(noisy)
    restated = [k for k, reading in enumerate(out) if isinstance(reading, Restated)]
    assert len(restated) > 20
    for k in restated:
        assert out[k].motion.forward == pytest.approx(READINGS[k].motion.forward, abs=0.02)
        assert out[k].motion.turn == READINGS[k].motion.turn
    assert "its ways can't be" in check.amiss


def test_wheels_that_take_their_time_are_believed() -> None:
    slow = [moved(reading, forward=0.4 * reading.motion.forward) for reading in READINGS]
    out, _ = checked(slow)
    assert not any(isinstance(reading, Restated) for reading in out)


def test_it_is_believed_again_once_it_is_well_and_never_judged_in_a_lesson() -> None:
    rng = np.random.default_rng(0)
    noisy = [moved(reading, turn=reading.motion.turn + rng.normal(0.0, 0.3)) for reading in READINGS[:20]]
    out, check = checked([*noisy, *READINGS[20:]])
    assert isinstance(out[19], Restated)
    assert not isinstance(out[-1], Restated)
    assert check.amiss == ""
    lesson, check = checked([replace(reading, driven=True) for reading in [*noisy, *READINGS[20:]]])
    assert not any(isinstance(reading, Restated) for reading in lesson)
