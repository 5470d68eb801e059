"""The simulated robot: world, body, senses and driver behind `sense`, `act`, `stop` and `truth`."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim2d.body import Body
from sim2d.config import SimConfig
from sim2d.crowd import crowd
from sim2d.driver import STUCK_S, Driver
from sim2d.errors import WorldError
from sim2d.events import Events
from sim2d.path import of_route
from sim2d.records import EPOCH_NS, CameraRig, OdometerReading, SetDown, SimReading, SimTruth, TrueCalibration
from sim2d.sensors.camera import Camera
from sim2d.sensors.laser import Laser
from sim2d.sensors.odometer import Odometer, joined
from sim2d.sensors.odometry_faults import OdometryFaults
from sim2d.sensors.way import Way
from sim2d.start import start_pose
from sim2d.streams import stream
from sim2d.world import World


class Wheels(Protocol):
    """A command: forward [m/s], turn [rad/s]."""

    @property
    def forward(self) -> float: ...
    @property
    def turn(self) -> float: ...


class SimRobot:
    """A robot in a world of its own. The driver has the wheels until the route is over; then commands count.

    Raises WorldError where the driver can't go on.

    The first reading is at the start pose; each later `sense` first moves for one step. Same world, config, seed and
    commands: same readings.
    """

    def __init__(self, world: World, config: SimConfig, seed: int, set_down: SetDown | None = None) -> None:
        """set_down: where it begins with the route behind it and nobody driving; None: where the route begins."""
        self.world = world
        self._config = config
        self._driver = Driver(
            of_route(world.spec.route_named(config.driver.route), config.driver.laps, config.driver.lateral_offset),
            config.driver,
            config.body,
        )
        path = self._driver.path
        world.add_people(crowd(path, config.people, stream(seed, "people"), config.body.max_speed))
        self._driver.progress = config.start.along or 0.0
        self._driven = set_down is None and config.driver.teaches
        if set_down is not None:
            self._driver.progress = path.length
        start = start_pose(world, path, config.start) if set_down is None else set_down.pose
        self._body = Body(world, config.body, *start)
        self._camera = Camera(
            config.camera, stream(seed, "image noise"), stream(seed, "camera body"), config.floor_gloss
        )
        self._missing, self._repeated = stream(seed, "missing frames"), stream(seed, "repeated frames")
        self._frame: tuple[NDArray[np.uint8], bytes] | None = None
        blind = config.laser.scanner == "none"
        self._laser = None if blind else Laser(config.laser, stream(seed, "range noise"), config.camera.width)
        streams = (stream(seed, name) for name in ("drift", "odometry noise", "slip", "floor and load"))
        self._odometer = Odometer(config.odometer, *streams)
        self._way = Way(config.body.step, (self._body.x, self._body.y, self._body.heading))
        self._events = Events(world, config, self._body, self._driver, self._camera)
        self._faults = OdometryFaults(config.odometry_faults, stream(seed, "odometry faults"))
        self._wheels = (0.0, 0.0)
        self._stopped = False
        self._first = 0 if set_down is None else set_down.step
        self._steps = self._first - 1
        self._handed_over = None if self._driven else self._first

    @property
    def true_calibration(self) -> TrueCalibration:
        """The systematic odometry errors drawn for this run."""
        return self._odometer.calibration

    @property
    def rig(self) -> CameraRig:
        """The camera's rig, as each reading carries it."""
        return self._camera.rig

    @property
    def route_length_m(self) -> float:
        """Length of the taught route [m]."""
        return self._driver.path.length

    @property
    def expected_steps(self) -> int:
        """About how many readings the taught route takes."""
        if not self._config.driver.teaches:
            return 1
        return math.ceil(self.route_length_m / self.step_m) + 3

    @property
    def step_m(self) -> float:
        """Way from one reading to the next at full speed [m]."""
        return self._config.body.max_speed * self._config.body.step

    def sense(self) -> SimReading | None:
        """Move for one step (not before the first reading) and return what is sensed, or None after `stop`.

        A step whose frame is missing gives no reading; the next reading's motion covers it as well.
        """
        if self._stopped:
            return None
        self._steps += 1
        begun = self._steps > self._first
        motion = self._move() if begun else self._odometer.read(0.0, 0.0, 0.0)
        while begun and self._frame_is_missing():
            self._steps += 1
            motion = joined(motion, self._move())
        image, encoded = self._shoot()
        return SimReading(
            stamp_ns=self._stamp(),
            image=image,
            encoded=encoded,
            ranges=self._scan(),
            motion=motion,
            rig=self._camera.rig,
            contact=self._body.contact,
            driven=self._driven,
        )

    def _scan(self) -> NDArray[np.float32] | None:
        if self._laser is None:
            return None
        return self._laser.scan(self.world, *self._way.back(self._config.laser.lag))

    def act(self, command: Wheels) -> None:
        """Set the wheels for the steps to come; ignored while the driver has them."""
        if not self._driven and not self._stopped:
            self._wheels = (float(command.forward), float(command.turn))

    def rest(self) -> None:
        """Stop the wheels until the next command."""
        if not self._driven:
            self._wheels = (0.0, 0.0)

    def put(self, x: float, y: float, heading: float) -> None:
        """Set the robot down somewhere else [m, rad], which no wheel notices."""
        self._body.put(x, y, heading)

    def stop(self) -> None:
        """Stop the wheels for good."""
        self._stopped = True
        self._wheels = (0.0, 0.0)

    def truth(self) -> SimTruth:
        """Return the true pose at the last reading's stamp, in the world's frame."""
        heading = math.remainder(self._body.heading, math.tau)
        return SimTruth(self._stamp(), self._body.x, self._body.y, heading, self._body.contact)

    def _shoot(self) -> tuple[NDArray[np.uint8], bytes]:
        """Return this step's frame, or the last one again where the camera repeats it."""
        camera, dt = self._config.camera, self._config.body.step
        again = camera.repeated > 0 and self._repeated.random() < camera.repeated
        if self._frame is None or not again:
            pose, before = self._way.back(camera.lag), self._way.back(camera.lag + dt)
            self._frame = self._camera.shoot(self.world, *pose, before, dt if self._steps else 0.0)
        return self._frame

    def _move(self) -> OdometerReading:
        """Drive one step and read the odometer."""
        dt = self._config.body.step
        seconds = (self._steps - 1) * dt
        if self._driven:
            self._wheels = self._driver.command(self._body.x, self._body.y, self._body.heading)
            if self._driver.stuck:
                at = f"x = {self._body.x:.2f}, y = {self._body.y:.2f} m"
                raise WorldError(f"the driver has been stuck for {STUCK_S:g} s at {at}: the route can't be driven so")
            # the reading at standstill is the first that the stack answers
            self._driven = not self._driver.done
            self._handed_over = None if self._driven else self._steps
        self._events.before_step(seconds)
        way, turn = self._body.advance(*self._wheels, dt)
        blocked = self._body.wanted(self._wheels[0], dt) - way
        place = self._body.x, self._body.y
        alone = None if self._handed_over is None else (self._steps - self._handed_over) * dt
        if self._events.carry_away(seconds + dt, alone):
            self._way = Way(dt, (self._body.x, self._body.y, self._body.heading))
        else:
            self._way.extend((*place, self._body.heading))
        motion = self._odometer.read(way, turn, dt, blocked, self._body.contact, place)
        return self._faults.spoil(motion, seconds + dt, alone)

    def _frame_is_missing(self) -> bool:
        share = self._config.camera.missing
        return share > 0 and self._missing.random() < share

    def _stamp(self) -> int:
        return EPOCH_NS + max(self._first, self._steps) * round(self._config.body.step * 1e9)
