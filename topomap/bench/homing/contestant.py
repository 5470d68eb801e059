"""Contestants: homing methods of all three contracts, bound to a goal, behind one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from topomap.core.errors import DataError
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.arena import Point
from topomap.vision.compass import ALIGNERS, GivenHeading
from topomap.vision.contracts import Aligner, GoalView, HomingMethod, HomingPolicy, ReferenceHoming, ViewSource
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS
from topomap.vision.registry import method

GIVEN = "given"
TOLD = GivenHeading()  # the bench measures its compass beforehand and tells every method the same rotation
ROWS: Mapping[str, str] = {
    "A1": "visual-compass",
    "A2": "scale-plane",
    "A3": "phase-correlation",
    "A4": "phase-scale",
    "A5": "rearrangement",
    "A6": "min-warping",
    "A8": "convergence-points",
}
"""Names of METHODS.md's rows that stand for one aligner."""


Looks = Callable[[float, float], Panorama]
"""From an offset [m] from the goal, along its x and y, to the view there, looking the goal's way."""


class Contestant(Protocol):
    """A method under a name of its own, so that variants of one method compete as well.

    key: all that decides its answers; policy: the method where it acts and looks, which has no field of vectors.
    """

    @property
    def name(self) -> str: ...
    @property
    def key(self) -> str: ...
    @property
    def policy(self) -> HomingPolicy[Any] | None: ...

    def bind(self, goal: Panorama, around: Looks) -> Bound:
        """Return the method bound to a goal. Raises DataError when the view lacks what the method needs."""


@dataclass(frozen=True, slots=True)
class Pairwise:
    """A method that compares two panoramas."""

    name: str
    method: HomingMethod[Any]  # Any: each method keeps its own kind of description
    policy: None = None

    @property
    def key(self) -> str:
        """Class and parameters."""
        return f"{type(self.method).__module__}.{self.method!r}"

    def bind(self, goal: Panorama, around: Looks) -> Bound:
        """Return the method bound to a goal. Raises DataError."""
        self.method.needs.check(goal)
        return Bound(AlignedHoming(TOLD, self.method), goal)


@dataclass(frozen=True, slots=True)
class Referenced:
    """A method that compares with views around the goal; step [m]: how far they are off, None: the method's own."""

    name: str
    method: ReferenceHoming
    step: float | None = None
    policy: None = None

    @property
    def key(self) -> str:
        """Class and parameters."""
        return f"{type(self.method).__module__}.{self.method!r} {self.step}"

    def bind(self, goal: Panorama, around: Looks) -> Bound:
        """Return the method bound to a goal and its references. Raises DataError."""
        self.method.needs.check(goal)
        step = self.step or self.method.step
        return Bound(AlignedHoming(TOLD, self.method), GoalView(goal, around(step, 0.0), around(0.0, step), step))


@dataclass(frozen=True, slots=True)
class Acting:
    """A policy: it moves and looks, so it has walks but no field of vectors."""

    name: str
    policy: HomingPolicy[Any]

    @property
    def key(self) -> str:
        """Class and parameters."""
        return f"{type(self.policy).__module__}.{self.policy!r}"

    def bind(self, goal: Panorama, around: Looks) -> Bound:
        """Return a bound method that never answers. Raises DataError."""
        self.policy.needs.check(goal)
        return Bound(AlignedHoming(TOLD, self.policy), goal)


@dataclass(frozen=True, slots=True)
class Bound:
    """A method that knows its goal."""

    homing: AlignedHoming
    goal: Panorama | GoalView

    @property
    def aligned(self) -> bool:
        """Whether the method needs aligned views."""
        return self.homing.method is not None and self.homing.method.needs.compass

    def direction(self, seen: Panorama, heading: float, rotation: float) -> float:
        """Return the direction of home in the world [rad], NaN where the method has no answer.

        seen: the view at a heading [rad]; rotation [rad]: what the compass says of the view against the goal's.
        """
        found = self.homing.ask(seen, self.goal, rotation)
        return wrap(found.bearing + heading) if found.confidence > 0.0 else float("nan")


def contestants(names: str) -> list[Contestant]:
    """Return the methods of a comma-separated list, or every one for "all". Raises DataError for an unknown name."""
    known = [*METHODS, *REFERENCE_METHODS, *POLICIES]
    wanted = known if names == "all" else [word.strip() for word in names.split(",") if word.strip()]
    if not wanted:
        raise DataError("no homing method is named; say names or 'all'")
    return [contestant(name) for name in dict.fromkeys(wanted)]


def contestant(name: str) -> Contestant:
    """Return the method of a name. Raises DataError for an unknown one."""
    found = method(name)
    if isinstance(found, HomingMethod):
        return Pairwise(name, found)
    return Acting(name, found) if isinstance(found, HomingPolicy) else Referenced(name, found)


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
