"""A homing method of one's own drives the robot: it is taught a short way, then goes back by that method alone."""

import math

import numpy as np

from topomap.app.config import StackConfig, load_config
from topomap.app.runs import open_world
from topomap.app.wiring import build_navigator
from topomap.core.records import HomeVector
from topomap.navigation.runner import run
from topomap.navigation.traveller import TravelSettings
from topomap.vision.homing import Needs


class Openness:
    needs, claims_homing = Needs(compass=True, ranges=True), True  # views turned to look the goal's way

    def describe(self, view):  # the mean vector of the ranges points to where there is room ...
        return np.nanmean(view.ranges * np.exp(1j * np.linspace(0, math.tau, view.rig.width, endpoint=False)))

    def home(self, current, goal):  # ... and to the goal, where there was less of it
        return HomeVector(float(np.angle(current - goal)))


robot = open_world("hall", 0, load_config(None, ["sim.driver.laps=0.1"]))
navigator = build_navigator(StackConfig(travel=TravelSettings(homing=Openness())))
steps = run(robot, navigator)
off = math.dist((robot.truth().x, robot.truth().y), (7.0, 4.0))
print(f"{navigator.phase} after {steps} steps, off by {off:.2f} m")
