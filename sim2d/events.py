"""What happens around the robot, step by step: doors, moved things, people, other light, being carried away."""

from __future__ import annotations

import math

import numpy as np

from sim2d.body import Body
from sim2d.camera import Camera
from sim2d.changes import Changes
from sim2d.config import KidnapConfig, LightChange, SimConfig
from sim2d.driver import Driver
from sim2d.errors import WorldError
from sim2d.world import World

Pose = tuple[float, float, float]
HOUR_STEP = 0.05  # [h] in which the sun turns by half a degree: its patch moves by 2 cm on the floor


class Events:
    """Carries out what is due before each step. Raises WorldError where somebody is carried to an unknown place."""

    def __init__(self, world: World, config: SimConfig, body: Body, driver: Driver, camera: Camera) -> None:
        self._world, self._body, self._driver, self._camera = world, body, driver, camera
        self._changes = Changes(world)
        self._lights: list[LightChange] = list(config.camera.light_changes)
        self._kidnaps = sorted(((k.at_s, carried_to(world, k)) for k in config.kidnaps), key=lambda pair: pair[0])
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
        away = np.hypot(path.points[:, 0] - self._body.x, path.points[:, 1] - self._body.y)
        return float(path.along[int(np.argmin(away))])

    def carry_away(self, seconds: float) -> bool:
        """Put the robot where it is carried to, once that is due; the route goes on at its nearest point.

        Returns whether it was carried.
        """
        carried = False
        while self._kidnaps and self._kidnaps[0][0] <= seconds:
            carried = True
            x, y, heading = self._kidnaps.pop(0)[1]
            self._body.put(x, y, heading)
            path = self._driver.path
            if not self._driver.done:
                away = np.hypot(path.points[:, 0] - x, path.points[:, 1] - y)
                self._driver.progress = float(path.along[int(np.argmin(away))])
        return carried

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


def carried_to(world: World, kidnap: KidnapConfig) -> Pose:
    """Return the pose a kidnap ends at. Raises WorldError for an unknown place."""
    if not kidnap.place:
        return kidnap.x or 0.0, kidnap.y or 0.0, math.radians(kidnap.heading_deg)
    if kidnap.place not in world.spec.places:
        known = ", ".join(world.spec.places) or "none"
        raise WorldError(f"world {world.name} has no place {kidnap.place!r} to carry the robot to; there are {known}")
    return world.spec.places[kidnap.place]
