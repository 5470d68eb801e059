"""The robot as a whole: contracts, determinism, collisions, the driven route and its hand-over."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import topomap.core.robot
from sim2d import worlds
from sim2d.body import Body
from sim2d.config import BodyConfig, CameraConfig, DriverConfig, LaserConfig, OdometerConfig, SimConfig
from sim2d.driver import Driver
from sim2d.errors import WorldError
from sim2d.path import of_route
from sim2d.records import EPOCH_NS
from sim2d.robot import SimRobot
from sim2d.sensors.odometer import Odometer
from sim2d.shapes import Box, Cylinder, Look, Wall
from sim2d.streams import stream
from sim2d.world import World

SMALL = SimConfig(camera=CameraConfig(width=72, height=20, forward_column=36), laser=LaserConfig(rays=36))


@dataclass(frozen=True)
class Wish:
    forward: float
    turn: float


def test_fits_the_contracts() -> None:
    sim = SimRobot(worlds.load("room-corridor"), SimConfig(), 0)
    robot: topomap.core.robot.Robot = sim
    source: topomap.core.robot.TruthSource = sim
    reading: topomap.core.robot.Reading | None = robot.sense()
    assert reading is not None
    motion: topomap.core.robot.MotionReading = reading.motion
    rig: topomap.core.robot.RigReading = reading.rig
    truth: topomap.core.robot.Truth | None = source.truth()
    assert truth is not None
    assert reading.image.shape == (rig.height, rig.width, 3) == (100, 720, 3)
    assert reading.image.dtype == np.uint8
    assert (motion.forward, motion.left, motion.turn) == (0.0, 0.0, 0.0)
    assert np.linalg.eigvalsh(motion.covariance).min() > 0
    assert (rig.horizon_row, rig.forward_column, rig.clockwise) == (49.5, 360, True)
    assert rig.focal == pytest.approx(720 / math.tau)
    assert reading.ranges is not None
    assert reading.ranges.shape == (720,)
    assert reading.ranges.dtype == np.float32
    assert reading.driven
    assert reading.stamp_ns == truth.stamp_ns == EPOCH_NS
    assert (truth.x, truth.y, truth.heading) == pytest.approx((4.0, 1.2, 0.0), abs=1e-6)


def test_a_landmark_to_the_left_is_where_the_convention_says() -> None:
    """The partition begins 1.4 m to the left of the start: range entry W/4."""
    reading = SimRobot(worlds.load("room-corridor"), SimConfig(), 1).sense()
    assert reading is not None
    assert reading.ranges is not None
    left, right = (float(np.nanmedian(reading.ranges[k - 5 : k + 6])) for k in (180, 540))
    assert left == pytest.approx(1.4, abs=0.02)
    assert right == pytest.approx(1.2, abs=0.02)


def test_same_seed_same_bytes_other_seed_other_bytes() -> None:
    def run(seed: int) -> list[tuple[bytes, bytes, float, float]]:
        robot = SimRobot(worlds.load("hall"), SMALL, seed)
        readings = [robot.sense() for _ in range(12)]
        return [
            (r.encoded, r.ranges.tobytes(), r.motion.forward, r.motion.turn)
            for r in readings
            if r is not None and r.ranges is not None
        ]

    assert run(4) == run(4)
    assert run(4)[3] != run(5)[3]


def test_substreams_do_not_touch_each_other() -> None:
    def motions(config: SimConfig) -> list[tuple[float, float]]:
        robot = SimRobot(worlds.load("room-corridor"), config, 7)
        readings = [robot.sense() for _ in range(8)]
        return [(r.motion.forward, r.motion.turn) for r in readings if r is not None]

    silent = SMALL.model_copy(
        update={"camera": SMALL.camera.model_copy(update={"noise": 0.0}), "laser": LaserConfig(rays=9, noise=0.0)}
    )
    assert motions(SMALL) == motions(silent)


def drive(world: World, config: SimConfig) -> tuple[list[tuple[float, float, float]], bool]:
    """Drive a route without senses; return poses and whether the body ever touched anything."""
    path = of_route(world.spec.route, config.driver.laps, config.driver.lateral_offset)
    driver = Driver(path, config.driver, config.body)
    body = Body(world, config.body, *path.at(0.0), path.heading(0.0))
    poses, contact = [(body.x, body.y, body.heading)], False
    while not driver.done and len(poses) < 4000:
        body.advance(*driver.command(body.x, body.y, body.heading), config.body.step)
        world.open_gates(driver.laps)
        contact |= body.contact
        poses.append((body.x, body.y, body.heading))
    return poses, contact


@pytest.mark.parametrize("name", ["hall", "office-loop", "room-corridor"])
def test_the_driver_completes_each_route_without_contact(name: str) -> None:
    world = worlds.load(name)
    poses, contact = drive(world, SimConfig())
    path = of_route(world.spec.route)
    assert not contact
    assert len(poses) < 4000
    assert math.dist(poses[-1][:2], path.points[-1]) < 0.1
    steps = np.diff(np.array(poses), axis=0)
    assert np.hypot(steps[:, 0], steps[:, 1]).max() <= 0.1 + 1e-6
    assert np.abs(steps[:, 2]).max() <= 0.8 * 0.25 + 1e-9
    assert len(poses) == pytest.approx(SimRobot(world, SimConfig(), 0).expected_steps, rel=0.02)


def test_a_lateral_offset_sets_in_on_lap_two() -> None:
    ring = worlds.load("hall").spec.route
    plain, aside = of_route(ring), of_route(ring, None, 0.3)
    apart = np.linalg.norm(plain.points - aside.points, axis=1)
    assert apart[plain.along < plain.lap].max() == 0.0
    np.testing.assert_allclose(apart[plain.along > plain.lap + 1.1], 0.3, atol=1e-6)


def test_the_hand_over() -> None:
    config = SMALL.model_copy(update={"driver": DriverConfig(laps=0.1)})
    robot = SimRobot(worlds.load("hall"), config, 0)
    robot.act(Wish(-0.4, 0.8))  # ignored: the driver has the wheels
    reading = robot.sense()
    while reading is not None and reading.driven:
        reading = robot.sense()
    before = robot.truth()
    assert robot.sense() is not None
    assert math.hypot(robot.truth().x - before.x, robot.truth().y - before.y) < 1e-9
    robot.act(Wish(-9.0, 0.0))
    robot.sense()
    assert math.hypot(robot.truth().x - before.x, robot.truth().y - before.y) == pytest.approx(0.1, abs=1e-6)
    robot.stop()
    assert robot.sense() is None


def test_the_gate_opens_in_the_second_lap() -> None:
    world = worlds.load("room-corridor")
    assert not world.open_gates(1.0)
    assert world.open_gates(2.0)


def test_a_body_does_not_pass_through_walls_but_slides() -> None:
    world = worlds.load("room-corridor")
    body = Body(world, BodyConfig(), 6.6, 5.0, 0.5)  # towards the east wall at x = 8, and a bookcase before it
    for _ in range(80):
        body.advance(0.4, 0.0, 0.25)
    assert body.contact
    assert body.x < 7.81
    assert body.y > 5.3
    free = Body(world, BodyConfig(), 4.0, 1.2, 0.0)
    free.advance(0.4, 0.0, 0.25)
    assert not free.contact


def test_the_odometer_errs_as_configured() -> None:
    config = OdometerConfig(spread=0.0)
    odometer = Odometer(config, stream(0, "drift"), stream(0, "noise"))
    readings = [odometer.read(0.1, 0.05, 0.25) for _ in range(4000)]
    forward, turn = (np.array([getattr(r, name) for r in readings]) for name in ("forward", "turn"))
    travel = 0.1 + 0.15 * 0.05
    assert forward.mean() == pytest.approx(0.095, abs=4e-4)
    assert turn.mean() == pytest.approx(1.04 * 0.05 + 0.003 * 0.1, abs=2e-4)
    assert forward.std() == pytest.approx(0.02 * math.sqrt(travel), rel=0.06)
    assert turn.std() == pytest.approx(math.radians(0.5) * math.sqrt(travel), rel=0.06)
    assert readings[0].covariance[0, 0] == pytest.approx(forward.var(), rel=0.12)


def test_drift_varies_by_seed_within_its_spread() -> None:
    drawn = [Odometer(OdometerConfig(), stream(s, "drift"), stream(s, "noise")).calibration for s in range(30)]
    scales = np.array([c.rotation_scale for c in drawn])
    assert scales.min() >= 1.04 - 0.008
    assert scales.max() <= 1.04 + 0.008
    assert scales.std() > 0.002


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"boxes": (Box(((0, 0), (0, 1), (1, 1), (1, 0)), 1.0, Look((1, 1, 1))),)}, "counter-clockwise"),
        ({"cylinders": (Cylinder(1, 1, -0.1, 1.0, Look((1, 1, 1))),)}, "radius above 0"),
        ({"walls": (Wall(((0, 0),), 1.0, Look((1, 1, 1))),)}, "two points"),
        ({"walls": (Wall(((0, 0), (1, 0)), float("nan"), Look((1, 1, 1))),)}, "heights are above 0"),
        ({"walls": (Wall(((0, 0), (1, 0)), 1.0, Look((1, 1, 1), "velvet")),)}, "unknown texture 'velvet'"),
    ],
)
def test_wrong_shapes_are_refused(change: dict[str, tuple[object, ...]], message: str) -> None:
    spec = replace(worlds.load("room-corridor").spec, **change)  # type: ignore[arg-type]
    with pytest.raises(WorldError, match=message):
        World(spec)


def test_a_wrong_name_lists_the_right_ones() -> None:
    with pytest.raises(WorldError, match=r"hall, .*office-loop, .*room-corridor"):
        worlds.load("rooom")
