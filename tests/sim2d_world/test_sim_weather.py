"""The camera's, the scanner's and the odometer's nuisances: each does what it says, and nothing when it is off."""

from __future__ import annotations

import hashlib
import math
from itertools import pairwise

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import CameraConfig, LensConfig, ShutterConfig, SimConfig, SwayConfig
from sim2d.crowd import crowd
from sim2d.path import of_route
from sim2d.robot import SimRobot
from sim2d.sensors.camera import Camera
from sim2d.sensors.field import Field
from sim2d.sensors.odometer import Odometer
from sim2d.sensors.shutter import moments
from sim2d.sensors.sway import Sway
from sim2d.sensors.way import Way
from sim2d.streams import stream

QUIET = {"noise": 0.0, "codec": "png"}


def view(x: float = 4.0, y: float = 1.2, **settings: object) -> np.ndarray:
    camera = Camera(CameraConfig.model_validate(QUIET | settings), stream(0, "test"), stream(0, "body"))
    return camera.view(worlds.load("room-corridor"), x, y, 0.0).astype(float)


def drive(steps: int = 12, **sim: object) -> list:
    robot = SimRobot(worlds.load("room-corridor"), SimConfig.model_validate(sim), 3)
    return [robot.sense() for _ in range(steps)]


def test_a_calm_robot_senses_what_it_did_before_there_was_weather() -> None:
    # of the house before: images, ranges and odometry of the first twelve steps
    seen = hashlib.sha256()
    for reading in drive():
        seen.update(reading.ranges.tobytes() + np.array([reading.motion.forward, reading.motion.turn]).tobytes())
    assert seen.hexdigest()[:16] == "a628467230a31058"


def test_vignetting_darkens_between_the_lenses() -> None:
    plain, dark = view(), view(lens={"lenses": 3, "vignetting": 0.5})
    share = dark.sum(axis=(0, 2)) / plain.sum(axis=(0, 2))
    axes, borders = [360, 120, 600], [0, 240, 480]
    assert min(share[axes]) > max(share[borders]) + 0.1
    # in the corner half the light is lost
    corner = (plain[0, 0] > 40) & (plain[0, 0] < 250)
    assert dark[0, 0][corner] / plain[0, 0][corner] == pytest.approx(0.5, abs=0.02)


def test_a_seam_is_a_step_in_colour() -> None:
    plain, seamed = view(), view(lens={"seam": 0.2})
    ratio = np.log(np.maximum(seamed, 1).mean(axis=0) / np.maximum(plain, 1).mean(axis=0))
    inside = np.abs(ratio[200:520] - ratio[360]).max()
    assert np.abs(ratio[0] - ratio[360]).max() > 3 * inside


def test_supports_stand_where_they_are_told() -> None:
    image = view(lens={"supports": 3, "support_deg": 4.0})
    black = np.flatnonzero((image == 0).all(axis=(0, 2)))
    assert len(black) == pytest.approx(3 * 4 * 2, abs=3)
    assert {0, 240, 480} <= set(black.tolist())


def test_a_turn_blurs_columns_and_a_rolling_shutter_slants_them() -> None:
    world, pose, before = worlds.load("room-corridor"), (4.0, 1.2, 0.0), (4.0, 1.2, -0.2)

    def shot(**shutter: float) -> np.ndarray:
        camera = Camera(CameraConfig(noise=0.0, codec="png", shutter=ShutterConfig(**shutter)), stream(0, "test"))
        return camera.shoot(world, *pose, before, 0.25)[0].astype(float)

    sharp, blurred, rolling = shot(), shot(exposure=0.05), shot(readout=0.1)
    assert np.abs(np.diff(blurred, axis=1)).mean() < 0.85 * np.abs(np.diff(sharp, axis=1)).mean()
    # the first row is as old as the readout is long: 0.08 rad of turn, 9 columns; the last one isn't
    assert _shift(rolling[5], sharp[5]) == pytest.approx(-9, abs=1)
    assert abs(_shift(rolling[-3], sharp[-3])) <= 1


