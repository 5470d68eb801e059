"""The study of occluded landmarks: ALV, ACV and DELV on a ring of pillars, some of them missing (2.11)."""

from __future__ import annotations

import math

import numpy as np

from topomap.geometry import TAU, FloatArray
from topomap.rig import Rig
from topomap.study.homing_contestant import Bound, Pairwise
from topomap.study.homing_statistics import angular_errors, mean_interval
from topomap.study.studies.study import Curve, Finding, Lab, curves_finding
from topomap.vision.homing.acv import AverageCorrectionalVector
from topomap.vision.homing.alv import AverageLandmarkVector
from topomap.vision.homing.delv import DistanceLandmarkVector
from topomap.vision.panorama import Panorama

PILLARS = 12
RADIUS = 0.12
WALL = 4.0
HIDDEN = (0, 1, 2, 3, 4, 6)


class PillarRing:
    """A ViewSource: coloured pillars on a ring of 2.0 to 3.0 m before a white wall, some hidden from view.

    hidden: indices of pillars that aren't there. `rng` places and colours the pillars.
    """

    def __init__(self, rng: np.random.Generator, hidden: frozenset[int] = frozenset()) -> None:
        angles = np.arange(PILLARS) * TAU / PILLARS + rng.uniform(-0.15, 0.15, PILLARS)
        reach = rng.uniform(2.0, 3.0, PILLARS)
        self.centres: FloatArray = np.column_stack([reach * np.cos(angles), reach * np.sin(angles)])
        self.colours = rng.integers(30, 200, (PILLARS, 3)).astype(np.uint8)
        self.hidden = hidden

    def view(self, x: float, y: float, heading: float) -> Panorama:
        """Return the panorama with ranges at a pose [m, rad]."""
        rig = Rig()
        angles = heading + np.arange(rig.width) * TAU / rig.width
        image = np.full((rig.height, rig.width, 3), 235, np.uint8)
        ranges = np.full(rig.width, WALL)
        for k in range(PILLARS):
            if k in self.hidden:
                continue
            dx, dy = self.centres[k] - (x, y)
            along = dx * np.cos(angles) + dy * np.sin(angles)
            across = dx * np.sin(angles) - dy * np.cos(angles)
            distance = along - np.sqrt(np.maximum(RADIUS**2 - across**2, 0.0))
            seen = (np.abs(across) < RADIUS) & (along > 0) & (distance < ranges)
            image[:, seen] = self.colours[k]
            ranges[seen] = distance[seen]
        return Panorama(image, ranges.astype(np.float32), rig)


def occluded(lab: Lab) -> Finding:
    """The error of ALV, ACV and DELV over the number of landmarks that the current view lacks (2.11)."""
    methods = [
        Pairwise("ALV, matched", AverageLandmarkVector()),
        Pairwise("ALV, all landmarks", AverageLandmarkVector(pairing="all")),
        Pairwise("ACV", AverageCorrectionalVector()),
        Pairwise("DELV", DistanceLandmarkVector()),
    ]
    curves = []
    for one in methods:
        means = [mean_interval(_errors(one, count, lab.seeds)) for count in HIDDEN]
        curves.append(
            Curve(one.name, HIDDEN, [m.value for m in means], [m.low for m in means], [m.high for m in means])
        )
        lab.advance()
    return curves_finding(
        f"Occluded landmarks, a ring of {PILLARS}", "landmarks missing in the current view",
        "mean angular error [deg]", curves,
    )  # fmt: skip


def _errors(one: Pairwise, missing: int, seeds: tuple[int, ...]) -> FloatArray:
    """Return the errors [degrees] at 24 places around home, for every seed."""
    errors = []
    for seed in seeds:
        bound = _bound(one, PillarRing(np.random.default_rng(seed)))
        rng = np.random.default_rng([seed, missing])
        for k in range(24):
            angle, reach = k * TAU / 24, 0.4 + 0.4 * (k % 3)
            hidden = frozenset(int(i) for i in rng.choice(PILLARS, missing, replace=False))
            world = PillarRing(np.random.default_rng(seed), hidden)
            seen = world.view(reach * math.cos(angle), reach * math.sin(angle), 0.0)
            errors.append(angular_errors(np.array([bound.direction(seen, 0.0, 0.0)]), np.array([angle + math.pi]))[0])
    return np.array(errors)


def _bound(one: Pairwise, world: PillarRing) -> Bound:
    return one.bind(world.view(0.0, 0.0, 0.0), lambda dx, dy: world.view(dx, dy, 0.0))
