"""What happens around the robot, step by step: doors, moved things, people, other light, being carried away."""

from __future__ import annotations

import math

from sim2d.body import Body
from sim2d.changes import Changes
from sim2d.config import KidnapConfig, LightChange, SimConfig
from sim2d.driver import Driver
from sim2d.errors import WorldError
from sim2d.sensors.camera import Camera
from sim2d.world import World

Pose = tuple[float, float, float]
HOUR_STEP = 0.05  # [h] in which the sun turns by half a degree: its patch moves by 2 cm on the floor


class Events:
    """Carries out what is due before each step. Raises WorldError where somebody is carried to an unknown place."""

    def __init__(self, world: World, config: SimConfig, body: Body, driver: Driver, camera: Camera) -> None:
        self._world, self._body, self._driver, self._camera = world, body, driver, camera
        self._changes = Changes(world)
        self._lights: list[LightChange] = list(config.camera.light_changes)
        for kidnap in config.kidnaps:
            check_place(world, kidnap)
        self._kidnaps = list(config.kidnaps)
        self._dt = config.body.step
        self._rate, self._since = config.camera.hour_rate, 0.0

    def before_step(self, seconds: float) -> None:
        """Do what is due at `seconds` of run time, and let people set out on the step."""
        robot = (self._body.x, self._body.y, self._body.radius)
        self._changes.update(self._driver.laps, seconds, self._driver.progress, robot)
        self._change_lights(seconds)
        self._world.people.start(seconds, self._dt, robot, self._along())

    def _along(self) -> float:
        """Return how far the robot is on the route [m]; once the driver is done, by the nearest point of it."""
        path = self._driver.path
        if not self._driver.done or not self._world.people.accompany:
            return self._driver.progress
        return path.nearest(self._body.x, self._body.y)

    def carry_away(self, seconds: float, handed_over_s: float | None) -> bool:
        """Put the robot where it is carried to, once that is due; the route goes on at its nearest point.

        seconds: of run time; handed_over_s: since the driver handed over, None before. Returns whether it was carried.
        """
        due = [k for k in self._kidnaps if _has_come(k, seconds, handed_over_s)]
        for kidnap in due:
            self._kidnaps.remove(kidnap)
            x, y, heading = self._carried_to(kidnap)
            self._body.put(x, y, heading + math.radians(kidnap.turn_deg))
            path = self._driver.path
            if not self._driver.done:
                self._driver.progress = path.nearest(x, y)
        return bool(due)

    def _carried_to(self, kidnap: KidnapConfig) -> Pose:
        """Return the pose a kidnap ends at, without its turn on the spot."""
        here = self._body.x, self._body.y, self._body.heading
        if kidnap.place:
            return self._world.spec.places[kidnap.place]
        if kidnap.x is not None and kidnap.y is not None:
            return kidnap.x, kidnap.y, math.radians(kidnap.heading_deg)
        return self._driver.path.beside(here, kidnap.along or 0.0)

    def _change_lights(self, seconds: float) -> None:
        due = [change for change in self._lights if _is_due(change, self._driver.laps, seconds)]
        for change in due:
            self._lights.remove(change)
            self._camera.hour = change.hour
            self._since = seconds
        self._pass_time(seconds)

    def _pass_time(self, seconds: float) -> None:
        """Let the day go on, in steps that are worth painting the world anew for."""
        passed = (seconds - self._since) / 3600 * self._rate
        if self._camera.hour is not None and passed >= HOUR_STEP:
            self._camera.hour = (self._camera.hour + passed) % 24
            self._since = seconds


def _is_due(change: LightChange, laps: float, seconds: float) -> bool:
    if change.at_s is not None:
        return change.at_s <= seconds
    return change.at_lap is not None and change.at_lap <= laps


def _has_come(kidnap: KidnapConfig, seconds: float, handed_over_s: float | None) -> bool:
    if kidnap.at_s is not None:
        return kidnap.at_s <= seconds
    return handed_over_s is not None and kidnap.handed_over_s is not None and kidnap.handed_over_s <= handed_over_s


def check_place(world: World, kidnap: KidnapConfig) -> None:
    """Refuse an unknown place before the robot sets out. Raises WorldError."""
    if kidnap.place and kidnap.place not in world.spec.places:
        known = ", ".join(world.spec.places) or "none"
        raise WorldError(f"world {world.name} has no place {kidnap.place!r} to carry the robot to; there are {known}")