def _shift(row: np.ndarray, other: np.ndarray) -> int:
    errors = [np.abs(np.roll(other, k, axis=0) - row).sum() for k in range(-30, 31)]
    return int(np.argmin(errors)) - 30


def test_each_row_holds_a_whole_exposure() -> None:
    config = ShutterConfig(exposure=0.04, readout=0.06)
    poses, weights = moments(config, 100, 114.6, (1.0, 0.0, 0.3), (0.9, 0.0, 0.1), 0.25)
    assert len(poses) == weights.shape[1] > 3
    assert weights.sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    ages = weights @ np.linspace(0.1, 0.0, len(poses))
    assert ages[0] == pytest.approx(0.08, abs=0.005)
    assert ages[-1] == pytest.approx(0.02, abs=0.005)


def test_automatic_exposure_comes_after_its_lag() -> None:
    config = CameraConfig(noise=0.0, codec="png", exposure="auto", exposure_lag=1.0, hour=12.0)
    camera, world = Camera(config, stream(0, "test")), worlds.load("room-corridor")
    day = camera.shoot(world, 4.0, 1.2, 0.0, None, 0.25)[0].mean()
    camera.hour = 23.0
    night = [camera.shoot(world, 4.0, 1.2, 0.0, None, 0.25)[0].mean() for _ in range(24)]
    assert night[0] > day + 10  # the lamps are on
    assert night[-1] == pytest.approx(day, abs=5)
    assert np.all(np.diff(night) < 0.5)


def test_white_balance_evens_out_the_channels() -> None:
    warm = view(hour=22.0)
    even = view(hour=22.0, white_balance="auto")
    assert np.ptp(even.mean(axis=(0, 1))) < 0.3 * np.ptp(warm.mean(axis=(0, 1)))


def test_a_jpeg_fits_its_greatest_size() -> None:
    world = worlds.load("room-corridor")
    camera = Camera(CameraConfig(max_bytes=6000), stream(0, "test"))
    whole = Camera(CameraConfig(), stream(0, "test")).shoot(world, 4.0, 1.2, 0.0)[1]
    encoded = camera.shoot(world, 4.0, 1.2, 0.0)[1]
    assert 4000 < len(encoded) <= 6000 < len(whole)


def test_sway_leans_back_when_speeding_up_and_outwards_in_a_bend() -> None:
    sway = Sway(SwayConfig(per_acceleration_deg=2.0), stream(0, "test"))
    roll, pitch = sway.lean(0.0, 0.0, 0.4, 0.0, 0.25)
    assert (roll, math.degrees(pitch)) == (0.0, pytest.approx(-3.2))
    roll, pitch = sway.lean(0.0, 0.0, 0.4, 0.5, 0.25)
    assert (math.degrees(roll), pitch) == (pytest.approx(0.4), 0.0)


def test_bumps_stay_where_they_are() -> None:
    sway = Sway(SwayConfig(bumps_deg=1.0), stream(0, "test"))
    places = np.random.default_rng(0).uniform(0, 40, (600, 2))
    leans = np.degrees([sway.lean(x, y, 0.0, 0.0, 0.25) for x, y in places])
    assert leans.std(axis=0) == pytest.approx(1.0, abs=0.2)
    assert sway.lean(*places[5], 0.0, 0.0, 0.25) == tuple(np.radians(leans[5]))


def test_a_field_is_smooth_over_its_length() -> None:
    field = Field(stream(1, "test"), 2.0)
    places = np.random.default_rng(0).uniform(0, 200, (800, 2))
    here = np.array([field.at(*p) for p in places])
    near = np.array([field.at(p[0] + 0.2, p[1]) for p in places])
    far = np.array([field.at(p[0] + 20.0, p[1]) for p in places])
    assert np.corrcoef(here, near)[0, 1] > 0.98
    assert abs(np.corrcoef(here, far)[0, 1]) < 0.35


