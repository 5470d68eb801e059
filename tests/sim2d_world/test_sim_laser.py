"""The range scanner: heights, the two shots of the thesis's scanner, noise and gaps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import LaserConfig, SimConfig
from sim2d.robot import SimRobot
from sim2d.sensors.laser import Laser
from sim2d.shapes import Box, Ground, Look, Route, Spec, Wall, rectangle
from sim2d.streams import stream
from sim2d.world import World

GREY = Look((0.5, 0.5, 0.5), "plain")
EXACT = {"scanner": "urg", "noise": 0.0, "dropout": 0.0}


def laser(**settings: float | str) -> Laser:
    return Laser(LaserConfig.model_validate(settings), stream(0, "range noise"))


def boxes_world() -> World:
    """A low box 1 m ahead and a high one 2 m ahead, in a room of 6 x 6 m."""
    low, high = (Box(rectangle(x, -0.5, x + 0.3, 0.5), h, GREY) for x, h in ((1.0, 0.3), (2.0, 1.5)))
    wall = Wall((*rectangle(-3, -3, 3, 3), (-3, -3)), 2.6, GREY)
    ground = Ground(GREY, 1.0)
    return World(Spec("boxes", Route(((0, 0), (1, 0), (1, 1)), 1), ground, ground, 2.6, (wall,), (low, high)))


@pytest.mark.parametrize(("height", "expected"), [(0.0, 1.0), (0.3, 1.0), (0.31, 2.0), (1.5, 2.0), (1.6, 3.0)])
def test_only_what_is_as_high_as_the_laser_is_hit(height: float, expected: float) -> None:
    ranges = laser(height=height).exact(boxes_world(), 0.0, 0.0, 0.0)
    assert ranges[0] == pytest.approx(expected, abs=1e-9)


def test_two_shots_of_the_scanner_cover_all_bearings_to_half_a_step() -> None:
    """Between neighbouring rays of the ring the scanner's nearest ray lies: no range outside those bounds."""
    world = worlds.load("room-corridor")
    scanned = laser(**EXACT).scan(world, 4.0, 1.2, 0.3)
    fine = laser(rays=7200, max_range=4.0).exact(world, 4.0, 1.2, 0.3)
    assert scanned.shape == (720,)
    assert scanned.dtype == np.float32
    near = np.stack([np.roll(fine, k)[::10] for k in range(-4, 5)])  # +-0.2 degrees
    known = ~np.isnan(near).any(axis=0)
    assert known.mean() > 0.6
    assert (scanned[known] >= near[:, known].min(axis=0) - 1e-5).all()
    assert (scanned[known] <= near[:, known].max(axis=0) + 1e-5).all()


def test_the_scanner_reaches_four_metres() -> None:
    world = worlds.load("hall")
    scanned = laser(**EXACT).scan(world, 12.0, 9.0, 0.0)
    assert np.isnan(scanned).any()
    assert np.nanmax(scanned) <= 4.0
    farther = laser(**{**EXACT, "scanner": "ring"}).scan(world, 12.0, 9.0, 0.0)
    assert np.isnan(farther).sum() < np.isnan(scanned).sum()


def test_where_the_shots_overlap_their_mean_is_quieter() -> None:
    world = boxes_world()
    scanner = laser(scanner="urg", noise=0.02, dropout=0.0)
    rays = np.stack([scanner.scan(world, -1.5, 0.0, 0.0) for _ in range(60)])
    spread = np.where(np.isnan(rays).any(axis=0), np.nan, rays.std(axis=0))
    assert np.nanmedian(spread[:110]) == pytest.approx(0.02, rel=0.15)  # one shot: within 60 degrees of the nose
    assert np.nanmedian(spread[130:230]) == pytest.approx(0.02 / math.sqrt(2), rel=0.15)  # both: 65 to 115 degrees


def test_one_dropped_ray_is_filled_from_the_other_shot_where_there_is_one() -> None:
    scanner = laser(**EXACT)
    front, rear = np.full(667, 1.0), np.full(667, 3.0)
    front[333] = np.nan  # ahead: only the first shot
    merged = scanner.merged(front, rear)
    assert np.isnan(merged[0])
    assert merged[360] == 3.0
    assert merged[180] == 2.0
    front[:] = np.nan
    assert scanner.merged(front, rear)[180] == 3.0


def test_the_share_of_gaps_is_as_configured() -> None:
    gappy = laser(dropout=0.1)
    world = boxes_world()
    gaps = np.mean([np.isnan(gappy.scan(world, -1.0, 0.0, 0.1)).mean() for _ in range(20)])
    assert gaps == pytest.approx(0.1, abs=0.012)


def test_a_camera_alone_has_no_ranges_and_sees_the_same() -> None:
    readings = []
    for scanner in ("none", "ring"):
        config = SimConfig.model_validate({"laser": {"scanner": scanner}})
        robot = SimRobot(worlds.load("room-corridor"), config, 0)
        reading = robot.sense()
        assert reading is not None
        readings.append(reading)
    assert readings[0].ranges is None
    assert readings[1].ranges is not None
    assert readings[0].encoded == readings[1].encoded
