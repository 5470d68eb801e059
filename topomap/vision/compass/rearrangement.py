"""A5, landmark rearrangement: the rotation under which matched landmarks agree where the robot stands (2.6.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.landmarks import EDGES, EdgeSpec, Landmarks, edges


@dataclass(frozen=True, slots=True)
class Rearrangement:
    """For each rotation match the landmarks, localise from every pair, keep the rotation of least scatter.

    Pairs are weighed with colour, as ranges alone fit four ways in a square room. rotations: how many are tried;
    slack [rad]: how much bearing counts against looks; metre: how much scatter [m] counts as unlike as strangers.
    Needs ranges; gives the position as well. Raises DataError, ShapeError.
    """

    origin: ClassVar[Origin] = Origin("A5", "2.6.4.3")
    needs: ClassVar[Needs] = Needs(ranges=True)
    claims_homing: ClassVar[bool] = True
    recipe: EdgeSpec = EDGES
    rotations: int = 180
    slack: float = math.radians(40.0)
    metre: float = 0.5
    window: float = math.radians(45.0)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the rotation [rad], the scatter as residual, and the home vector."""
        for view in (current, goal):
            self.needs.check(view)
        same_views(current, goal)
        here, there = edges(current, self.recipe), edges(goal, self.recipe)
        if len(here) < 3 or len(there) < 3 or not np.isfinite(here.metres).all() or not np.isfinite(there.metres).all():
            return Alignment(wrap(prior or 0.0), 1.0, HomeVector(0.0, None, 0.0))
        turns = np.arange(self.rotations, dtype=np.float64) * (TAU / self.rotations)
        unlike = np.sqrt(np.square(there.looks[:, np.newaxis] - here.looks[np.newaxis]).mean(axis=2))
        found = [self._scatter(here, there, unlike, turn) for turn in turns]
        cost = np.array([f[0] for f in found])
        if prior is not None:
            cost = np.where(np.abs(wrap_all(turns - prior)) <= self.window, cost, np.inf)
        k = int(cost.argmin())
        turn, position = float(turns[k]) + found[k][2], found[k][1]
        bearing = math.atan2(-float(position[1]), -float(position[0])) - turn
        distance = float(np.hypot(*position))
        sure = min(max(1.0 - float(cost[k]), 0.0), 1.0) if distance > 1e-6 else 0.0
        return Alignment(wrap(turn), float(cost[k]), HomeVector(wrap(bearing), distance, sure))

    def _scatter(
        self, here: Landmarks, there: Landmarks, unlike: FloatArray, turn: float
    ) -> tuple[float, FloatArray, float]:
        """Return cost, position [m] of the current place in the goal's frame, and what turns better [rad]."""
        bearings = here.bearings + turn
        apart = np.abs(wrap_all(there.bearings[:, np.newaxis] - bearings[np.newaxis]))
        cost = unlike + apart / self.slack
        g, c = cost.argmin(axis=0), np.arange(len(here))
        goal_points = _points(there.bearings[g], there.metres[g])
        own_points = _points(bearings, here.metres)
        where = goal_points - own_points
        position = np.median(where, axis=0)
        miss = np.hypot(*(where - position).T)
        robust = miss**2 / (miss**2 + self.metre**2)
        weight = (1.0 - robust) * here.metres
        across = goal_points - position
        swing = wrap_all(np.arctan2(across[:, 1], across[:, 0]) - bearings)
        better = float(np.sum(weight * np.clip(swing, -0.1, 0.1)) / max(float(weight.sum()), 1e-9))
        return float(np.mean(robust + np.minimum(unlike[g, c], 1.0)) / 2.0), np.asarray(position, np.float64), better


def _points(bearings: FloatArray, metres: FloatArray) -> FloatArray:
    return np.asarray(metres[:, np.newaxis] * np.column_stack([np.cos(bearings), np.sin(bearings)]), np.float64)
