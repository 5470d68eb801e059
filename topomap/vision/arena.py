"""An arena: views, a grid of free positions and a plan; where homing is measured."""

from __future__ import annotations

import atexit
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.records import Plan
from topomap.vision.contracts import ViewSource

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Arena:
    """Views over a grid of free positions.

    positions (N, 2) [m]; spacing of the grid [m]; continuous: there are views between the positions as well; home:
    where to home to unless told otherwise [m]; goals: where the goal is seen from, when it was in another light.
    """

    name: str
    source: ViewSource
    positions: FloatArray
    spacing: float
    continuous: bool
    home: Point
    plan: Plan = field(default_factory=Plan)
    goals: ViewSource | None = None

    def index(self, point: Point) -> int:
        """Return the grid position nearest to a point [m]. Raises DataError where none is within 0.75 spacings."""
        distance = np.hypot(*(self.positions - np.asarray(point)).T)
        nearest = int(distance.argmin())
        if distance[nearest] > 0.75 * self.spacing:
            low, high = self.positions.min(axis=0), self.positions.max(axis=0)
            raise DataError(
                f"{self.name} has no free grid position at {point[0]:g},{point[1]:g};"
                f" its grid reaches from {low[0]:.2f},{low[1]:.2f} to {high[0]:.2f},{high[1]:.2f} m"
            )
        return nearest

    @property
    def goal_source(self) -> ViewSource:
        """Where goals and their references are seen from."""
        return self.goals or self.source

    def at(self, index: int) -> Point:
        """Return the grid position of an index [m]."""
        return float(self.positions[index, 0]), float(self.positions[index, 1])


@dataclass(frozen=True, slots=True)
class Recipe:
    """How to make an arena anew in another process: `make(name, seed, options)`; picklable and hashable.

    identity: a digest of all else that decides the views (code, files), for caches.
    """

    name: str
    seed: int
    make: Callable[[str, int, tuple[str, ...]], Arena]
    options: tuple[str, ...] = ()
    identity: str = ""

    def arena(self) -> Arena:
        """Return the arena; made once per process."""
        if self not in _MADE:
            while len(_MADE) >= KEPT:  # a world with its textures is some 100 MB
                del _MADE[next(iter(_MADE))]
            _MADE[self] = self.make(self.name, self.seed, self.options)
        return _MADE[self]


KEPT = 2
_MADE: dict[Recipe, Arena] = {}
atexit.register(_MADE.clear)  # a world freed later than its physics engine complains


def central(positions: FloatArray) -> Point:
    """Return the position (2,) nearest to the middle of positions (N, 2) [m]."""
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
    nearest = positions[int(np.hypot(*(positions - middle).T).argmin())]
    return float(nearest[0]), float(nearest[1])


def spread(positions: FloatArray, home: Point, count: int) -> list[int]:
    """Return up to `count` positions far from home and from each other, the same ones every time.

    Each next one is the farthest from all before (home first).
    """
    gap = np.hypot(*(positions - np.asarray(home)).T)
    chosen: list[int] = []
    while len(chosen) < count:
        far = int(gap.argmax())
        if not gap[far] > 1e-9:
            break
        chosen.append(far)
        gap = np.minimum(gap, np.hypot(*(positions - positions[far]).T))
    return chosen


def bearings_home(positions: FloatArray, home: Point) -> FloatArray:
    """Return the true direction of home (N,) [rad] from positions (N, 2), NaN at home itself."""
    way = np.asarray(home) - positions
    direction: FloatArray = np.arctan2(way[:, 1], way[:, 0])
    return np.where(np.hypot(way[:, 0], way[:, 1]) > 1e-9, direction, np.nan)
