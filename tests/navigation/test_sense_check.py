"""What is found amiss of a camera, ranges and an odometer, and what is done about it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from played import taught

from sim2d.records import SimReading
from topomap.core.panorama import Panorama
from topomap.core.records import Command
from topomap.navigation.sense_check import FROZEN_STEPS, RANGES_STEPS, SenseCheck
from topomap.navigation.senses import Senses

READINGS = taught(30)
AHEAD = Command(0.4)


def checked(readings: list[SimReading], command: Command = AHEAD) -> list[Senses]:
    """What is told of readings, while the wheels were told the same all along."""
    check, out = SenseCheck(), []
    for reading in readings:
        out.append(check.senses(replace(reading, driven=False), Panorama.from_reading(reading), 0.0, None))
        check.commanded(command)
    return out


def spoiled(first: int, **values: object) -> list[SimReading]:
    """The readings, from the `first` on with other values."""
    return [*READINGS[:first], *(replace(reading, **values) for reading in READINGS[first:])]


def test_all_is_well() -> None:
    for senses in checked(READINGS):
        assert senses.health.stop == ""
        assert not senses.health.slow
        assert senses.health.event == ""
        assert senses.ranges is not None


@pytest.mark.parametrize("tone", [0, 90, 255])
def test_a_view_of_one_tone_stops_the_wheels_even_with_sensor_noise(tone: int) -> None:
    noise = np.random.default_rng(0).normal(tone, 2.0, READINGS[0].image.shape)
    told = checked(spoiled(5, image=np.clip(noise, 0, 255).astype(np.uint8)))
    assert [bool(senses.health.stop) for senses in told] == [False] * 5 + [True] * 25
    assert "all of one tone" in told[5].health.event
    assert told[6].health.event == ""


def test_an_image_that_stays_the_same_in_motion_stops_the_wheels() -> None:
    told = checked(spoiled(10, image=READINGS[9].image))
    stops = [bool(senses.health.stop) for senses in told]
    assert stops == [False] * (9 + FROZEN_STEPS) + [True] * (21 - FROZEN_STEPS)


def test_an_image_that_stays_the_same_though_the_wheels_are_told_to_move_stops_them() -> None:
    dead = [replace(READINGS[9], motion=replace(READINGS[9].motion, forward=0.0, turn=0.0))] * 20
    assert checked(dead)[-1].health.stop == "the camera is frozen: the image stays the same in motion"
    pushed = [replace(READINGS[9], motion=replace(READINGS[9].motion, forward=0.1, turn=0.0))] * 20
    assert checked(pushed, Command())[-1].health.stop


def test_the_same_image_while_standing_is_no_fault() -> None:
    standing = [replace(READINGS[9], motion=replace(READINGS[9].motion, forward=0.0, turn=0.0))] * 20
    assert not any(senses.health.stop for senses in checked(standing, Command()))


def test_a_camera_that_works_again_is_said_and_used() -> None:
    black = np.zeros_like(READINGS[0].image)
    told = checked([*READINGS[:5], *(replace(one, image=black) for one in READINGS[5:8]), *READINGS[8:]])
    assert told[8].health.stop == ""
    assert told[8].health.event.startswith("over: the camera shows nothing")


@pytest.mark.parametrize("value", [0.0, np.inf, np.nan, -1.0])
def test_dead_ranges_are_none_and_slow_the_robot(value: float) -> None:
    dead = np.full_like(READINGS[0].ranges, value)
    told = checked(spoiled(5, ranges=dead))
    assert all(senses.ranges is None and senses.health.slow for senses in told[5 + RANGES_STEPS :])
    between = [senses.ranges for senses in told[5 : 4 + RANGES_STEPS]]
    assert all(ranges is not None and np.isnan(ranges).all() for ranges in between)
    assert sum("ranges lost" in senses.health.event for senses in told) == 1


def test_a_robot_that_never_had_ranges_is_not_slow() -> None:
    told = checked(spoiled(0, ranges=np.full_like(READINGS[0].ranges, np.nan)))
    assert not any(senses.health.slow for senses in told)
    assert all(senses.ranges is None for senses in told)


def test_rays_that_hit_nothing_are_no_range() -> None:
    some = READINGS[0].ranges.copy()
    some[:100], some[100:200], some[200:300] = 0.0, -3.0, np.inf
    ranges = checked([replace(READINGS[0], ranges=some)])[0].ranges
    assert ranges is not None
    assert np.isnan(ranges[:300]).all()


def test_a_late_reading_is_one_to_be_slow_after() -> None:
    late = [replace(one, motion=replace(one.motion, dt=2.0)) if k == 20 else one for k, one in enumerate(READINGS)]
    assert [k for k, senses in enumerate(checked(late)) if senses.health.slow] == [20]
