"""The study of occluded landmarks: ALV, ACV and DELV on a ring of pillars, some of them missing (2.11)."""

from __future__ import annotations

import math

import numpy as np

from topomap.bench.homing.contestant import Bound, Pairwise
from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.evaluation.statistics import angular_errors, mean_interval
from topomap.experiments.pillars import Pillar, Room, plain
from topomap.experiments.study import Curve, Finding, Lab, curves_finding
from topomap.vision.homing.acv import AverageCorrectionalVector
from topomap.vision.homing.alv import AverageLandmarkVector
from topomap.vision.homing.delv import DistanceLandmarkVector

PILLARS = 12
RADIUS = 0.12
WALL = 4.0
HIDDEN = (0, 1, 2, 3, 4, 6)


def pillar_ring(rng: np.random.Generator, hidden: frozenset[int] = frozenset()) -> Room:
    """Return a white room with coloured pillars on a ring of 2.0 to 3.0 m, placed and coloured by `rng`.

    hidden: indices of pillars that aren't there.
    """
    angles = np.arange(PILLARS) * TAU / PILLARS + rng.uniform(-0.15, 0.15, PILLARS)
    reach = rng.uniform(2.0, 3.0, PILLARS)
    colours = rng.integers(30, 200, (PILLARS, 3)).tolist()
    pillars = [
        Pillar(float(r * math.cos(a)), float(r * math.sin(a)), RADIUS, (red, green, blue))
        for a, r, (red, green, blue) in zip(angles, reach, colours, strict=True)
    ]
    return Room([one for k, one in enumerate(pillars) if k not in hidden], WALL, plain((235, 235, 235)))


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
        bound = _bound(one, pillar_ring(np.random.default_rng(seed)))
        rng = np.random.default_rng([seed, missing])
        for k in range(24):
            angle, reach = k * TAU / 24, 0.4 + 0.4 * (k % 3)
            hidden = frozenset(int(i) for i in rng.choice(PILLARS, missing, replace=False))
            world = pillar_ring(np.random.default_rng(seed), hidden)
            seen = world.view(reach * math.cos(angle), reach * math.sin(angle), 0.0)
            errors.append(angular_errors(np.array([bound.direction(seen, 0.0, 0.0)]), np.array([angle + math.pi]))[0])
    return np.array(errors)


def _bound(one: Pairwise, world: Room) -> Bound:
    return one.bind(world.view(0.0, 0.0, 0.0), lambda dx, dy: world.view(dx, dy, 0.0))
