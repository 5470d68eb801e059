"""Contestants: homing methods of all three contracts, bound to a goal, behind one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from topomap.contract import Aligner, HomingMethod, ViewSource
from topomap.errors import DataError
from topomap.geometry import TAU, Pose2, wrap
from topomap.study.homing_arena import Point
from topomap.types import HomeVector
from topomap.vision.alignment import ALIGNERS
from topomap.vision.homing import METHODS, check
from topomap.vision.panorama import Panorama

GIVEN = "given"
ROWS: Mapping[str, str] = {
    "A1": "visual-compass",
    "A6": "min-warping",
}
"""Names of METHODS.md's rows that stand for one aligner."""


@dataclass(frozen=True, slots=True)
class Contestant:
    """A method under a name of its own, so that variants of one method compete as well."""

    name: str
    method: HomingMethod[Any]  # Any: each method keeps its own kind of description

    @property
    def key(self) -> str:
        """All that decides its answers: class and parameters."""
        return f"{type(self.method).__module__}.{self.method!r}"

    def bind(self, goal: Panorama) -> Bound:
        """Return the method bound to a goal. Raises DataError when the view lacks what the method needs."""
        check(self.method.needs, goal)
        described = self.method.describe(goal)
        return Bound(lambda seen: self.method.home(self.method.describe(seen), described), self.method.needs.compass)


@dataclass(frozen=True, slots=True)
class Bound:
    """A method that knows its goal: from the current view to a home vector; aligned: it needs aligned views."""

    home: Callable[[Panorama], HomeVector]
    aligned: bool

    def direction(self, seen: Panorama, heading: float, rotation: float) -> float:
        """Return the direction of home in the world [rad], NaN where the method has no answer.

        seen: the view at a heading [rad]; rotation [rad]: what the compass says of the view against the goal's.
        """
        columns = seen.columns(rotation) if self.aligned else 0
        found = self.home(seen.rolled(columns) if columns else seen)
        if found.confidence <= 0.0:
            return float("nan")
        return wrap(found.bearing - columns * TAU / seen.rig.width + heading)


def contestants(names: str) -> list[Contestant]:
    """Return the methods of a comma-separated list, or every one for "all". Raises DataError for an unknown name."""
    wanted = list(METHODS) if names == "all" else [word.strip() for word in names.split(",") if word.strip()]
    for name in wanted:
        if name not in METHODS:
            raise DataError(f"unknown homing method {name!r}; there are {', '.join(METHODS)}")
    if not wanted:
        raise DataError("no homing method is named; say names or 'all'")
    return [Contestant(name, METHODS[name]) for name in dict.fromkeys(wanted)]


def compass(name: str) -> Aligner | None:
    """Return the aligner of a name or row (A1, A6), None for a given compass. Raises DataError."""
    if name == GIVEN:
        return None
    known = ROWS.get(name.upper(), name)
    if known not in ALIGNERS:
        raise DataError(f"unknown compass {name!r}; there are {GIVEN}, {', '.join([*ROWS, *ALIGNERS])}")
    return ALIGNERS[known]


def view_at(source: ViewSource, point: Point, heading: float = 0.0) -> Panorama:
    """Return the view at a point [m] and heading [rad]."""
    return source.view(point[0], point[1], heading)


def pose_at(point: Point, heading: float = 0.0) -> Pose2:
    """Return the pose at a point [m] with a heading [rad]."""
    return Pose2(point[0], point[1], heading)