def test_senses_lag_behind_the_odometer() -> None:
    way = Way(0.25, (0.0, 0.0, 0.0))
    for k in range(1, 9):
        way.extend((0.1 * k, 0.0, 0.0))
    assert way.back(0.0)[0] == pytest.approx(0.8)
    assert way.back(0.3)[0] == pytest.approx(0.68)
    assert way.back(9.0)[0] == pytest.approx(0.0)
    prompt, late = drive(10), drive(10, laser={"lag": 0.25, "noise": 0.0, "dropout": 0.0})
    exact = drive(10, laser={"noise": 0.0, "dropout": 0.0})
    assert np.nanmax(np.abs(late[9].ranges - exact[8].ranges)) < 1e-6
    assert prompt[9].motion.forward == late[9].motion.forward


def test_frames_are_repeated_as_often_as_told() -> None:
    readings = drive(60, camera={"repeated": 0.5, "noise": 2.0})
    again = [a.encoded == b.encoded for a, b in pairwise(readings)]
    assert 0.3 < np.mean(again) < 0.7


def test_floor_and_load_change_what_is_read() -> None:
    def read(**settings: float) -> list[float]:
        config = SimConfig.model_validate({"odometer": {"forward_noise": 0.0, "spread": 0.0} | settings}).odometer
        odometer = Odometer(config, stream(0, "a"), stream(0, "b"), None, stream(0, "c"))
        return [odometer.read(0.1, 0.0, 0.25, place=(0.1 * k, 0.0)).forward for k in range(3000)]

    assert set(np.round(read(), 9)) == {0.095}
    floor, load = np.array(read(floor=0.02)), np.array(read(load=0.5))
    assert floor.std() / floor.mean() == pytest.approx(0.02, rel=0.5)
    assert (0.1 - load).std() / 0.005 == pytest.approx(0.5, rel=0.6)


def test_companions_walk_beside_the_robot_all_the_way() -> None:
    config = SimConfig.model_validate({"people": {"beside": 6}})
    path = of_route(worlds.load("room-corridor").spec.route)
    company = crowd(path, config.people, stream(0, "people"))
    assert len(company) == 6
    world = worlds.load("room-corridor")
    robot = SimRobot(world, config, 3)
    far = []
    for _ in range(120):
        robot.sense()
        truth = robot.truth()
        far.append([math.dist((w.x, w.y), (truth.x, truth.y)) for w in world.people.walkers[-6:]])
    assert np.median(np.array(far)[40:]) < 1.9
    assert np.max(np.array(far)[40:]) < 3.0


def test_ranges_pass_through_glass(tmp_path: object) -> None:
    from sim2d.config import LaserConfig
    from sim2d.sensors.laser import Laser
    from sim2d.shapes import Ground, Look, Route, Spec, Wall, rectangle
    from sim2d.world import World

    plain = Look((1.0, 1.0, 1.0), "plain")
    pane = Wall(((2.0, -3.0), (2.0, 3.0)), 2.5, Look((0.5, 0.9, 0.9), "plain", glass=True))
    room = Wall((*rectangle(-5, -5, 5, 5), (-5, -5)), 2.5, plain)
    world = World(
        Spec("glass", Route(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), 1), Ground(plain), Ground(plain), 2.5, (pane, room))
    )
    ranges = Laser(LaserConfig(), stream(0, "test")).exact(world, 0.0, 0.0, 0.0)
    assert ranges[0] == pytest.approx(5.0)
    image = Camera(CameraConfig(noise=0.0), stream(0, "test")).view(world, 0.0, 0.0, 0.0)
    assert image[49, 360, 0] < 0.8 * image[49, 360, 1]


def test_the_day_goes_on() -> None:
    robot = SimRobot(
        worlds.load("room-corridor"), SimConfig.model_validate({"camera": {"hour": 9.0, "hour_rate": 600.0}}), 3
    )
    for _ in range(5):
        robot.sense()
    assert robot.world.hour is not None
    assert 9.0 < robot.world.hour <= 9.2


def test_lens_settings_are_checked() -> None:
    with pytest.raises(ValueError, match="vignetting"):
        LensConfig(vignetting=1.0)
