"""Several home vectors as one, each by its calibrated confidence (6.1, 6.4.2: fusion)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import HomingMethod, Needs, Origin
from topomap.vision.homing.alv import AverageLandmarkVector
from topomap.vision.homing.dp_warping import DpWarping
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.scan import ScanMatching
from topomap.vision.homing.view_vector import same_views

BEARINGS: FloatArray = np.arange(720, dtype=np.float64) * (TAU / 720)
CHANCE = -1.1
"""Log odds of being within 45 deg without any evidence: a quarter of all directions is."""
MOST = 0.98
"""No single answer is believed more: six worlds don't show what happens once in a hundred."""


@dataclass(frozen=True, slots=True)
class Member:
    """A method with what its answers are worth: slope of the logistic P(error < 45 deg) over its own confidence, and
    sigma [deg], the rms error of the answers within 45 deg.
    """

    method: HomingMethod[Any]  # Any: each keeps its own kind of description
    slope: float
    sigma: float

    def density(self, home: HomeVector) -> FloatArray:
        """Return the log density (720,) over bearings that an answer stands for: a normal one or anywhere."""
        within = 1.0 / (1.0 + math.exp(-(CHANCE + self.slope * home.confidence))) if home.confidence > 0.0 else 0.0
        true = min(max((within - 0.25) / 0.75, 0.0), MOST)
        sigma = math.radians(self.sigma)
        off = np.square(wrap_all(BEARINGS - home.bearing) / sigma)
        normal = np.exp(-0.5 * off) / (sigma * math.sqrt(TAU))
        return np.asarray(np.log(true * normal + (1.0 - true) / TAU), np.float64)


MEMBERS = (
    Member(DynamicWarping(), 16.5, 9.9),
    Member(DpWarping(), 20.0, 4.7),
    Member(AverageLandmarkVector(), 8.9, 9.6),
    Member(ScanMatching(), 15.0, 0.5),
)
"""Measured on seed 1 of a1original, hall1, cylinders and ourlab and seed 2 of screen and arboreal, given compass."""


@dataclass(frozen=True, slots=True)
class Fusion:
    """Every member's answer as a density over bearings, multiplied; the peak is the answer and the mass within 45 deg
    of it the confidence. A wrong answer is outvoted, not averaged in. Members that need ranges are silent without.
    """

    origin: ClassVar[Origin] = Origin("own", "6.1, 6.4.2: fusion by calibrated confidence")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    members: tuple[Member, ...] = field(default=MEMBERS)

    def describe(self, panorama: Panorama) -> Panorama:
        """Return the panorama, which keeps what was derived from it."""
        return panorama

    def home(self, current: Panorama, goal: Panorama) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal)
        ranged = current.ranges is not None and goal.ranges is not None
        asked = [member for member in self.members if ranged or not member.method.needs.ranges]
        answers = [(member, _answer(member.method, current, goal)) for member in asked]
        if not any(home.confidence > 0.0 for _, home in answers):  # also at the goal itself, where all are silent
            return HomeVector(0.0, None, 0.0)
        return _peak(np.sum([member.density(home) for member, home in answers], axis=0))


def _answer(method: HomingMethod[Any], current: Panorama, goal: Panorama) -> HomeVector:
    here, there = (p.derived(("fusion", method), method.describe) for p in (current, goal))
    return method.home(here, there)


def _peak(density: FloatArray) -> HomeVector:
    """Return the peak, to a fraction of half a degree, and the mass within 45 degrees of it."""
    k = int(density.argmax())
    mass = np.exp(density - density[k])
    below, above = density[(k - 1) % len(density)], density[(k + 1) % len(density)]
    bend = float(below - 2.0 * density[k] + above)
    offset = min(max(0.5 * float(below - above) / bend, -0.5), 0.5) if bend < -1e-12 else 0.0
    near = np.abs(wrap_all(BEARINGS - BEARINGS[k])) <= math.pi / 4
    return HomeVector(wrap((k + offset) * TAU / len(density)), None, float(mass[near].sum() / mass.sum()))
